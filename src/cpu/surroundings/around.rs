//! Solves the surroundings of a source alone.

use std::collections::BTreeMap;
use std::ops::Range;

use glam::DVec2;

use crate::Stop;
use crate::cpu::fronts::{LaneKind, TriangleKind, for_triangle_kind};
use crate::cpu::rotated::scanner::Scanner;
use crate::cpu::rotated::scans::Scans;
use crate::surface::{Block, Direction, EdgeLengths, Real, Seed, Surface};
use crate::update::Wavefront;

/// Number of rows and columns around the surroundings on whose points the edges and curvatures there depend.
const MARGIN: usize = 5;
/// A sufficient precision. The scans of the whole grid start from the surroundings and correct the rest.
const STOP: Stop = Stop::within(1e-8).or_after(100);

/// The points around a source.
pub(super) struct Surroundings {
    own: Block,
    /// The surroundings with a margin.
    window: Block,
    /// Edges of the window. `None` if they are too long or too short: the engine will report this, with those
    /// of the whole surface.
    edges: Option<EdgeLengths<f64>>,
}

impl Surroundings {
    pub(super) fn new(surface: &Surface, source: DVec2, reach: usize) -> Self {
        let [rows, cols] = source.to_array().map(|at| [at as usize, at.ceil() as usize]);
        let around = |reach| surface.chart().around_span(rows, cols, reach);
        let (own, window) = (around(reach), around(reach + MARGIN));
        let points = surface.window(window.rows.clone(), window.cols.clone());
        let edges = EdgeLengths::<f64>::new(&points).ok().map(EdgeLengths::beside_a_source);
        Self { own, window, edges }
    }

    /// Returns the fronts that arrive in the surroundings from the source's seeds by paths inside them. Where
    /// a front by a path outside is earlier, it will replace them.
    pub(super) fn seeds(&self, wavefront: Wavefront, own: &[Seed]) -> Vec<Seed> {
        let Some(edges) = &self.edges else { return Vec::new() };
        let inside = |seed: &Seed| {
            let (row, col) = self.window.local((seed.row, seed.col));
            Seed { row, col, ..*seed }
        };
        // Copies of a source on a seam seed its other sides too, away from here.
        let own: Vec<_> = own.iter().filter(|seed| self.have(seed)).map(inside).collect();
        for_triangle_kind!(edges, wavefront, kind => self.arrived(edges, kind, &own))
    }

    /// Returns the edges between the points of the window, or `None` if they are too long or too short.
    pub(super) fn edges(&self) -> Option<&EdgeLengths<f64>> {
        self.edges.as_ref()
    }

    /// Returns whether a seed lies in the window.
    pub(super) fn have(&self, seed: &Seed) -> bool {
        self.window.rows.contains(&seed.row) && self.window.cols.contains(&seed.col)
    }

    /// Limits each seed's time to that along an edge from another seed. Fronts settle only to within some
    /// digits.
    pub(super) fn shorten(&self, seeds: &mut [Seed]) {
        let Some(edges) = &self.edges else { return };
        let numbers: BTreeMap<_, _> =
            seeds.iter().enumerate().map(|(number, seed)| ((seed.row, seed.col), number)).collect();
        for number in 0..seeds.len() {
            let (row, col) = self.window.local((seeds[number].row, seeds[number].col));
            for to in Direction::ALL {
                let Some(there) = edges.chart().neighbour(row, col, to) else { continue };
                let there = (there.0 + self.window.rows.start, there.1 + self.window.cols.start);
                let Some(&other) = numbers.get(&there) else { continue };
                let along = seeds[other].time + edges.length(row, col, to);
                seeds[number].time = seeds[number].time.min(along);
            }
        }
    }

    /// Returns whether a point of the surroundings lies on a border beyond which the grid continues.
    pub(super) fn is_at_way_out(&self, surface: &Surface, (row, col): (usize, usize)) -> bool {
        let chart = surface.chart();
        let leaves = |own: &Range<usize>, at: usize, all: usize| {
            (at == own.start && at > 0) || (at + 1 == own.end && own.end < all)
        };
        leaves(&self.own.rows, row, chart.rows)
            || leaves(&self.own.cols, col, chart.cols)
            || surface.has_copies((row, col))
    }

    /// Returns the fronts of [`Self::seeds`], given the edges of the window and seeds in it.
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
            let here = self.window.local((row, col));
            let front = scanner.front(here.0, here.1);
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
