//! NumPy's arrays: other types and shapes over the same data.

use super::{NUMBERS, text};
use crate::random::Random;

const TYPES: [&str; 14] = [
    "<f4", "<f8", "<f2", ">f4", ">f8", "|b1", "|u1", "|i1", "<i2", ">u4", "<i8", "<u8", "<c16",
    "|S0",
];

/// Bytes before the header: magic number, version and size of the header, in version 1.
const BEFORE_HEADER: usize = 10;

pub fn mutate(bytes: &mut Vec<u8>, random: &mut Random) {
    if bytes.len() < BEFORE_HEADER {
        return;
    }
    let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let end = (BEFORE_HEADER + length).min(bytes.len());
    let header = if random.once_in(3) {
        let mut header = bytes[BEFORE_HEADER..end].to_vec();
        text::mutate(&mut header, random);
        header
    } else {
        let sizes: Vec<_> = (0..random.below(5)).map(|_| size(random).to_string()).collect();
        let (descr, order) = (random.one_of(&TYPES), random.one_of(&["True", "False"]));
        let shape = sizes.join(", ");
        format!("{{'descr': '{descr}', 'fortran_order': {order}, 'shape': ({shape},), }}\n").into()
    };
    let length = (header.len() as u16).to_le_bytes();
    bytes.splice(BEFORE_HEADER..end, header);
    bytes[8..BEFORE_HEADER].copy_from_slice(&length);
}

fn size(random: &mut Random) -> u64 {
    if random.once_in(2) { random.below(8) as u64 } else { random.one_of(&NUMBERS) }
}
