//! Files made from valid ones: changes of any bytes and numbers, and changes of the parts of each format.

mod exr;
mod npy;
mod npz;
mod png;
mod text;
mod tiff;

use crate::random::Random;

/// Sizes and counts that break arithmetic.
pub const NUMBERS: [u64; 20] = [
    0,
    1,
    2,
    3,
    7,
    16,
    127,
    255,
    256,
    1000,
    0x7fff,
    0xffff,
    0x1_0000,
    1 << 24,
    1 << 28,
    0x7fff_ffff,
    0xffff_ffff,
    1 << 32,
    1 << 61,
    u64::MAX,
];

/// Returns a mutated file for the body with this name, made from one of its valid files.
pub fn mutated(name: &str, seeds: &[Vec<u8>], random: &mut Random) -> Vec<u8> {
    if name == "surface" && !random.once_in(4) {
        let length = random.below(96);
        return (0..length).map(|_| random.next() as u8).collect();
    }
    let mut bytes = seeds[random.below(seeds.len())].clone();
    for _ in 0..1 + random.below(4) {
        if random.once_in(2) {
            match name {
                "npy" | "matrix" => npy::mutate(&mut bytes, random),
                "npz" => npz::mutate(&mut bytes, random),
                "png" => png::mutate(&mut bytes, random),
                "tiff" => tiff::mutate(&mut bytes, random),
                "exr" => exr::mutate(&mut bytes, random),
                _ => text::mutate(&mut bytes, random),
            }
        } else {
            let other = &seeds[random.below(seeds.len())];
            mutate(&mut bytes, other, random);
        }
    }
    if name == "png" && !random.once_in(8) {
        png::seal(&mut bytes);
    }
    bytes
}

/// Changes bytes without regard to their meaning.
fn mutate(bytes: &mut Vec<u8>, other: &[u8], random: &mut Random) {
    if bytes.is_empty() {
        bytes.extend_from_slice(other);
        return;
    }
    let place = random.below(bytes.len());
    let length = 1 + random.below((bytes.len() - place).min(64));
    match random.below(8) {
        0 => bytes[place] = random.next() as u8,
        1 => bytes[place] ^= 1 << random.below(8),
        2 | 3 => put(bytes, place, random),
        4 => bytes.truncate(place),
        5 => drop(bytes.drain(place..place + length)),
        6 => {
            let part = bytes[place..place + length].to_vec();
            let to = random.below(bytes.len());
            bytes.splice(to..to, part);
        }
        _ => {
            let cut = random.below(other.len() + 1);
            bytes.truncate(place);
            bytes.extend_from_slice(&other[cut..]);
        }
    }
}

/// Writes one of [`NUMBERS`] at a place, with any width and byte order.
pub fn put(bytes: &mut [u8], place: usize, random: &mut Random) {
    let number = random.one_of(&NUMBERS);
    let width = random.one_of(&[1, 2, 4, 8]);
    let encoded = if random.once_in(2) {
        number.to_le_bytes()[..width].to_vec()
    } else {
        number.to_be_bytes()[8 - width..].to_vec()
    };
    for (byte, value) in bytes[place..].iter_mut().zip(encoded) {
        *byte = value;
    }
}
