//! Finds the nearest source of each point and the place on it at which the shortest path ends.

use std::cell::LazyCell;

use glam::DVec2;

use super::tracer;
use crate::{MapError, NO_REGION, Voronoi};
use geosweep_cpu::{StraightFronts, straight_parts};
use geosweep_surface::Surface;
use geosweep_surface::{EdgeLengths, Monitor, Source, Sources};

/// The value in [`Nearest::sources`] at points that no source reaches.
pub const NO_SOURCE: i32 = -1;

/// The number of points whose paths are in memory at the same time.
const TOGETHER: usize = 1 << 10;

/// The nearest source of each grid point.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Nearest {
    /// The index of the nearest source of each point, row-major, or [`NO_SOURCE`]. Sources are numbered from 0
    /// in the order in which they were given.
    pub sources: Vec<i32>,
    /// The place (row and column) on that source at which each point's shortest path ends, row-major; NaN where
    /// no source reaches.
    pub places: Vec<[f64; 2]>,
}

impl Nearest {
    /// Finds the nearest source of each point, initial values considered. `distances` is the converged map of
    /// these sources on this surface, row-major. `edges` are the edge lengths of `surface`.
    ///
    /// The sources are the labels of [`Voronoi`]. For a point source, the place is the source itself. For a curve, the
    /// path of each point of its region is traced, in time proportional to the path's length, unless the path is known to
    /// be a straight line.
    ///
    /// # Errors
    /// If a source lies off the surface, or the number of distances differs from the number of grid points.
    ///
    /// # Panics
    /// If `edges` belong to a surface of another size.
    ///
    /// ```
    /// use geosweep::geometry::Nearest;
    /// use geosweep::surface::EdgeLengths;
    /// use geosweep::{Options, Sources, Spacing, Surface, distance_map};
    ///
    /// let surface = Surface::from_heights(21, 31, vec![0.0; 21 * 31], Spacing::square(1.0))?;
    /// let sources = Sources::curve([[2.0, 0.0], [2.0, 30.0]]).and_point(18.0, 5.0, 0.0);
    /// let map = distance_map(&surface, &sources, &Options::default())?;
    /// let edges = EdgeLengths::new(&surface)?;
    /// let nearest = Nearest::new(&surface, &edges, &sources, &map.distances)?;
    /// let (above, below) = (6 * 31 + 20, 15 * 31 + 5);
    /// assert_eq!((nearest.sources[above], nearest.sources[below]), (0, 1));
    /// assert!((nearest.places[above][1] - 20.0).abs() < 1e-3);
    /// assert_eq!(nearest.places[below], [18.0, 5.0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(
        surface: &Surface,
        edges: &EdgeLengths<f32>,
        sources: &Sources,
        distances: &[f32],
    ) -> Result<Self, MapError> {
        Self::watched(surface, edges, sources, distances, &Monitor::default())
    }

    /// Finds the nearest source of each point as [`Self::new`] does. If `monitor` cancels the search, places on curves
    /// are missing.
    #[doc(hidden)]
    pub fn watched(
        surface: &Surface,
        edges: &EdgeLengths<f32>,
        sources: &Sources,
        distances: &[f32],
        monitor: &Monitor,
    ) -> Result<Self, MapError> {
        let chart = surface.chart();
        let regions = Voronoi::new(surface, edges, sources, distances)?.labels;
        let all: Vec<&Source> = sources.iter().collect();
        let mut places = vec![[f64::NAN; 2]; chart.points()];
        // On straight lines, no path need be traced.
        let straight = LazyCell::new(|| {
            let parts: Vec<_> = all.iter().map(|source| straight_parts(surface, source)).collect();
            StraightFronts::new(surface, &parts)
        });
        let foot = |index, label| straight.as_ref()?.foot(index, label);
        let mut on_curves = Vec::new();
        for (index, &label) in regions.iter().enumerate().filter(|(_, label)| **label != NO_REGION)
        {
            match all[label as usize] {
                Source::Point { at, .. } => places[index] = at.to_array(),
                Source::Curve { .. } => match foot(index, label) {
                    Some(foot) => places[index] = foot.to_array(),
                    None => on_curves.push(index),
                },
            }
        }
        // Point sources alone need no paths.
        if !on_curves.is_empty() {
            let paths = tracer(surface, edges, sources, distances)?.along_the_map();
            for part in on_curves.chunks(TOGETHER).take_while(|_| !monitor.is_cancelled()) {
                let start = |&index: &usize| {
                    let (row, col) = chart.position(index);
                    [row as f64, col as f64]
                };
                let starts: Vec<_> = part.iter().map(start).collect();
                for (&index, path) in part.iter().zip(paths.trace_all(&starts)) {
                    let end = path.ok().and_then(|path| path.curve.vertices.last().copied());
                    // Beside a border between regions, the path may have led to another source than the label's. So its
                    // end is moved to the nearest place on the label's curve.
                    let source = all[regions[index] as usize];
                    if let (Some(end), Source::Curve { vertices, .. }) = (end, source) {
                        places[index] = on_curve(vertices, end.into()).to_array();
                    }
                }
            }
        }
        let source = |&label: &u32| if label == NO_REGION { NO_SOURCE } else { label as i32 };
        Ok(Self { sources: regions.iter().map(source).collect(), places })
    }
}

/// Returns the place on a polyline that is nearest to `at`, measured in rows and columns.
fn on_curve(vertices: &[DVec2], at: DVec2) -> DVec2 {
    let on = |a: DVec2, b: DVec2| {
        let along = b - a;
        let share = (at - a).dot(along) / along.length_squared();
        a + share.clamp(0.0, 1.0) * along
    };
    let segments = vertices.windows(2).filter(|ends| ends[0] != ends[1]);
    let places = segments.map(|ends| on(ends[0], ends[1])).chain(vertices.iter().copied());
    places.min_by(|a, b| a.distance(at).total_cmp(&b.distance(at))).unwrap_or(at)
}
