//! Archives of changed arrays with correct checksums.

use rawzip::CompressionMethod;

use super::npy;
use crate::random::Random;
use crate::seeds;

const NAMES: [&str; 6] = ["arr_0.npy", "heights.npy", "mask.npy", "metric.npy", "a/b.npy", "x.txt"];

pub fn mutate(bytes: &mut Vec<u8>, random: &mut Random) {
    let arrays = seeds::of("npy");
    let files: Vec<_> = (0..1 + random.below(2))
        .map(|_| {
            let mut array = arrays[random.below(arrays.len())].clone();
            if !random.once_in(4) {
                npy::mutate(&mut array, random);
            }
            (random.one_of(&NAMES), array)
        })
        .collect();
    let files: Vec<_> = files.iter().map(|(name, array)| (*name, &array[..])).collect();
    let methods = [CompressionMethod::STORE, CompressionMethod::DEFLATE];
    *bytes = seeds::archive(&files, random.one_of(&methods));
}
