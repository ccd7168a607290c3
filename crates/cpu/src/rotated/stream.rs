//! Writes distances to memory, past the caches.

use geosweep_surface::Real;

/// Copies arrival times to memory without loading the destination into the caches, for data that is not read soon.
/// Unreached points become infinite.
///
/// An ordinary store first fetches the cache line that it is about to overwrite, and waits for it. For the rows of a
/// matrix that exceeds the caches, this wait took a quarter of the time of a map.
///
/// # Panics
/// If two slices of a pair differ in length.
pub(crate) fn stream<'a>(pairs: impl Iterator<Item = (&'a [f32], &'a mut [f32])>) {
    pairs.for_each(|(from, to)| copy(from, to));
    // Without the fence, another thread could learn that the work is done before the numbers are visible to it.
    // SAFETY: every x86-64 machine has SSE.
    #[cfg(target_arch = "x86_64")]
    unsafe {
        std::arch::x86_64::_mm_sfence();
    }
}

#[cfg(target_arch = "x86_64")]
fn copy(from: &[f32], to: &mut [f32]) {
    use std::arch::x86_64::*;

    assert_eq!(from.len(), to.len(), "both slices must have the same length");
    // SAFETY: any four adjacent numbers are a valid vector.
    let (head, vectors, tail) = unsafe { to.align_to_mut::<__m128>() };
    let (first, from) = from.split_at(head.len());
    let (fours, last) = from.as_chunks::<4>();
    one_by_one(first, head);
    for (to, from) in vectors.iter_mut().zip(fours) {
        // SAFETY: every x86-64 machine has SSE; four numbers are read; the vector is aligned, and fenced
        // before another thread sees it.
        unsafe {
            let times = _mm_loadu_ps(from.as_ptr());
            let reached = _mm_cmplt_ps(times, _mm_set1_ps(f32::FAR));
            let infinite = _mm_andnot_ps(reached, _mm_set1_ps(f32::INFINITY));
            let distances = _mm_or_ps(_mm_and_ps(reached, times), infinite);
            _mm_stream_ps(std::ptr::from_mut(to).cast(), distances);
        }
    }
    one_by_one(last, tail);
}

#[cfg(not(target_arch = "x86_64"))]
fn copy(from: &[f32], to: &mut [f32]) {
    assert_eq!(from.len(), to.len(), "both slices must have the same length");
    one_by_one(from, to);
}

fn one_by_one(from: &[f32], to: &mut [f32]) {
    for (to, &time) in to.iter_mut().zip(from) {
        *to = if time < f32::FAR { time } else { f32::INFINITY };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_arrives_and_nothing_else_is_touched() {
        let from: Vec<f32> =
            (1..60).map(|k| if k % 5 == 0 { f32::FAR * k as f32 } else { k as f32 }).collect();
        for (skip, count) in (0..9).flat_map(|skip| (0..50).map(move |count| (skip, count))) {
            let mut to = [0.0; 64];
            stream(std::iter::once((&from[..count], &mut to[skip..][..count])));
            let expected = |k: usize| match k.checked_sub(skip).filter(|k| *k < count) {
                None => 0.0,
                Some(k) if from[k] < f32::FAR => from[k],
                Some(_) => f32::INFINITY,
            };
            assert!((0..64).all(|k| to[k] == expected(k)), "{count} numbers at {skip}");
        }
    }
}
