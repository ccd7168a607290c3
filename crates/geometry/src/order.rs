//! Orders the points of a map by arrival time.

use rayon::prelude::*;

use super::MapError;
use geosweep_surface::{Chart, Real};

/// Copies a map into a bordered array. Points that the map does not reach get [`Real::FAR`].
///
/// # Errors
/// If the number of distances differs from the number of grid points.
pub(super) fn bordered(chart: Chart, distances: &[f32]) -> Result<Vec<f32>, MapError> {
    let Chart { rows, cols } = chart;
    if distances.len() != chart.points() {
        return Err(MapError::Shape { found: distances.len(), rows, cols });
    }
    let mut times = vec![f32::FAR; chart.bordered_points()];
    chart.rows_mut(&mut times).zip(distances.par_chunks(cols)).for_each(|(line, distances)| {
        for (time, &distance) in line.iter_mut().zip(distances) {
            // Adding zero turns -0 into 0. Otherwise -0 would be ordered before 0 although it is not smaller.
            *time = if distance.is_finite() { distance + 0.0 } else { f32::FAR };
        }
    });
    Ok(times)
}

/// Returns the rank of a point: a number that is smaller for points that are reached earlier. Among points with equal
/// times, the point with the smaller index has the smaller rank. Times must not be -0, which [`bordered`] turns into 0.
pub(super) fn rank(time: f32, point: usize) -> u64 {
    // The bit patterns of negative numbers are in descending order, so all their bits are inverted.
    let bits = time.to_bits();
    let ordered = if bits >> 31 == 0 { bits | 1 << 31 } else { !bits };
    (u64::from(ordered) << 32) | point as u64
}

/// Returns the indices of all reached points, the earliest first. Points with equal times are sorted by
/// index.
///
/// Points are first distributed over buckets of equal ranges of time, one for every `IN_BUCKET` entries of the array,
/// and each bucket is sorted. This is fast if times are spread evenly, and right in any case.
pub(super) fn by_arrival(times: &[f32]) -> Vec<u32> {
    const IN_BUCKET: usize = 16;
    let is_reached = |time: f32| time < f32::FAR;
    let reached = || times.par_iter().copied().filter(|&time| is_reached(time));
    let first = reached().reduce(|| f32::FAR, f32::min);
    let last = reached().reduce(|| first, f32::max);
    let buckets = times.len() / IN_BUCKET + 1;
    let per_time = if last > first { (buckets - 1) as f32 / (last - first) } else { 0.0 };
    // A later time never gets an earlier bucket, even after rounding. The conversion saturates, and the last bucket
    // takes the rest.
    let bucket = |time: f32| (((time - first) * per_time) as usize).min(buckets - 1);
    // Sizes of the buckets at first, then their starts, finally their ends.
    let mut ends = vec![0u32; buckets];
    for &time in times.iter().filter(|&&time| is_reached(time)) {
        ends[bucket(time)] += 1;
    }
    let mut count = 0;
    for end in &mut ends {
        (*end, count) = (count, count + *end);
    }
    let mut order = vec![0u32; count as usize];
    for (point, &time) in times.iter().enumerate().filter(|&(_, &time)| is_reached(time)) {
        let place = &mut ends[bucket(time)];
        order[*place as usize] = point as u32;
        *place += 1;
    }
    let time = |point: u32| times[point as usize];
    // Now each entry of `ends` is the end of its bucket.
    let mut rest = order.as_mut_slice();
    let mut parts = Vec::new();
    let mut start = 0;
    // A task sorts 256 buckets.
    for ends in ends.chunks(256) {
        let end = ends[ends.len() - 1];
        let (part, after) = rest.split_at_mut((end - start) as usize);
        (rest, start) = (after, end);
        parts.push(part);
    }
    parts.into_par_iter().for_each(|part| {
        let same = |a: &u32, b: &u32| bucket(time(*a)) == bucket(time(*b));
        for bucket in part.chunk_by_mut(same) {
            bucket.sort_unstable_by(|&a, &b| time(a).total_cmp(&time(b)).then(a.cmp(&b)));
        }
    });
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_are_in_the_order_of_times() {
        let times = [f32::NEG_INFINITY, -2.0, -1.0, -0.0, 0.0, 1e-30, 1.0, f32::FAR];
        for pair in times.windows(2) {
            assert!(rank(pair[0], 9) < rank(pair[1], 3));
        }
        assert!(rank(1.0, 3) < rank(1.0, 4));
    }

    #[test]
    fn equal_times_have_one_rank_whatever_their_sign() {
        let chart = Chart { rows: 1, cols: 3 };
        let times = bordered(chart, &[-0.0, 0.0, f32::INFINITY]).unwrap();
        let [first, second, last] = [0, 1, 2].map(|col| times[chart.bordered(0, col)]);
        assert_eq!((rank(first, 9), last), (rank(second, 9), f32::FAR));
    }

    #[test]
    fn points_come_in_the_order_of_their_times() {
        for spread in [1.0, 0.0, 1e-30, 1e30] {
            let time = |k: u32| if k % 7 == 3 { f32::FAR } else { (k * 37 % 101) as f32 * spread };
            let times: Vec<f32> = (0..5000).map(time).collect();
            let mut expected: Vec<u32> = (0..5000).filter(|&k| time(k) < f32::FAR).collect();
            expected.sort_by(|&a, &b| time(a).total_cmp(&time(b)));
            assert_eq!(by_arrival(&times), expected);
        }
        assert!(by_arrival(&[f32::FAR; 9]).is_empty());
    }
}
