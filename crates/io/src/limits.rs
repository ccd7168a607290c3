//! Limits the memory that a file can claim. All limits are in this file.
//!
//! Decoders check these limits before they allocate, so that a file of some kilobytes cannot claim gigabytes.

/// Maximum number of points of a grid that is read from a file or made: 2^28, or 16384 x 16384.
pub const MAX_POINTS: usize = 1 << 28;

/// Maximum ratios of decompressed to compressed bytes.
pub(super) mod ratio {
    /// No compression.
    pub const STORED: u64 = 1;
    /// PackBits and EXR's run lengths: two bytes make 128.
    pub const RUNS: u64 = 64;
    /// Deflate: two bits make 258 bytes.
    pub const DEFLATE: u64 = 1032;
    /// EXR's PXR24: three bytes become four after deflate.
    pub const DEFLATED_24: u64 = 1376;
    /// EXR's PIZ: two codes make a run of 255 values of two bytes.
    pub const PIZ: u64 = 4096;
    /// LZW with codes of 12 bits: about 2500.
    pub const LZW: u64 = 2730;
    /// Other compressions, which are unusual for files of heights.
    pub const OTHER: u64 = 4096;
}

/// Number of bytes that every file may decode to, in addition to its size times the ratio.
const ALWAYS: u64 = 64 << 10;

/// Number of bytes that the PNG decoder may use for a row and for data other than the picture. Colour profiles and
/// texts are skipped.
pub(super) const PNG_BUFFERS: usize = 64 << 20;

/// Returns the number of points of a grid, or an error if it is zero or above the limit.
pub fn checked_points(rows: usize, cols: usize) -> Result<usize, String> {
    match rows.checked_mul(cols) {
        Some(0) => {
            Err(format!("a grid of {rows} x {cols} points is empty; at least 1 x 1 is needed"))
        }
        Some(points) if points <= MAX_POINTS => Ok(points),
        _ => Err(format!(
            "a grid of {rows} x {cols} points is too large; the limit is {MAX_POINTS} points, 16384 x 16384"
        )),
    }
}

/// Returns the number of bytes to which a file of `file` bytes may decode.
pub(super) fn most_decoded(file: usize, ratio: u64) -> usize {
    let most = ALWAYS.saturating_add((file as u64).saturating_mul(ratio));
    usize::try_from(most).unwrap_or(usize::MAX)
}

/// Returns an error if a file claims more values than it can hold.
pub(super) fn check_decoded(file: usize, ratio: u64, claimed: usize) -> Result<(), String> {
    if claimed <= most_decoded(file, ratio) {
        return Ok(());
    }
    Err(format!(
        "claims {claimed} bytes of values in a file of {file} bytes, more than its compression can \
         hold; the file is cut short or damaged"
    ))
}

/// Returns an error if there is no memory for `values` values of a type.
pub(super) fn check_memory<T>(values: usize) -> Result<(), String> {
    let mut room = Vec::<T>::new();
    let there = room.try_reserve_exact(values);
    // Otherwise compilers would remove the allocation as unused.
    std::hint::black_box(&room);
    there.map_err(|_| {
        let mib = values.saturating_mul(size_of::<T>()) >> 20;
        format!("holds {values} values, which need {mib} MiB of memory, more than is available")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_may_decode_to_what_compression_can_reach() {
        // A picture of zeros, compressed by deflate at its best, and by LZW.
        for (points, best, ratio) in
            [(MAX_POINTS, 1030, ratio::DEFLATE), (MAX_POINTS, 2500, ratio::LZW)]
        {
            assert_eq!(check_decoded(points / best, ratio, points), Ok(()));
        }
        let message = check_decoded(1000, ratio::DEFLATE, 4 * MAX_POINTS).unwrap_err();
        assert!(message.contains("in a file of 1000 bytes"), "{message}");
        assert!(check_decoded(usize::MAX, ratio::DEFLATE, usize::MAX).is_ok());
    }

    #[test]
    fn sizes_beyond_memory_are_refused() {
        assert_eq!(check_memory::<f64>(1000), Ok(()));
        assert!(check_memory::<f64>(usize::MAX / 8).unwrap_err().contains("MiB of memory"));
    }
}
