//! Solves the surroundings of each point source separately where point sources lie close together.
//!
//! Where fronts of two sources meet, a curved update treats them as one front. Two fronts that arrive together at the
//! ends of a base look like a circle around a point between their sources, and this circle arrives too early. The
//! fronts of neighbouring sources move side by side, so that the error adds up: to an eighth of a cell on square cells,
//! and to a third of the distance on others. The error of a single update decreases with the square of the distance
//! from the sources. So each source's front is solved alone for some cells. The earliest fronts become seeds, and no
//! front through a triangle replaces them ([`Seed::exact`]).
//!
//! Where all cells are alike this is not needed: there straight lines tell fronts apart (`straight/`).

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec2;
use rayon::prelude::*;

use super::around::Surroundings;
use super::straight::origins;
use geosweep_surface::update::Wavefront;
use geosweep_surface::{Direction, Origin, Seed, Sources, Surface};

/// Maximum number of rows and columns that a source's own map reaches around it. The remaining error of two
/// sources side by side is a 130th of a cell with 16, and a 65th with 8.
const REACH: usize = 16;
/// Minimum number of rows and columns. With fewer there is little to gain.
const LEAST_REACH: usize = 4;
/// Limits of the number of points of all these maps together: the number of the grid's points divided by `SHARE`, or
/// `MOST_POINTS` if that is larger.
const SHARE: usize = 4;
const MOST_POINTS: usize = 40_000;

/// Returns exact seeds around the point sources that have another point source near. `seeds` are the seeds of all
/// sources, with their origins.
pub(crate) fn around_clusters(
    wavefront: Wavefront,
    surface: &Surface,
    seeds: &[Seed],
) -> Vec<Seed> {
    let sources: Vec<_> = origins(seeds).into_iter().filter(Origin::is_point).collect();
    if !wavefront.is_curved() || sources.len() < 2 {
        return Vec::new();
    }
    let outer = outer(surface, &sources);
    let Some((crowded, reach)) = crowded(surface, &outer) else { return Vec::new() };
    let keys: BTreeSet<_> = crowded.iter().map(Origin::key).collect();
    let is_crowded = |seed: &Seed| seed.origin.is_some_and(|origin| keys.contains(&origin.key()));
    let others: Vec<_> = seeds.iter().filter(|seed| !is_crowded(seed)).copied().collect();
    let first = seeds.iter().map(|seed| seed.time).fold(f64::INFINITY, f64::min);
    let maps: Vec<_> = crowded
        .into_par_iter()
        .filter_map(|origin| Alone::new(wavefront, surface, origin, reach, &others))
        .collect();
    let near = Places::of(surface, maps.iter().map(|map| map.at), 2 * reach + 2);
    let found = maps.iter().flat_map(|map| {
        let around = near.around(map.at);
        let are_all = others.is_empty() && around.len() == maps.len();
        // The front of another source has to cross the border of the surroundings first. It cannot reach a
        // point earlier than the source's own front if the latter is at most half-way to the border in time.
        let alone = if are_all { map.complete } else { 0.5 * (map.complete + first) };
        let complete = around.iter().map(|&other| maps[other].complete).fold(alone, f64::min);
        let exact = move |seed: &Seed| seed.exact && seed.time <= complete;
        map.seeds.iter().map(move |seed| Seed { exact: exact(seed), ..*seed })
    });
    Seed::earliest(found).into_iter().filter(|seed| seed.exact).collect()
}

/// Returns the sources whose fronts reach other points. Omits a source if all neighbouring grid points have sources
/// that start as early.
fn outer(surface: &Surface, sources: &[Origin]) -> Vec<Origin> {
    let at_point =
        |at: DVec2| (at.fract() == DVec2::ZERO).then_some((at.x as usize, at.y as usize));
    let mut starts = BTreeMap::new();
    for origin in sources {
        if let Some((row, col)) = at_point(origin.ends[0]) {
            let first = starts.entry(surface.first_copy((row, col))).or_insert(origin.start);
            *first = first.min(origin.start);
        }
    }
    let is_inner = |origin: &Origin| {
        let Some((row, col)) = at_point(origin.ends[0]) else { return false };
        let neighbour = |to: Direction| {
            let (down, right) = to.step();
            surface.continued(row as isize + down, col as isize + right)
        };
        let starts_as_early = |(row, col): (usize, usize)| {
            let start = starts.get(&surface.first_copy((row, col)));
            !surface.has(row, col) || start.is_some_and(|start| *start <= origin.start)
        };
        !surface.is_broken((row, col))
            && Direction::ALL.into_iter().filter_map(neighbour).all(starts_as_early)
    };
    sources.iter().copied().filter(|origin| !is_inner(origin)).collect()
}

