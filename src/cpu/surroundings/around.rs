//! Solves the surroundings of a source alone.

use std::collections::BTreeMap;
use std::ops::Range;

use glam::DVec2;

use crate::Stop;
use crate::cpu::fronts::{LaneKind, TriangleKind, for_triangle_kind};
use crate::cpu::rotated::scanner::Scanner;
use crate::cpu::rotated::scans::Scans;
use crate::surface::{Block, Direction, EdgeLengths, Real, Seed, Sheet, Surface};
use crate::update::Wavefront;

/// Number of rows and columns around the surroundings on whose points the edges and curvatures there depend.
const MARGIN: usize = 5;
/// A sufficient precision. The scans of the whole grid start from the surroundings and correct the rest.
const STOP: Stop = Stop::within(1e-8).or_after(100);

/// The points around a source, also over seams. Their rows and columns are those of a part of the surface, with a
/// margin around them.
pub(super) struct Surroundings<'a> {
    surface: &'a Surface,
    sheet: Sheet<'a>,
    own: Block,
    /// Edges of the part. `None` if they are too long or too short: the engine will report this, with those
    /// of the whole surface.
    edges: Option<EdgeLengths<f64>>,
}

impl<'a> Surroundings<'a> {
    pub(super) fn new(surface: &'a Surface, source: DVec2, reach: usize) -> Self {
        let span = |at: DVec2| at.to_array().map(|at| [at as usize, at.ceil() as usize]);
        let [rows, cols] = span(source);
        let sheet = surface.sheet(rows, cols, reach + MARGIN);
        let [rows, cols] = span(sheet.local(source));
        let own = sheet.chart().around_span(rows, cols, reach);
        let edges = EdgeLengths::<f64>::new(sheet.part()).ok().map(EdgeLengths::beside_a_source);
        Self { surface, sheet, own, edges }
    }

    /// Returns the fronts that arrive in the surroundings from the source's seeds by paths inside them, at rows and
    /// columns of the surroundings. Where a front by a path outside is earlier, it will replace them.
    pub(super) fn seeds(&self, wavefront: Wavefront, own: &[Seed]) -> Vec<Seed> {
        let Some(edges) = &self.edges else { return Vec::new() };
        let points: Vec<_> = own.iter().map(|seed| (seed.row, seed.col)).collect();
        let inside = self.sheet.points_at(&points).into_iter();
        let own: Vec<_> =
            inside.map(|(number, (row, col))| Seed { row, col, ..own[number] }).collect();
        for_triangle_kind!(edges, wavefront, kind => self.arrived(edges, kind, &own))
    }

    /// Returns seeds of the surroundings at rows and columns of the whole surface.
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

    /// Limits each seed's time to that along an edge from another seed. Fronts settle only to within some
    /// digits.
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

    /// Returns whether a point of the surroundings lies on a border beyond which the grid continues.
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
        let mut scanner = Scanner::new(edges, kind);
        scanner.solve(own, STOP);
        let first = own.first();
        let (from, origin) = (first.and_then(|s| s.from), first.and_then(|s| s.origin));
        let arrived = self.own.places().filter_map(|(row, col)| {
            let front = scanner.front(row, col);
            let (time, curvature) = (front.time, K::curvature(front));
            (time < f64::FAR).then_some(Seed {
                row,
                col,
                time,
                curvature,
                from,
                origin,
                exact: false,
            })
        });
        arrived.collect()
    }
}
