//! Streams rows of the matrix while they are computed.

use std::time::{Duration, Instant};

use rayon::prelude::*;

use super::engine::RowEngine;
use crate::{Convergence, Error, Stop};

/// Rows of the matrix that have just been computed.
#[derive(Clone, Copy, Debug)]
pub struct Rows<'a> {
    /// The sources of the rows, as indices of grid points.
    pub sources: &'a [usize],
    /// The distances, one row for each source.
    pub distances: &'a [f32],
}

impl<'a> Rows<'a> {
    /// Returns each source with its row.
    pub fn iter(&self) -> impl Iterator<Item = (usize, &'a [f32])> + use<'a> {
        let points = self.distances.len() / self.sources.len().max(1);
        self.sources.iter().copied().zip(self.distances.chunks_exact(points.max(1)))
    }
}

/// Allocates memory for rows of a matrix. All threads touch it once, so that its pages are mapped.
pub(super) fn room(rows: usize, points: usize) -> Result<Vec<f32>, Error> {
    let count = rows.checked_mul(points);
    let room = count.and_then(|count| bytemuck::try_zeroed_vec(count).ok());
    let Some(mut room) = room else { return Err(Error::Memory { rows, points }) };
    room.par_chunks_mut(points.max(1)).for_each(|row| row.fill(f32::INFINITY));
    Ok(room)
}

/// Computes rows, `wave` at a time. Each wave is passed to `sink` while the next one is computed.
pub(super) fn stream<E: From<Error> + Send>(
    engine: &mut RowEngine,
    sources: &[usize],
    points: usize,
    wave: usize,
    stop: Stop,
    mut sink: impl FnMut(Rows) -> Result<(), E> + Send,
) -> Result<(Convergence, Duration), E> {
    let wave = wave.min(sources.len());
    let (mut ready, mut next) = (room(wave, points)?, room(wave, points)?);
    let (mut convergence, start) = (Convergence::NONE, Instant::now());
    let (mut before, mut rest): (&[usize], _) = (&[], sources);
    while !(before.is_empty() && rest.is_empty()) {
        let (now, after) = rest.split_at(engine.whole_batches(rest, wave));
        let done = Rows { sources: before, distances: &ready[..before.len() * points] };
        let into = &mut next[..now.len() * points];
        let (handed_over, solved) = rayon::join(
            || if done.sources.is_empty() { Ok(()) } else { sink(done) },
            || engine.solve(now, stop, into, &|_| ()),
        );
        handed_over?;
        engine.monitor.check().map_err(Error::from)?;
        convergence = convergence.worse(solved?);
        std::mem::swap(&mut ready, &mut next);
        (before, rest) = (now, after);
    }
    Ok((convergence, start.elapsed()))
}
