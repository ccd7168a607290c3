//! How much is made of a file at most: every limit in one place.
//!
//! Decoders ask before they allocate, so that a file of some kilobytes cannot claim gigabytes.

/// The largest number of grid points that is read or made: 2^28, 16384 x 16384.
pub const MAX_POINTS: usize = 1 << 28;

/// What any compressed file may decode to.
const DECODED_ALWAYS: u64 = 64 << 20;
/// What a compressed file may decode to for each of its own bytes. Deflate reaches 1032, LZW with
/// codes of 12 bits some 2500.
const DECODED_PER_BYTE: u64 = 4096;

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

/// Bytes that a compressed file of so many bytes may decode to.
pub(super) fn most_decoded(file: usize) -> usize {
    let most = DECODED_ALWAYS.saturating_add((file as u64).saturating_mul(DECODED_PER_BYTE));
    usize::try_from(most).unwrap_or(usize::MAX)
}

/// Refuses a compressed file that claims far more values than it can hold.
pub(super) fn check_decoded(
    file: usize,
    points: usize,
    bytes_of_point: usize,
) -> Result<(), String> {
    let claimed = points.saturating_mul(bytes_of_point);
    if claimed <= most_decoded(file) {
        return Ok(());
    }
    Err(format!(
        "claims {claimed} bytes of values in a file of {file} bytes, more than compression can \
         hold; the file is cut short or damaged"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_may_decode_to_what_compression_can_reach() {
        // A picture of zeros, by deflate at its best, and by LZW.
        for (points, ratio) in [(MAX_POINTS, 1032), (MAX_POINTS, 2500)] {
            assert_eq!(check_decoded(points / ratio, points, 1), Ok(()));
        }
        assert!(
            check_decoded(1000, MAX_POINTS, 4).unwrap_err().contains("in a file of 1000 bytes")
        );
        assert!(check_decoded(usize::MAX, usize::MAX, 8).is_ok());
    }
}
