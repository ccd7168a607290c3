//! Archives of changed arrays with correct checksums.

use rawzip::CompressionMethod;

use super::npy;
use crate::bodies::dice::Dice;
use crate::seeds;

const NAMES: [&str; 6] = ["arr_0.npy", "heights.npy", "mask.npy", "metric.npy", "a/b.npy", "x.txt"];

pub fn mutate(bytes: &mut Vec<u8>, dice: &mut Dice) {
    let arrays = seeds::of("npy");
    let files: Vec<_> = (0..1 + dice.below(2))
        .map(|_| {
            let mut array = arrays[dice.below(arrays.len())].clone();
            if !dice.once_in(4) {
                npy::mutate(&mut array, dice);
            }
            (dice.one_of(&NAMES), array)
        })
        .collect();
    let files: Vec<_> = files.iter().map(|(name, array)| (*name, &array[..])).collect();
    let methods = [CompressionMethod::STORE, CompressionMethod::DEFLATE];
    *bytes = seeds::archive(&files, dice.one_of(&methods));
}
