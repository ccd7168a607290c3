//! Files made from valid ones: changes of any bytes and numbers, and changes of the parts of each format.

mod exr;
mod npy;
mod npz;
mod png;
mod text;
mod tiff;

use crate::bodies::dice::Dice;

/// Returns a size or count that may break arithmetic: a power of two from 1 to 2^64, or a neighbour of one.
pub fn number(dice: &mut Dice) -> u64 {
    let power = 1u64.checked_shl(dice.below(65) as u32).unwrap_or(0);
    power.wrapping_add(dice.below(3) as u64).wrapping_sub(1)
}

/// Returns a mutated file for the body with this name, made from one of its valid files.
pub fn mutated(name: &str, seeds: &[Vec<u8>], dice: &mut Dice) -> Vec<u8> {
    if name == "surface" && !dice.once_in(4) {
        let length = dice.below(96);
        return (0..length).map(|_| dice.byte()).collect();
    }
    let mut bytes = seeds[dice.below(seeds.len())].clone();
    for _ in 0..1 + dice.below(4) {
        if dice.once_in(2) {
            match name {
                "npy" | "matrix" => npy::mutate(&mut bytes, dice),
                "npz" => npz::mutate(&mut bytes, dice),
                "png" => png::mutate(&mut bytes, dice),
                "tiff" => tiff::mutate(&mut bytes, dice),
                "exr" => exr::mutate(&mut bytes, dice),
                _ => text::mutate(&mut bytes, dice),
            }
        } else {
            let other = &seeds[dice.below(seeds.len())];
            mutate(&mut bytes, other, dice);
        }
    }
    if name == "png" && !dice.once_in(8) {
        png::seal(&mut bytes);
    }
    bytes
}

/// Changes bytes without regard to their meaning.
fn mutate(bytes: &mut Vec<u8>, other: &[u8], dice: &mut Dice) {
    if bytes.is_empty() {
        bytes.extend_from_slice(other);
        return;
    }
    let place = dice.below(bytes.len());
    let length = 1 + dice.below((bytes.len() - place).min(64));
    match dice.below(8) {
        0 => bytes[place] = dice.byte(),
        1 => bytes[place] ^= 1 << dice.below(8),
        2 | 3 => put(bytes, place, dice),
        4 => bytes.truncate(place),
        5 => drop(bytes.drain(place..place + length)),
        6 => {
            let part = bytes[place..place + length].to_vec();
            let to = dice.below(bytes.len());
            bytes.splice(to..to, part);
        }
        _ => {
            let cut = dice.below(other.len() + 1);
            bytes.truncate(place);
            bytes.extend_from_slice(&other[cut..]);
        }
    }
}

/// Writes a [`number`] at a place, with any width and byte order.
pub fn put(bytes: &mut [u8], place: usize, dice: &mut Dice) {
    let number = number(dice);
    let width = dice.one_of(&[1, 2, 4, 8]);
    let encoded = if dice.once_in(2) {
        number.to_le_bytes()[..width].to_vec()
    } else {
        number.to_be_bytes()[8 - width..].to_vec()
    };
    for (byte, value) in bytes[place..].iter_mut().zip(encoded) {
        *byte = value;
    }
}
