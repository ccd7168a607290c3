//! Finds the farthest point of a map, and samples that cover a surface evenly.
//!
//! Each sample is the farthest point from all previous samples (Eldar, Lindenbaum, Porat and Zeevi, "The
//! farthest point strategy for progressive image sampling", IEEE Transactions on Image Processing 6(9),
//! 1997).

use rayon::prelude::*;

use geosweep_cpu::{RotatedScan, seeds_for};
use geosweep_surface::update::{EngineKind, Setting, SourceKind, Wavefront};
use geosweep_surface::{
    Chart, DEFAULT_TOLERANCE, EdgeLengths, Real, Seed, SourceError, Sources, Stop, Surface,
};

/// The grid point farthest from all sources.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Farthest<R = f32> {
    /// The row of the point.
    pub row: usize,
    /// The column of the point.
    pub col: usize,
    /// The distance of the point; +infinity if no source reaches it.
    pub distance: R,
}

/// Returns the farthest point that a map reaches. If several points are equally far, the first in row-major
/// order is returned. For a single source, the distance is the eccentricity of the source. Returns `None` if
/// no distance is finite.
///
/// # Panics
/// If the number of distances differs from the number of grid points.
///
/// ```
/// use geosweep::geometry::farthest;
/// use geosweep::{Options, Sources, Spacing, Surface, distance_map};
///
/// let surface = Surface::from_heights(31, 41, vec![0.0; 31 * 41], Spacing::square(1.0))?;
/// let map = distance_map(&surface, &Sources::point(30.0, 0.0), &Options::default())?;
/// let farthest = farthest(map.chart, &map.distances).unwrap();
/// assert_eq!((farthest.row, farthest.col), (0, 40));
/// assert!((farthest.distance - 50.0).abs() < 1e-4);
/// # Ok::<(), geosweep::Error>(())
/// ```
pub fn farthest<R: Real>(chart: Chart, distances: &[R]) -> Option<Farthest<R>> {
    assert_eq!(distances.len(), chart.points(), "a distance for each grid point");
    let row = |row: usize| &distances[chart.row(row)];
    farthest_where(chart, row, |_, distance| distance.is_finite())
}

/// Returns the farthest of the points for which `counts` is true; `counts` gets the index and the distance of
/// a point.
fn farthest_where<'a, R: Real>(
    chart: Chart,
    distances: impl Fn(usize) -> &'a [R] + Sync,
    counts: impl Fn(usize, R) -> bool + Sync,
) -> Option<Farthest<R>> {
    let later = |a: Farthest<R>, b: Farthest<R>| if b.distance > a.distance { b } else { a };
    let in_row = |row: usize| {
        let points = distances(row).iter().enumerate();
        let points = points.filter(|&(col, &distance)| counts(chart.index(row, col), distance));
        points.map(|(col, &distance)| Farthest { row, col, distance }).reduce(later)
    };
    (0..chart.rows).into_par_iter().filter_map(in_row).reduce_with(later)
}

/// Farthest-point sampling: an iterator that yields the farthest grid point as the next sample, until every
/// point is a sample. Each sample updates the map only where it is the nearest sample.
///
/// While there are points that no sample reaches, the next sample is the first of them in row-major order.
/// Every connected part of the surface therefore gets a sample before any part gets a second one.
///
/// ```
/// use geosweep::geometry::{Farthest, FarthestPoints};
/// use geosweep::surface::EdgeLengths;
/// use geosweep::{Sources, Spacing, Surface};
///
/// let surface = Surface::from_heights(41, 41, vec![0.0; 41 * 41], Spacing::square(1.0))?;
/// let edges = EdgeLengths::new(&surface)?;
/// let mut points = FarthestPoints::new(&surface, &edges, &Sources::point(0.0, 0.0))?;
/// let samples: Vec<Farthest> = points.by_ref().take(3).collect();
/// assert_eq!((samples[0].row, samples[0].col), (40, 40));
/// assert!((points.radius() - 800f32.sqrt()).abs() < 1e-3);
/// assert_eq!(points.sources().iter().count(), 4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct FarthestPoints<'a> {
    surface: &'a Surface,
    solver: RotatedScan<f32>,
    sources: Sources,
    /// The smallest initial value. The times of the solver are relative to it.
    start: f64,
    stop: Stop,
    /// Whether each point may become a sample; `None` stands for all points that are present.
    candidates: Option<Vec<bool>>,
}

