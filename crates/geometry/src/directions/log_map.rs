//! Computes log maps: the place of each point in the tangent plane of its source.

use glam::DVec2;

use super::bearing::{NO_BEARING, compass, east_and_north, grass};
use super::departures::{Departures, Start};
use crate::{NO_REGION, Voronoi};
use geosweep_surface::{Cancelled, Monitor, SourceError, SurfaceError};
use geosweep_surface::{Chart, EdgeLengths, Real, Source, Sources, Surface};

/// The logarithmic map of one or several point sources: for each grid point the direction in which its
/// shortest path leaves the nearest source, times its distance from that source.
///
/// These coordinates (u, v) are lengths in the tangent plane at the source. On a plane they are the position of the
/// point relative to the source, rotated to the axes of [`Basis`]. Textures drawn in these coordinates are undistorted
/// around the source.
///
/// ```
/// use geosweep::geometry::LogMap;
/// use geosweep::{Sources, Spacing, Surface};
///
/// let surface = Surface::from_heights(33, 33, vec![0.0; 33 * 33], Spacing { dx: 2.0, dy: 1.0 })?;
/// let log_map = LogMap::new(&surface, &Sources::point(10.0, 12.0))?;
/// // Four columns eastwards and five rows downwards.
/// let [u, v] = log_map.coordinates[15 * 33 + 16];
/// assert!((u - 8.0).abs() < 1e-6 && (v - 5.0).abs() < 1e-6);
/// let [row, col] = log_map.place(0, [8.0, 5.0]).unwrap();
/// assert!((row - 15.0).abs() < 1e-5 && (col - 16.0).abs() < 1e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct LogMap {
    /// The grid's size.
    pub chart: Chart,
    /// The coordinates (u, v) of each grid point, row-major, in the unit of distances. They are NaN at holes
    /// and where no source reaches.
    pub coordinates: Vec<[f32; 2]>,
    /// The nearest source of each grid point, row-major, or [`NO_REGION`].
    pub labels: Vec<u32>,
    /// The axes of u and v at each source, in the order of the sources.
    pub bases: Vec<Basis>,
}

/// The axes of a log map at its source. Both are steps of unit length on the surface, at a right angle to each other.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Basis {
    /// The row and column of the source.
    pub at: [f64; 2],
    /// The axis of u, in rows and columns: in the direction of increasing columns.
    pub u: [f64; 2],
    /// The axis of v, in rows and columns: at a right angle to the axis of u, on the side of increasing rows.
    pub v: [f64; 2],
    /// The two axes in space; `None` if the surface is given by its metric.
    pub in_space: Option<[[f64; 3]; 2]>,
}

/// The reason why there is no log map.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LogMapError {
    /// The surface cannot be used.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// The sources cannot be used.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// The computation was cancelled by its [`Monitor`].
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// A source is a curve.
    #[error(
        "source {source_index} is a curve, at which paths do not leave from one point; log maps and source directions need point sources"
    )]
    Curve {
        /// The index of the source, from 0.
        source_index: usize,
    },
    /// The surface has no tangent plane at a source.
    #[error(
        "source {row},{col} lies where the grid has no tangent plane: at a pole, or on a single row or column; move it"
    )]
    NoPlane {
        /// Row of the source.
        row: f64,
        /// Column of the source.
        col: f64,
    },
}

impl LogMap {
    /// Computes the log map of point sources. With several, each point has coordinates in the plane of its
    /// nearest source ([`Self::labels`]), initial values considered. Over a slowness, the distance is the
    /// travel time.
    ///
    /// The computation takes nine maps in double precision on the CPU, whatever the number of sources, and about 90
    /// bytes a point.
    ///
    /// Where several shortest paths lead to a point (at the cut locus), the coordinates jump. A point beside the cut
    /// locus has the coordinates of one of the paths to it.
    ///
    /// # Errors
    /// If a source is a curve, lies off the surface or at a pole, if there is no source, or if the maps cannot be
    /// computed.
    pub fn new(surface: &Surface, sources: &Sources) -> Result<Self, LogMapError> {
        Self::watched(surface, sources, &Monitor::default())
    }

