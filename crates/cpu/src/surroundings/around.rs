//! Solves the surroundings of a source alone.

use std::collections::BTreeMap;
use std::ops::Range;

use glam::DVec2;

use crate::fronts::{LaneKind, TriangleFronts, TriangleKind, for_triangle_kind};
use crate::rotated::scanner::Scanner;
use crate::rotated::scans::Scans;
use geosweep_surface::Stop;
use geosweep_surface::update::Wavefront;
use geosweep_surface::{Block, Direction, EdgeLengths, Real, Seed, Sheet, Surface};

/// Width in rows and columns of the margin around the surroundings. Edges and curvatures in the surroundings depend on
/// the points of this margin.
const MARGIN: usize = 5;
/// Sufficient precision: the scans of the whole grid start from the surroundings and correct the rest.
const STOP: Stop = Stop::within(1e-8).or_after(100);

/// The points around a source, also over seams. Their rows and columns are those of a part of the surface, with a
/// margin around them.
pub(super) struct Surroundings<'a> {
    surface: &'a Surface,
    sheet: Sheet<'a>,
    own: Block,
    /// Edges of the part. `None` if an edge is too long or too short: the engine reports this when it measures the
    /// whole surface.
    edges: Option<EdgeLengths<f64>>,
}

impl<'a> Surroundings<'a> {
    /// Returns the points at most `reach` rows and columns away from the cell of a source.
    pub(super) fn new(surface: &'a Surface, source: DVec2, reach: [usize; 2]) -> Self {
        let span = |at: DVec2| at.to_array().map(|at| [at as usize, at.ceil() as usize]);
        let [rows, cols] = span(source);
        let sheet = surface.sheet(rows, cols, reach.map(|reach| reach + MARGIN));
        let [rows, cols] = span(sheet.local(source));
        let own = sheet.chart().around_span(rows, cols, reach);
        let edges = EdgeLengths::<f64>::new(sheet.part()).ok().map(EdgeLengths::beside_a_source);
        Self { surface, sheet, own, edges }
    }

    /// Returns the fronts of the source's seeds on paths inside the surroundings, as seeds at rows and columns of the
    /// surroundings. Where a path outside is shorter, scans of the whole grid replace these fronts.
    pub(super) fn seeds(&self, wavefront: Wavefront, own: &[Seed]) -> Vec<Seed> {
        let Some(edges) = &self.edges else { return Vec::new() };
        let points: Vec<_> = own.iter().map(|seed| (seed.row, seed.col)).collect();
        let inside = self.sheet.points_at(&points).into_iter();
        let own: Vec<_> =
            inside.map(|(number, (row, col))| Seed { row, col, ..own[number] }).collect();
        for_triangle_kind!(edges, wavefront, kind => self.arrived(edges, kind, &own))
    }

    /// Converts seeds of the surroundings to rows and columns of the whole surface.
    pub(super) fn on_surface(&self, mut seeds: Vec<Seed>) -> Vec<Seed> {
        for seed in &mut seeds {
            (seed.row, seed.col) = self.sheet.point((seed.row, seed.col));
        }
        seeds
    }

    /// Returns the edges between the points of the part, or `None` if they are too long or too short.
    pub(super) fn edges(&self) -> Option<&EdgeLengths<f64>> {
        self.edges.as_ref()
    }

    /// Limits each seed's time to the arrival time along an edge from another seed. Without this, a seed could be later
    /// by the tolerance to which the surroundings are solved.
    pub(super) fn shorten(&self, seeds: &mut [Seed]) {
        let Some(edges) = &self.edges else { return };
        let numbers: BTreeMap<_, _> =
            seeds.iter().enumerate().map(|(number, seed)| ((seed.row, seed.col), number)).collect();
        for number in 0..seeds.len() {
            let Seed { row, col, .. } = seeds[number];
            for to in Direction::ALL {
                let Some(there) = edges.chart().neighbour(row, col, to) else { continue };
                let Some(&other) = numbers.get(&there) else { continue };
                let along = seeds[other].time + edges.length(row, col, to);
                seeds[number].time = seeds[number].time.min(along);
            }
        }
    }

    /// Returns whether fronts can leave the surroundings at a point: the point lies on a border beyond which the grid
    /// continues, or has copies beyond which the grid ends, as at a pole.
    pub(super) fn is_at_way_out(&self, (row, col): (usize, usize)) -> bool {
        let chart = self.sheet.chart();
        let leaves = |own: &Range<usize>, at: usize, all: usize| {
            (at == own.start && at > 0) || (at + 1 == own.end && own.end < all)
        };
        leaves(&self.own.rows, row, chart.rows)
            || leaves(&self.own.cols, col, chart.cols)
            || self.surface.is_broken(self.sheet.point((row, col)))
    }

    /// Returns the fronts of [`Self::seeds`], given the edges of the part and seeds in it.
    fn arrived<K: TriangleKind<f64> + LaneKind<f64>>(
        &self,
        edges: &EdgeLengths<f64>,
        kind: K,
        own: &[Seed],
    ) -> Vec<Seed> {
        let first = own.first();
        let (from, origin) = (first.and_then(|s| s.from), first.and_then(|s| s.origin));
        let arrived = arrived(edges, kind, own, STOP, self.own.places());
        arrived.into_iter().map(|seed| Seed { from, origin, ..seed }).collect()
    }
}

/// Returns the fronts of seeds at some places, as seeds.
pub(super) fn arrived<K: TriangleKind<f64> + LaneKind<f64>>(
    edges: &EdgeLengths<f64>,
    kind: K,
    own: &[Seed],
    stop: Stop,
    places: impl Iterator<Item = (usize, usize)>,
) -> Vec<Seed> {
    let mut scanner = Scanner::new(edges, kind);
    scanner.solve(own, stop);
    let seed = |(row, col)| {
        let front = scanner.front(row, col);
        let curvature = K::Carried::curvature(front);
        let is_reached = front.time < f64::FAR;
        is_reached.then_some(Seed { curvature, ..Seed::at_source(row, col, front.time) })
    };
    places.filter_map(seed).collect()
}
