//! PNG: chunks changed, moved and added, under checksums that are right.

use super::put;
use crate::random::Random;

const SIGNATURE: usize = 8;
const KINDS: [&[u8; 4]; 14] = [
    b"IHDR", b"PLTE", b"IDAT", b"IEND", b"tRNS", b"iCCP", b"zTXt", b"iTXt", b"tEXt", b"gAMA",
    b"acTL", b"fcTL", b"fdAT", b"sBIT",
];

pub fn mutate(bytes: &mut Vec<u8>, random: &mut Random) {
    let mut chunks = chunks(bytes);
    if chunks.is_empty() {
        return;
    }
    let which = random.below(chunks.len());
    match random.below(6) {
        // Sizes and kinds of the picture stand in the first.
        0 | 1 if !chunks[0].1.is_empty() => {
            let data = &mut chunks[0].1;
            let place = random.below(data.len());
            put(data, place, random);
        }
        2 => chunks[which].0 = *random.one_of(&KINDS),
        3 => {
            let copy = chunks[which].clone();
            chunks.insert(random.below(chunks.len() + 1), copy);
        }
        4 => drop(chunks.remove(which)),
        _ => {
            let data = &mut chunks[which].1;
            if !data.is_empty() {
                let place = random.below(data.len());
                put(data, place, random);
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

/// Kinds and data of the chunks, as far as they are whole.
fn chunks(bytes: &[u8]) -> Vec<([u8; 4], Vec<u8>)> {
    spans(bytes)
        .map(|(kind, data)| (bytes[kind..kind + 4].try_into().unwrap(), bytes[data].to_vec()))
        .collect()
}

/// Where kinds begin, and where the data after them lie.
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

/// Makes the checksums right.
pub fn seal(bytes: &mut [u8]) {
    let spans: Vec<_> = spans(bytes).collect();
    for (kind, data) in spans {
        let sum = crc32fast::hash(&bytes[kind..data.end]);
        bytes[data.end..data.end + 4].copy_from_slice(&sum.to_be_bytes());
    }
}
