//! NumPy's arrays: other types and shapes over the same data.

use super::{number, text};
use crate::bodies::dice::Dice;

const TYPES: [&str; 14] = [
    "<f4", "<f8", "<f2", ">f4", ">f8", "|b1", "|u1", "|i1", "<i2", ">u4", "<i8", "<u8", "<c16",
    "|S0",
];

/// Bytes before the header: magic number, version and size of the header, in version 1.
const BEFORE_HEADER: usize = 10;

pub fn mutate(bytes: &mut Vec<u8>, dice: &mut Dice) {
    if bytes.len() < BEFORE_HEADER {
        return;
    }
    let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let end = (BEFORE_HEADER + length).min(bytes.len());
    let header = if dice.once_in(3) {
        let mut header = bytes[BEFORE_HEADER..end].to_vec();
        text::mutate(&mut header, dice);
        header
    } else {
        let sizes: Vec<_> = (0..dice.below(5)).map(|_| size(dice).to_string()).collect();
        let (descr, order) = (dice.one_of(&TYPES), dice.one_of(&["True", "False"]));
        let shape = sizes.join(", ");
        format!("{{'descr': '{descr}', 'fortran_order': {order}, 'shape': ({shape},), }}\n").into()
    };
    let length = (header.len() as u16).to_le_bytes();
    bytes.splice(BEFORE_HEADER..end, header);
    bytes[8..BEFORE_HEADER].copy_from_slice(&length);
}

fn size(dice: &mut Dice) -> u64 {
    if dice.once_in(2) { dice.below(8) as u64 } else { number(dice) }
}
