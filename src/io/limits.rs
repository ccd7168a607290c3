//! How much is made of a file at most: every limit in one place.
//!
//! Decoders ask before they allocate, so that a file of some kilobytes cannot claim gigabytes.

/// The largest number of grid points that is read or made: 2^28, 16384 x 16384.
pub const MAX_POINTS: usize = 1 << 28;

/// How many bytes a compression makes of one at most.
pub(super) mod ratio {
    /// None.
    pub const STORED: u64 = 1;
    /// PackBits and EXR's run lengths: 128 bytes of two.
    pub const RUNS: u64 = 64;
    /// Deflate: 258 bytes of two bits.
    pub const DEFLATE: u64 = 1032;
    /// EXR's PXR24: three bytes in four, by deflate.
    pub const DEFLATED_24: u64 = 1376;
    /// EXR's PIZ: a run of 255 values of two bytes, of two codes.
    pub const PIZ: u64 = 4096;
    /// LZW with codes of 12 bits, some 2500.
    pub const LZW: u64 = 2730;
    /// Others, which no file of heights has a reason for.
    pub const OTHER: u64 = 4096;
}

/// What any file may decode to beyond that.
const ALWAYS: u64 = 64 << 10;

/// Bytes that the PNG decoder may take for a row and for what stands beside the picture, without
/// the colour profile and texts, which are passed over.
pub(super) const PNG_BUFFERS: usize = 64 << 20;

/// The number of points of a grid, or why there cannot be so many.
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

/// Bytes that a file of so many bytes may decode to.
pub(super) fn most_decoded(file: usize, ratio: u64) -> usize {
    let most = ALWAYS.saturating_add((file as u64).saturating_mul(ratio));
    usize::try_from(most).unwrap_or(usize::MAX)
}

/// Refuses a file that claims more values than it can hold.
pub(super) fn check_decoded(file: usize, ratio: u64, claimed: usize) -> Result<(), String> {
    if claimed <= most_decoded(file, ratio) {
        return Ok(());
    }
    Err(format!(
        "claims {claimed} bytes of values in a file of {file} bytes, more than its compression can \
         hold; the file is cut short or damaged"
    ))
}

/// Refuses what memory has no room for: so many values of a type.
pub(super) fn check_memory<T>(values: usize) -> Result<(), String> {
    let mut room = Vec::<T>::new();
    let there = room.try_reserve_exact(values);
    // Else compilers leave out what nothing uses.
    std::hint::black_box(&room);
    there.map_err(|_| {
        let mib = values.saturating_mul(size_of::<T>()) >> 20;
        format!("holds {values} values, which need {mib} MiB of memory that cannot be had")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_may_decode_to_what_compression_can_reach() {
        // A picture of zeros, by deflate at its best, and by LZW.
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
    fn what_no_memory_holds_is_refused() {
        assert_eq!(check_memory::<f64>(1000), Ok(()));
        assert!(check_memory::<f64>(usize::MAX / 8).unwrap_err().contains("MiB of memory"));
    }
}
