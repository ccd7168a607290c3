//! TIFF: the entries of the directory.

use super::put;
use crate::bodies::dice::Dice;

/// Tags of sizes, bits, compression, colours, strips, predictor, tiles, sample formats, GDAL and GeoTIFF.
const TAGS: [u16; 30] = [
    254, 256, 257, 258, 259, 262, 266, 273, 277, 278, 279, 284, 292, 293, 317, 322, 323, 324, 325,
    338, 339, 347, 33550, 33922, 34264, 34735, 34736, 34737, 42112, 42113,
];
const COMPRESSIONS: [u16; 12] = [1, 2, 3, 4, 5, 6, 7, 8, 32773, 32946, 50000, 50001];

pub fn mutate(bytes: &mut [u8], dice: &mut Dice) {
    // The seeds are little-endian files with one directory, whose entries have 12 bytes, or 20 in BigTIFF.
    let Some(&[b'I', b'I', version, _, a, b, c, d]) = bytes.first_chunk::<8>() else { return };
    let big = version == 43;
    let directory = if big {
        let Some(place) = bytes.get(8..16) else { return };
        u64::from_le_bytes(place.try_into().unwrap()) as usize
    } else {
        u32::from_le_bytes([a, b, c, d]) as usize
    };
    let (before, entry) = if big { (8, 20) } else { (2, 12) };
    let Some(count) = bytes.get(directory..directory.saturating_add(2)) else { return };
    let count = usize::from(u16::from_le_bytes([count[0], count[1]])).max(1);
    let at = directory + before + entry * dice.below(count);
    if at + entry > bytes.len() {
        return;
    }
    match dice.below(6) {
        0 => bytes[at..at + 2].copy_from_slice(&dice.one_of(&TAGS).to_le_bytes()),
        1 => bytes[at + 2..at + 4].copy_from_slice(&(dice.below(19) as u16).to_le_bytes()),
        2 => {
            let tag = (0..count).map(|index| directory + before + entry * index).find(|&at| {
                bytes.get(at..at + entry).is_some_and(|entry| entry[..2] == 259u16.to_le_bytes())
            });
            if let Some(at) = tag {
                let value = at + entry - entry / 3;
                let compression = dice.one_of(&COMPRESSIONS).to_le_bytes();
                bytes[value..value + 2].copy_from_slice(&compression);
            }
        }
        _ => {
            let place = at + 4 + dice.below(entry - 4);
            put(&mut bytes[..at + entry], place, dice);
        }
    }
}
