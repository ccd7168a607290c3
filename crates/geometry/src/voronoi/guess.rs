//! Guesses the nearest source of each point, and finds the points at which the guess is uncertain.
//!
//! A point takes the label of the earliest of its neighbours. The label is right if all earlier neighbours have it, and
//! all earlier neighbours of these, and so on. This holds except near sources and near borders between regions. Only
//! there is the wavefront of each source propagated separately.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use rayon::prelude::*;

use super::continuation::Continuation;
use super::known::NO_REGION;
use crate::copies::Copies;
use crate::neighbourhood::Neighbourhood;
use crate::order::by_arrival;
use geosweep_surface::lanes::{Instructions, Loop};
use geosweep_surface::{Chart, Direction, Offset, Real};

/// Labels taken from the earliest neighbours.
pub(super) struct Guess {
    /// The label of each point of the bordered array. It is [`NO_REGION`] where no wavefront arrives and
    /// where a map that has not converged has a local minimum.
    pub labels: Vec<u32>,
    /// Reached points whose label is uncertain: those that a source seeds, their neighbours, points with an earlier
    /// neighbour of another label, and points without a label. A point may occur twice.
    pub doubtful: Vec<u32>,
}

/// Marks a link, which stands for a label that is not known yet. Its lowest three bits say which neighbour has the same
/// label; neighbours are numbered in the order of their indices.
const LINK: u32 = 1 << 31;

impl Guess {
    /// Guesses all labels. `seeds` are the points that sources seed, each with the label of its first wavefront. Of the
    /// copies of a point, only the first occurs in `seeds` and in `doubtful`; it stands for all.
    pub(super) fn new(
        continuation: &Continuation,
        copies: &Copies,
        times: &[f32],
        seeds: &[(usize, u32)],
    ) -> Self {
        let neighbourhood = continuation.neighbourhood();
        let chart = neighbourhood.chart();
        let labels = if copies.is_none() {
            linked(chart, times, seeds)
        } else {
            followed(neighbourhood, copies, times, seeds)
        };
        let seen = |copy| {
            let parts = continuation.parts_behind(copy);
            neighbourhood.neighbours(copy).chain(parts.flat_map(|part| part.corners))
        };
        let around = |point| copies.all(point).flat_map(seen);
        let is_reached = |point: &usize| times[*point] < f32::FAR;
        let in_doubt = |point: &usize| {
            let (label, here) = (labels[*point], copies.rank(times, *point));
            let before = |other| copies.rank(times, other) < here;
            label == NO_REGION
                || around(*point).any(|other| labels[other] != label && before(other))
        };
        let of_row = |differences: &mut Vec<u32>, row: usize| {
            let first = chart.bordered(row, 0);
            differences.resize(chart.cols, 0);
            let around = chart.rows_around(&labels, row);
            Instructions::best().run(Differences { around, differences });
            let found = differences.iter().zip(first..).filter(|&(&difference, _)| difference != 0);
            let found = found.map(|(_, point)| point).filter(is_reached).filter(in_doubt);
            found.map(|point| copies.first(point) as u32).collect::<Vec<u32>>()
        };
        let rows = (0..chart.rows).into_par_iter();
        let found: Vec<Vec<u32>> = rows.map_init(Vec::new, of_row).collect();
        let mut doubtful = found.concat();
        // The neighbours of a point with obtuse triangles do not tell whether a front comes from beyond them.
        if let Some(parts) = continuation.parts() {
            let far = parts.points().filter(is_reached).filter(in_doubt);
            doubtful.extend(far.map(|point| copies.first(point) as u32));
        }
        let beside_seeds = seeds.iter().flat_map(|&(point, _)| around(point).chain([point]));
        let beside_seeds = beside_seeds.filter(is_reached);
        doubtful.extend(beside_seeds.map(|point| copies.first(point) as u32));
        Self { labels, doubtful }
    }
}

/// Returns the labels of a surface that is not glued, by links from point to point.
fn linked(chart: Chart, times: &[f32], seeds: &[(usize, u32)]) -> Vec<u32> {
    let mut labels: Vec<AtomicU32> = times.iter().map(|_| AtomicU32::new(NO_REGION)).collect();
    let instructions = Instructions::best();
    chart.rows_mut(&mut labels).enumerate().for_each(|(row, line)| {
        instructions.run(Earliest { around: chart.rows_around(times, row), line });
    });
    for &(point, label) in seeds {
        *labels[point].get_mut() = label;
    }
    let mut offsets = Direction::ALL.map(|to| chart.offset(to));
    offsets.sort_unstable();
    (0..chart.rows).into_par_iter().for_each(|row| {
        let first = chart.bordered(row, 0);
        (first..first + chart.cols).for_each(|point| resolve(&labels, &offsets, point));
    });
    labels.into_iter().map(AtomicU32::into_inner).collect()
}