impl<'a> FarthestPoints<'a> {
    /// Starts from the map of the sources `first`, which count as samples. The map is computed with
    /// the default options on the CPU. `edges` are the edge lengths of `surface`.
    ///
    /// # Errors
    /// If a source lies off the surface, or there is no source.
    ///
    /// # Panics
    /// If `edges` belong to a surface of another size.
    pub fn new(
        surface: &'a Surface,
        edges: &EdgeLengths<f32>,
        first: &Sources,
    ) -> Result<Self, SourceError> {
        let chart = surface.chart();
        assert_eq!(edges.chart(), chart, "the edges are another surface's");
        let mut seeds = first.seeds(surface)?;
        let start = first.start();
        seeds.iter_mut().for_each(|seed| seed.time -= start);
        let stop = Stop::settled(surface, DEFAULT_TOLERANCE);
        // The wavefront must suit several sources, since more samples follow.
        let setting = Setting::new(surface, SourceKind::several(first), EngineKind::Map);
        // Samples are many, and fronts that carry their ray take several times as long.
        let wavefront = Wavefront::chosen(setting).without_rays();
        let seeds = seeds_for(wavefront, surface, seeds);
        let mut solver = RotatedScan::new(edges, wavefront);
        solver.solve(&seeds, stop);
        Ok(Self { surface, solver, sources: first.clone(), start, stop, candidates: None })
    }

    /// Takes samples only from the points for which `candidates`, row-major, is true. On a grid that was completed
    /// ([`geosweep_surface::CompletedGrid`]), this restricts samples to the given points. The covering radius is then
    /// that of the candidates.
    ///
    /// # Panics
    /// If there is not one value for each grid point.
    #[must_use]
    pub fn among(mut self, candidates: &[bool]) -> Self {
        let present = self.surface.present();
        assert_eq!(candidates.len(), present.len(), "a value for each grid point");
        let both =
            candidates.iter().zip(present).map(|(candidate, present)| *candidate && *present);
        self.candidates = Some(both.collect());
        self
    }

    /// Returns the farthest point, which becomes the next sample. If some points are not reached, the first
    /// of them is returned. Returns `None` if every point coincides with a sample.
    pub fn farthest(&self) -> Option<Farthest> {
        let chart = self.surface.chart();
        let present = self.candidates.as_deref().unwrap_or_else(|| self.surface.present());
        let times = |row: usize| self.solver.row(row);
        let unreached = |row: usize| {
            let mut points = times(row).iter().zip(&present[chart.row(row)]);
            let col = points.position(|(time, present)| *present && *time >= f32::FAR)?;
            Some(Farthest { row, col, distance: f32::INFINITY })
        };
        let away = |index: usize, time: f32| present[index] && time > 0.0;
        (0..chart.rows).into_par_iter().find_map_first(unreached).or_else(|| {
            let farthest = farthest_where(chart, times, away)?;
            Some(Farthest { distance: farthest.distance + self.start as f32, ..farthest })
        })
    }

    /// Returns the covering radius: the largest distance of a point from its nearest sample. It is +infinity
    /// while there are points that no sample reaches.
    pub fn radius(&self) -> f32 {
        self.farthest().map_or(self.start as f32, |farthest| farthest.distance)
    }

    /// Returns all samples in order, preceded by the sources given to [`Self::new`].
    pub fn sources(&self) -> &Sources {
        &self.sources
    }

    /// Returns the distance of each grid point from the nearest sample, row-major. It is +infinity at holes
    /// and where no sample reaches.
    pub fn distances(&self) -> Vec<f32> {
        let mut distances = self.solver.distances();
        distances.iter_mut().for_each(|distance| *distance += self.start as f32);
        distances
    }
}

impl Iterator for FarthestPoints<'_> {
    type Item = Farthest;

    /// Takes the farthest point as a sample. The distance of the sample is the covering radius before this
    /// step.
    fn next(&mut self) -> Option<Farthest> {
        let farthest = self.farthest()?;
        let Farthest { row, col, .. } = farthest;
        self.solver.add(&[Seed::at_source(row, col, 0.0)], self.stop);
        let sources = std::mem::take(&mut self.sources);
        self.sources = sources.and_point(row as f64, col as f64, self.start);
        Some(farthest)
    }
}
