//! Computes directions from distance maps: back directions, directions in which paths leave their source, log maps, and
//! signed distances.

mod bearing;
mod departures;
mod frame;
mod links;
mod log_map;
mod nearest;
mod place;
mod signed;
mod stencil;
mod ways;

use std::collections::HashMap;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::copies::Copies;
use super::{MapError, PathError, PathTracer};
pub use bearing::NO_BEARING;
use bearing::{compass, east_and_north, grass};
use frame::Frame;
use geosweep_surface::Surface;
use geosweep_surface::{EdgeLengths, Sources};
use links::Links;
pub use links::NO_LINK;
pub use log_map::{Basis, LogMap, LogMapError};
pub use nearest::{NO_SOURCE, Nearest};
pub use signed::{
    SignError, signed_distances, signed_distances_by_mask, signed_distances_to_polygons,
};
use ways::{Way, Ways};

/// The back direction at each grid point: the direction in which the shortest path leaves the point, towards its
/// source.
///
/// It is the direction of the continuous path, which [`PathTracer`] follows, not one of eight directions.
/// Where several fronts meet, it is the direction of one of the shortest paths.
///
/// On closed surfaces the copies of a point have the same direction, each in the rows and columns of its own side. A
/// step may lead beyond that side. At a pole the rows and columns of the copies have no common plane: the path leaves
/// from one copy, and the directions at the others lead along the pole to it.
///
/// ```
/// use geosweep::geometry::BackDirections;
/// use geosweep::surface::EdgeLengths;
/// use geosweep::{Options, Sources, Spacing, Surface, distance_map};
///
/// let surface = Surface::from_heights(21, 21, vec![0.0; 21 * 21], Spacing::square(1.0))?;
/// let sources = Sources::point(10.0, 10.0);
/// let map = distance_map(&surface, &sources, &Options::default())?;
/// let edges = EdgeLengths::new(&surface)?;
/// let ways = BackDirections::new(&surface, &edges, &sources, &map.distances)?;
/// // Four rows above the source and three columns to its left, the way leads down and to the right.
/// let point = 6 * 21 + 7;
/// let [row, col] = ways.in_chart()[point];
/// assert!((row - 0.8).abs() < 1e-5 && (col - 0.6).abs() < 1e-5);
/// assert!((ways.compass()[point] - 143.1301).abs() < 1e-3);
/// assert_eq!(ways.links()[point], 2);
/// assert_eq!(ways.compass()[10 * 21 + 10], 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct BackDirections<'a> {
    surface: &'a Surface,
    paths: PathTracer<'a>,
    copies: Copies,
    /// The arrival times in a bordered array.
    times: Vec<f32>,
    /// The back direction at each point, row-major.
    ways: Vec<Way>,
    /// The back directions in space at the points of poles, by the points' indices.
    at_poles: HashMap<usize, DVec3>,
}

impl<'a> BackDirections<'a> {
    /// Finds the back direction at each point. `distances` is the converged map of these sources on this surface, of
    /// any engine, row-major, as in [`geosweep_surface::DistanceMap::distances`]. `edges` are the edge lengths of
    /// `surface`.
    ///
    /// # Errors
    /// If a source lies off the surface, or the number of distances or edges differs from the number of grid points. It
    /// is also an error if runs of points ([`geosweep_surface::Gluing::Runs`]) are glued on a surface of heights or a
    /// metric, since directions beyond such a seam are not known.
    pub fn new(
        surface: &'a Surface,
        edges: &'a EdgeLengths<f32>,
        sources: &Sources,
        distances: &[f32],
    ) -> Result<Self, MapError> {
        surface.check_directions("the search for directions")?;
        let paths = tracer(surface, edges, sources, distances)?;
        let (copies, times) = Copies::with_times(edges, distances)?;
        let (ways, at_poles) =
            Ways { surface, paths: &paths, copies: &copies, times: &times, sources }.find();
        Ok(Self { surface, paths, copies, times, ways, at_poles })
    }

    /// Returns the back direction in the chart, row-major: the change of row and column of a step of length 1 in grid
    /// steps. It is 0, 0 at the sources and NaN where no source reaches.
    ///
    /// Such a step does not have the length 1 on the surface. For the direction on the surface, take [`Self::in_space`]
    /// or the bearings.
    pub fn in_chart(&self) -> Vec<[f32; 2]> {
        self.each([f32::NAN; 2], [0.0; 2], |_, step| step.normalize().as_vec2().to_array())
    }

