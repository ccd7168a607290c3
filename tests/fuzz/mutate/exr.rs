//! OpenEXR: the attributes of the header.

use super::put;
use crate::bodies::dice::Dice;

/// Bytes before the header: magic number and version.
const BEFORE_HEADER: usize = 8;
const TYPES: [&str; 5] = ["compression", "box2i", "chlist", "tiledesc", "int"];

pub fn mutate(bytes: &mut Vec<u8>, dice: &mut Dice) {
    // An attribute consists of a name and a type, each ended by 0, the size of its value, and the value.
    let kind = dice.one_of(&TYPES);
    let named = [b"\0", kind.as_bytes(), b"\0"].concat();
    let places: Vec<_> = (BEFORE_HEADER..bytes.len().saturating_sub(named.len() + 4))
        .filter(|&at| bytes[at..].starts_with(&named))
        .map(|at| at + named.len())
        .collect();
    if places.is_empty() {
        if bytes.len() > BEFORE_HEADER {
            let place = 4 + dice.below(4);
            bytes[place] ^= 1 << dice.below(8);
        }
        return;
    }
    let at = dice.one_of(&places);
    let size = u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    let value = at + 4..(at + 4 + size.min(1 << 20)).min(bytes.len());
    if value.is_empty() {
        return;
    }
    match kind {
        "compression" => bytes[value.start] = dice.below(12) as u8,
        // The channels of the list are repeated once or many times.
        "chlist" if dice.once_in(2) && value.len() > 1 => {
            let channel = bytes[value.start..value.end - 1].to_vec();
            let times = dice.one_of(&[1, 2, 16, 200]);
            let channels = channel.repeat(times);
            let grown = (size + channels.len()) as u32;
            bytes[at..at + 4].copy_from_slice(&grown.to_le_bytes());
            bytes.splice(value.start..value.start, channels);
        }
        _ => {
            let place = value.start + dice.below(value.len());
            put(&mut bytes[..value.end], place, dice);
        }
    }
}