/// Returns the sources that have another source near, and the reach of their maps. Returns `None` if there are none, or
/// too many for any reach.
fn crowded(surface: &Surface, sources: &[Origin]) -> Option<(Vec<Origin>, usize)> {
    let most = (surface.chart().points() / SHARE).max(MOST_POINTS);
    let place = |origin: &Origin| origin.ends[0];
    // With a smaller reach, fewer sources are near each other.
    (LEAST_REACH..=REACH).rev().find_map(|reach| {
        let near = Places::of(surface, sources.iter().map(place), reach);
        let has_other = |origin: &&Origin| near.around(place(origin)).len() > 1;
        let crowded: Vec<_> = sources.iter().filter(has_other).copied().collect();
        let points = crowded.len().saturating_mul((2 * reach + 1).pow(2));
        (points <= most && !crowded.is_empty()).then_some((crowded, reach))
    })
}

/// Positions sorted into squares of the grid, to find those that are near each other, also over seams.
struct Places {
    side: f64,
    /// Number and position of each entry, repeated for its copies beyond the sides of the grid.
    all: Vec<(DVec2, usize)>,
    by_square: BTreeMap<(i64, i64), Vec<usize>>,
}

impl Places {
    /// Sorts positions, to find those within `reach` rows and columns of a point.
    fn of(surface: &Surface, places: impl Iterator<Item = DVec2>, reach: usize) -> Self {
        let side = reach as f64;
        let images = |(number, at): (usize, DVec2)| {
            let beyond = surface.images_beyond(at, side);
            std::iter::once(at).chain(beyond).map(move |at| (at, number))
        };
        let all = places.enumerate().flat_map(images).collect();
        let mut new = Self { side, all, by_square: BTreeMap::new() };
        for (index, (at, _)) in new.all.iter().enumerate() {
            new.by_square.entry(new.square(*at)).or_default().push(index);
        }
        new
    }

    fn square(&self, at: DVec2) -> (i64, i64) {
        let square = (at / self.side).floor();
        (square.x as i64, square.y as i64)
    }

    /// Returns the numbers of the positions near `at`.
    fn around(&self, at: DVec2) -> BTreeSet<usize> {
        let (row, col) = self.square(at);
        let squares: BTreeSet<_> = (-1..=1)
            .flat_map(|down| (-1..=1).map(move |right| (row + down, col + right)))
            .collect();
        let near = squares.into_iter().filter_map(|square| self.by_square.get(&square)).flatten();
        let near = near.map(|&index| self.all[index]);
        near.filter(|(other, _)| (other - at).abs().max_element() <= self.side)
            .map(|(_, number)| number)
            .collect()
    }
}

/// The front of a source in the absence of other sources.
struct Alone {
    at: DVec2,
    /// Seeds at the points that the front reaches, exact where no other known front comes first.
    seeds: Vec<Seed>,
    /// Time at which the front first leaves its surroundings.
    complete: f64,
}

impl Alone {
    fn new(
        wavefront: Wavefront,
        surface: &Surface,
        origin: Origin,
        reach: usize,
        others: &[Seed],
    ) -> Option<Self> {
        let at = origin.ends[0];
        let own = Sources::default().and_point(at.x, at.y, origin.start).seeds(surface).ok()?;
        let surroundings = Surroundings::new(surface, at, [reach; 2]);
        let exact = |seed: Seed| Seed { origin: None, exact: true, ..seed };
        let mut seeds: Vec<_> =
            surroundings.seeds(wavefront, &own).into_iter().map(exact).collect();
        surroundings.shorten(&mut seeds);
        let leaves = |seed: &&Seed| surroundings.is_at_way_out((seed.row, seed.col));
        let complete =
            seeds.iter().filter(leaves).map(|seed| seed.time).fold(f64::INFINITY, f64::min);
        let others: Vec<_> = others.iter().map(unnamed).collect();
        if !others.is_empty() {
            let theirs = surroundings.seeds(wavefront, &others);
            let theirs: BTreeMap<_, _> =
                theirs.iter().map(|seed| ((seed.row, seed.col), seed.time)).collect();
            for seed in &mut seeds {
                let other = theirs.get(&(seed.row, seed.col));
                seed.exact = other.is_none_or(|time| seed.time <= *time);
            }
        }
        Some(Self { at, seeds: surroundings.on_surface(seeds), complete })
    }
}

/// Returns a seed without its origin.
fn unnamed(seed: &Seed) -> Seed {
    Seed { origin: None, ..*seed }
}