    /// Returns the back direction as a unit vector in space, tangent to the surface, row-major. It is 0, 0, 0 at the
    /// sources and NaN where no source reaches. Returns `None` if the surface is given by its metric.
    pub fn in_space(&self) -> Option<Vec<[f32; 3]>> {
        self.surface.geometry().has_positions().then(|| {
            self.each([f32::NAN; 3], [0.0; 3], |index, step| {
                let (row, col) = self.surface.chart().position(index);
                let frame = Frame::at_point(self.surface, row, col);
                let way = frame.in_space(step).unwrap_or_default();
                let way = self.at_poles.get(&index).copied().unwrap_or(way);
                way.normalize_or_zero().as_vec3().to_array()
            })
        })
    }

    /// Returns the compass bearing of the back direction, row-major, in degrees clockwise from north: 90 is east, 180
    /// south, 270 west and 360 north. It is 0 at the sources and [`NO_BEARING`] where no source reaches. These are the
    /// values of back directions in ArcGIS.
    ///
    /// Over heights, columns increase to the east and rows to the south, and bearings are those of the map seen from
    /// above. Over positions and metrics, east is the direction of increasing columns on the surface, and north is at a
    /// right angle to it, on the side of decreasing rows.
    pub fn compass(&self) -> Vec<f32> {
        self.bearings(compass)
    }

    /// Returns the bearing of the back direction in degrees counter-clockwise from east, row-major: 90 is north, 180
    /// west, 270 south and 360 east. It is 0 at the sources and [`NO_BEARING`] where no source reaches. These are the
    /// directions that `r.path` of GRASS follows.
    pub fn grass(&self) -> Vec<f32> {
        self.bearings(grass)
    }

    fn bearings(&self, degrees: fn(DVec2) -> f32) -> Vec<f32> {
        self.each(NO_BEARING, 0.0, |index, step| {
            let (row, col) = self.surface.chart().position(index);
            let frame = Frame::at_point(self.surface, row, col);
            degrees(east_and_north(self.surface, &frame, step))
        })
    }

    /// Returns the code of the next grid point towards the source, row-major: 1 is the neighbour to the east, 2 to the
    /// south-east, 3 to the south, and so on clockwise up to 8, the north-east. It is 0 at a source, and [`NO_LINK`]
    /// where no source reaches. These are the codes of back links in ArcGIS.
    ///
    /// Each link leads to the earlier neighbour that is closest to the back direction. So a walk along links arrives at
    /// a source from every point, on a longer path than the shortest one. The points of a pole, which coincide, are the
    /// exception: walks leave them over equally early points. Walks to a source between grid points end at those grid
    /// points beside it that have no earlier neighbour.
    ///
    /// On closed surfaces the copies of a point have one link. It leads from the copy whose neighbour in this
    /// direction is the earliest; [`Self::walk`] follows it.
    pub fn links(&self) -> Vec<i8> {
        let is_beside_source = |point| self.paths.is_beside_source(point);
        self.grid().find(&self.ways, is_beside_source)
    }

    /// Returns the row-major indices of the grid points on the walk along the `links` of [`Self::links`], from the
    /// point `from` to the end. The result is `from` alone if it is a source or not reached.
    ///
    /// Where the walk passes a seam of a closed surface, it lists two copies of a point in succession.
    ///
    /// # Panics
    /// If there are not as many links as grid points, or `from` is not the index of a grid point.
    pub fn walk(&self, links: &[i8], from: usize) -> Vec<usize> {
        assert_eq!(links.len(), self.ways.len(), "one link for each grid point");
        self.grid().walk(links, from)
    }

    fn grid(&self) -> Links<'_> {
        Links { surface: self.surface, copies: &self.copies, times: &self.times }
    }

    /// Returns a value for each grid point: `unreached` if no source reaches the point, `at_source` at a source, and
    /// otherwise the result of `of` for the point's index and direction.
    fn each<T: Copy + Send + Sync>(
        &self,
        unreached: T,
        at_source: T,
        of: impl Fn(usize, DVec2) -> T + Sync,
    ) -> Vec<T> {
        let value = |(index, way): (usize, &Way)| match *way {
            Way::Unreached => unreached,
            Way::AtSource => at_source,
            Way::Along { step, .. } => of(index, step.as_dvec2()),
        };
        self.ways.par_iter().enumerate().map(value).collect()
    }
}

/// Prepares a map for tracing.
fn tracer<'a>(
    surface: &'a Surface,
    edges: &'a EdgeLengths<f32>,
    sources: &Sources,
    distances: &[f32],
) -> Result<PathTracer<'a>, MapError> {
    PathTracer::new(surface, edges, sources, distances).map_err(|error| match error {
        PathError::Source(error) => MapError::Source(error),
        PathError::Shape { found, rows, cols } => MapError::Shape { found, rows, cols },
        _ => unreachable!("no path is traced"),
    })
}