    /// Computes the log map like [`LogMap::new`], unless `monitor` cancels it.
    ///
    /// # Errors
    /// [`LogMapError::Cancelled`] if it was cancelled, and the errors of [`LogMap::new`].
    pub fn watched(
        surface: &Surface,
        sources: &Sources,
        monitor: &Monitor,
    ) -> Result<Self, LogMapError> {
        let mut starts = Vec::new();
        // Sources off the surface are rejected before the surface is evaluated there.
        sources.seeds(surface)?;
        for (source_index, source) in sources.iter().enumerate() {
            let Source::Point { at, initial } = source else {
                return Err(LogMapError::Curve { source_index });
            };
            let start = Start::new(surface, *at, *initial);
            starts.push(start.ok_or(LogMapError::NoPlane { row: at.x, col: at.y })?);
        }
        let departures = Departures::new(surface, &starts, monitor)?;
        let labels = labels(surface, sources, &departures)?;
        let found = departures.find(&labels);
        Ok(Self {
            chart: surface.chart(),
            coordinates: found.into_iter().map(|way| way.as_vec2().to_array()).collect(),
            labels,
            bases: starts.iter().map(Basis::of).collect(),
        })
    }

    /// Returns the log map, with coordinates only where `distances`, a map of the same grid, reaches. With a map within
    /// a radius (`geosweep::Options::radius`) the result is the log map of that disc.
    ///
    /// # Panics
    /// If there are not as many distances as grid points.
    pub fn where_reached<R: Real>(mut self, distances: &[R]) -> Self {
        assert_eq!(distances.len(), self.coordinates.len(), "one distance for each grid point");
        for (coordinates, distance) in self.coordinates.iter_mut().zip(distances) {
            if !distance.is_finite() {
                *coordinates = [f32::NAN; 2];
            }
        }
        self
    }

    /// Returns the compass bearing in which each point's shortest path leaves its source, row-major, in degrees
    /// clockwise from north (90 is east, 360 is north). It is 0 at the sources and [`NO_BEARING`] where no source
    /// reaches. [`super::BackDirections::compass`] defines east and north.
    ///
    /// # Panics
    /// If `surface` has another size than the log map.
    pub fn source_compass(&self, surface: &Surface) -> Vec<f32> {
        self.bearings(surface, compass)
    }

    /// Returns the directions of [`Self::source_compass`] in degrees counter-clockwise from east, as GRASS
    /// counts them (90 is north, 360 is east).
    ///
    /// # Panics
    /// If `surface` has another size than the log map.
    pub fn source_grass(&self, surface: &Surface) -> Vec<f32> {
        self.bearings(surface, grass)
    }

    fn bearings(&self, surface: &Surface, degrees: fn(DVec2) -> f32) -> Vec<f32> {
        assert_eq!(surface.chart(), self.chart, "the surface has another size");
        let frame = |basis: &Basis| super::frame::Frame::at(surface, basis.at.into());
        let frames: Vec<_> = self.bases.iter().map(frame).collect();
        let bearing = |(&[u, v], &label): (&[f32; 2], &u32)| match (label, [u, v]) {
            (NO_REGION, _) => NO_BEARING,
            (_, [0.0, 0.0]) => 0.0,
            _ => {
                let Basis { u: along, v: across, .. } = self.bases[label as usize];
                let step = f64::from(u) * DVec2::from(along) + f64::from(v) * DVec2::from(across);
                degrees(east_and_north(surface, &frames[label as usize], step))
            }
        };
        self.coordinates.iter().zip(&self.labels).map(bearing).collect()
    }
}

impl Basis {
    fn of(start: &Start) -> Self {
        let [u, v] = start.basis;
        let in_space = |axis| start.frame.in_space(axis).map(|axis| axis.to_array());
        Self {
            at: start.at.to_array(),
            u: u.to_array(),
            v: v.to_array(),
            in_space: in_space(u).zip(in_space(v)).map(|(u, v)| [u, v]),
        }
    }
}

/// Returns the index of the nearest source of each point.
fn labels(
    surface: &Surface,
    sources: &Sources,
    departures: &Departures,
) -> Result<Vec<u32>, LogMapError> {
    let start = sources.start();
    let is_reached = |time: f64| time.is_finite();
    if sources.iter().count() == 1 {
        let label = |&time: &f64| if is_reached(time) { 0 } else { NO_REGION };
        return Ok(departures.times.iter().map(label).collect());
    }
    let distances: Vec<f32> = departures.times.iter().map(|time| (time + start) as f32).collect();
    let edges = EdgeLengths::new(surface)?;
    let regions = Voronoi::new(surface, &edges, sources, &distances);
    Ok(regions.expect("the sources and the map are this surface's").labels)
}
