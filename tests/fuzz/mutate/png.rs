//! PNG: changed, moved and added chunks with correct checksums.

use super::put;
use crate::bodies::dice::Dice;

const SIGNATURE: usize = 8;
const KINDS: [&[u8; 4]; 14] = [
    b"IHDR", b"PLTE", b"IDAT", b"IEND", b"tRNS", b"iCCP", b"zTXt", b"iTXt", b"tEXt", b"gAMA",
    b"acTL", b"fcTL", b"fdAT", b"sBIT",
];

pub fn mutate(bytes: &mut Vec<u8>, dice: &mut Dice) {
    let mut chunks = chunks(bytes);
    if chunks.is_empty() {
        return;
    }
    let which = dice.below(chunks.len());
    match dice.below(6) {
        // The first chunk has the sizes and the kind of the picture.
        0 | 1 if !chunks[0].1.is_empty() => {
            let data = &mut chunks[0].1;
            let place = dice.below(data.len());
            put(data, place, dice);
        }
        2 => chunks[which].0 = *dice.one_of(&KINDS),
        3 => {
            let copy = chunks[which].clone();
            chunks.insert(dice.below(chunks.len() + 1), copy);
        }
        4 => drop(chunks.remove(which)),
        _ => {
            let data = &mut chunks[which].1;
            if !data.is_empty() {
                let place = dice.below(data.len());
                put(data, place, dice);
            }
        }
    }
    bytes.truncate(SIGNATURE);
    for (kind, data) in chunks {
        bytes.extend((data.len() as u32).to_be_bytes());
        bytes.extend(kind);
        bytes.extend(data);
        bytes.extend([0; 4]);
    }
    seal(bytes);
}

/// Returns the kinds and data of the complete chunks.
fn chunks(bytes: &[u8]) -> Vec<([u8; 4], Vec<u8>)> {
    spans(bytes)
        .map(|(kind, data)| (bytes[kind..kind + 4].try_into().unwrap(), bytes[data].to_vec()))
        .collect()
}

/// Returns the places of the chunks' kinds, and the ranges of their data.
fn spans(bytes: &[u8]) -> impl Iterator<Item = (usize, std::ops::Range<usize>)> {
    let mut at = SIGNATURE;
    std::iter::from_fn(move || {
        let length = bytes.get(at..at + 4)?.try_into().unwrap();
        let data = at + 8..(at + 8).checked_add(u32::from_be_bytes(length) as usize)?;
        bytes.get(data.start..data.end + 4)?;
        at = data.end + 4;
        Some((data.start - 4, data))
    })
}

/// Corrects the checksums.
pub fn seal(bytes: &mut [u8]) {
    let spans: Vec<_> = spans(bytes).collect();
    for (kind, data) in spans {
        let sum = crc32fast::hash(&bytes[kind..data.end]);
        bytes[data.end..data.end + 4].copy_from_slice(&sum.to_be_bytes());
    }
}