/// Returns the labels of a glued surface, point by point in the order of arrival. The earliest neighbour of a point may
/// lie beside any of its copies.
fn followed(
    neighbourhood: &Neighbourhood,
    copies: &Copies,
    times: &[f32],
    seeds: &[(usize, u32)],
) -> Vec<u32> {
    let mut labels = vec![NO_REGION; times.len()];
    for &(point, label) in seeds {
        labels[point] = label;
    }
    for point in by_arrival(times).into_iter().map(|point| point as usize) {
        let first = copies.first(point);
        if labels[first] == NO_REGION {
            let around = copies.all(first).flat_map(|copy| neighbourhood.neighbours(copy));
            let ranked = around.map(|other| (copies.rank(times, other), copies.first(other)));
            let earliest = ranked.min().filter(|(rank, _)| *rank < copies.rank(times, first));
            labels[first] = earliest.map_or(NO_REGION, |(_, other)| labels[other]);
        }
        labels[point] = labels[first];
    }
    labels
}

/// Follows links from a point to a label, and stores that label at all points passed. Other threads that follow the
/// same links write the same values.
fn resolve(labels: &[AtomicU32], offsets: &[Offset; 8], point: usize) {
    let next = |point: usize| {
        let link = labels[point].load(Relaxed);
        let is_link = link & LINK != 0 && link != NO_REGION;
        if is_link { Ok(offsets[(link & 7) as usize].from(point)) } else { Err(link) }
    };
    let mut end = point;
    let label = loop {
        match next(end) {
            Ok(following) => end = following,
            Err(label) => break label,
        }
    };
    let mut here = point;
    while let Ok(following) = next(here) {
        labels[here].store(label, Relaxed);
        here = following;
    }
}

/// A pass that links each point of a row to its earliest neighbour, if that neighbour is reached before the point.
struct Earliest<'a> {
    /// The times of the row and of the rows above and below it.
    around: [&'a [f32]; 3],
    line: &'a mut [AtomicU32],
}

impl Loop for Earliest<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { around, line } = self;
        let [above, beside, below] = around.map(|row| &row[..line.len() + 2]);
        for (point, line) in line.iter_mut().enumerate() {
            // Neighbours are compared in the order of their indices, so the first of equally early ones is chosen.
            let mut earliest = (f32::FAR, NO_REGION);
            earliest = earlier(earliest, above[point], LINK);
            earliest = earlier(earliest, above[point + 1], LINK | 1);
            earliest = earlier(earliest, above[point + 2], LINK | 2);
            earliest = earlier(earliest, beside[point], LINK | 3);
            earliest = earlier(earliest, beside[point + 1], NO_REGION);
            earliest = earlier(earliest, beside[point + 2], LINK | 4);
            earliest = earlier(earliest, below[point], LINK | 5);
            earliest = earlier(earliest, below[point + 1], LINK | 6);
            earliest = earlier(earliest, below[point + 2], LINK | 7);
            let is_reached = beside[point + 1] < f32::FAR;
            *line.get_mut() = if is_reached { earliest.1 } else { NO_REGION };
        }
    }
}

#[inline(always)]
fn earlier((earliest, link): (f32, u32), time: f32, to: u32) -> (f32, u32) {
    let is_earlier = time < earliest;
    (if is_earlier { time } else { earliest }, if is_earlier { to } else { link })
}

/// A pass that marks, by a number other than zero, the points of a row without a label or with a neighbour of
/// another label.
struct Differences<'a> {
    /// The labels of the row and of the rows above and below it.
    around: [&'a [u32]; 3],
    differences: &'a mut [u32],
}

impl Loop for Differences<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { around, differences } = self;
        let [above, beside, below] = around.map(|row| &row[..differences.len() + 2]);
        for (point, difference) in differences.iter_mut().enumerate() {
            let here = beside[point + 1];
            let above =
                (above[point] ^ here) | (above[point + 1] ^ here) | (above[point + 2] ^ here);
            let below =
                (below[point] ^ here) | (below[point + 1] ^ here) | (below[point + 2] ^ here);
            let beside = (beside[point] ^ here) | (beside[point + 2] ^ here);
            *difference = above | beside | below | u32::from(here == NO_REGION);
        }
    }
}
