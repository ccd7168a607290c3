//! A first guess of which source each point belongs to, and where it is in doubt.
//!
//! A point takes the label of the earliest of its neighbours. That is right wherever all the
//! neighbours before it have that label too, and so all those before them: everywhere but near
//! sources and borders. Only there, fronts need to be followed one by one.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use rayon::prelude::*;

use super::NO_REGION;
use crate::geometry::order::rank;
use crate::geometry::spokes::Spokes;
use crate::surface::Real;

/// Labels by the earliest neighbours alone.
pub(super) struct Guess {
    /// For each point of the bordered array; [`NO_REGION`] where nothing arrives, or where a map
    /// that is not converged has a pit.
    pub labels: Vec<u32>,
    /// The points that are sources' or have a source beside them, or two labels before them.
    pub doubtful: Vec<u32>,
}

/// Points that are followed by one task.
const AT_ONCE: usize = 1 << 14;

impl Guess {
    /// `seeds` are the points that sources seed, each with the label of the first of them.
    pub(super) fn new(spokes: &Spokes, times: &[f32], seeds: &[(usize, u32)]) -> Self {
        let labels: Vec<AtomicU32> = times.iter().map(|_| AtomicU32::new(NO_REGION)).collect();
        for &(point, label) in seeds {
            labels[point].store(label, Relaxed);
        }
        let is_reached = |point: &usize| times[*point] < f32::FAR;
        let rank_of = |point: usize| rank(times[point], point);
        // Up to a point that is labelled, and back down.
        let follow = |way: &mut Vec<usize>, from: usize| {
            let (mut point, mut here) = (from, rank_of(from));
            let label = loop {
                let label = labels[point].load(Relaxed);
                if label != NO_REGION {
                    break label;
                }
                way.push(point);
                let earliest = spokes.neighbours(point).map(|other| (rank_of(other), other)).min();
                match earliest {
                    Some((rank, earliest)) if rank < here => (point, here) = (earliest, rank),
                    _ => break NO_REGION,
                }
            };
            way.drain(..).for_each(|point| labels[point].store(label, Relaxed));
        };
        let all = || (0..times.len()).into_par_iter().with_min_len(AT_ONCE);
        all().filter(is_reached).for_each_init(Vec::new, follow);
        let labels: Vec<u32> = labels.into_iter().map(AtomicU32::into_inner).collect();

        let in_doubt = |point: &usize| {
            let label = labels[*point];
            let (here, mut neighbours) = (rank_of(*point), spokes.neighbours(*point));
            // Few neighbours have another label, and only theirs is asked for its rank.
            let other = |neighbour| labels[neighbour] != label && rank_of(neighbour) < here;
            label == NO_REGION || neighbours.any(other)
        };
        let mut doubtful: Vec<u32> =
            all().filter(is_reached).filter(in_doubt).map(|point| point as u32).collect();
        let around = |&(point, _): &(usize, u32)| spokes.neighbours(point).chain([point]);
        let beside_seeds = seeds.iter().flat_map(around).filter(is_reached);
        doubtful.extend(beside_seeds.map(|point| point as u32));
        Self { labels, doubtful }
    }
}
