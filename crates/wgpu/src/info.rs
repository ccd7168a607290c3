//! Parameters of maps and frames.

use geosweep::surface::{Chart, Gluing};
use geosweep::vulkan::MapLimit;
use geosweep::vulkan::embed::{LevelInput, PointSource};
use geosweep::{Stop, Wavefront};

/// Parameters of a [`crate::DistanceMap`]: the vertices, and the outputs that it has.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct MapInfo<'a> {
    /// Buffer of vertices, row by row, with usage `STORAGE`. Each begins with three floats: x, y and z.
    pub vertices: &'a wgpu::Buffer,
    /// Bytes from one vertex to the next; a multiple of 4.
    pub stride: u64,
    /// Rows and columns of vertices.
    pub chart: Chart,
    /// Sides of the grid that coincide, as in [`geosweep::vulkan::embed::SurfaceInfo::gluing`].
    pub gluing: Option<&'a Gluing>,
    /// Shape of the wavefront; one of those for which the [`crate::MapDevice`] was made.
    pub wavefront: Wavefront,
    /// When a map has converged.
    pub stop: Stop,
    /// Largest number of iterations in a frame.
    pub iterations: u32,
    /// Room for vertices of contours; two for each segment. 0 for no contours.
    pub contour_vertices: u32,
    /// Whether there is a buffer of labels, the index of the nearest source of each point.
    pub regions: bool,
    /// Whether there is a texture of the directions of ways back.
    pub directions: bool,
    /// Whether there is a texture of the log map. Glued surfaces have none.
    pub log_map: bool,
}

impl<'a> MapInfo<'a> {
    /// Returns the parameters of a map with curved fronts, up to 8 iterations a frame, and no output but distances.
    pub fn new(vertices: &'a wgpu::Buffer, stride: u64, chart: Chart) -> Self {
        Self {
            vertices,
            stride,
            chart,
            gluing: None,
            wavefront: Wavefront::Curved,
            stop: Stop::within(1e-5).or_after(100),
            iterations: 8,
            contour_vertices: 0,
            regions: false,
            directions: false,
            log_map: false,
        }
    }

    /// Sets [`MapInfo::gluing`].
    pub fn with_gluing(self, gluing: &'a Gluing) -> Self {
        Self { gluing: Some(gluing), ..self }
    }

    /// Sets [`MapInfo::wavefront`].
    pub fn with_wavefront(self, wavefront: Wavefront) -> Self {
        Self { wavefront, ..self }
    }

    /// Sets [`MapInfo::stop`] and [`MapInfo::iterations`].
    pub fn with_stop(self, stop: Stop, iterations: u32) -> Self {
        Self { stop, iterations, ..self }
    }

    /// Adds contours, with room for this number of vertices.
    pub fn with_contours(self, vertices: u32) -> Self {
        Self { contour_vertices: vertices, ..self }
    }

    /// Adds regions.
    pub fn with_regions(self) -> Self {
        Self { regions: true, ..self }
    }

    /// Adds directions.
    pub fn with_directions(self) -> Self {
        Self { directions: true, ..self }
    }

    /// Adds the log map, which a glued surface cannot have.
    pub fn with_log_map(self) -> Self {
        Self { log_map: true, ..self }
    }
}

/// Parameters of a map in a frame.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct MapFrame<'a> {
    /// Sources of the fronts, up to 1024.
    pub sources: &'a [PointSource],
    /// Part of the surface that is needed.
    pub limit: MapLimit<'a>,
    /// Distance at points that no source reaches, or that lie beyond the limit. An infinite one turns to NaN in filters.
    pub unreached: f32,
    /// Levels of the contours, if the map has some.
    pub levels: LevelInput<'a>,
    /// Largest distance of points with coordinates in the log map. Others have [`MapFrame::beyond`].
    pub log_map_radius: f32,
    /// Both coordinates of the log map beyond its radius.
    pub beyond: f32,
}

impl<'a> MapFrame<'a> {
    /// Returns the parameters of a whole map, with -1 at points that are not reached, no levels, and 1e6 in the log map
    /// where it has no coordinates.
    pub fn new(sources: &'a [PointSource]) -> Self {
        Self {
            sources,
            limit: MapLimit::NONE,
            unreached: -1.0,
            levels: LevelInput::List(&[]),
            log_map_radius: f32::INFINITY,
            beyond: 1e6,
        }
    }

    /// Ends the map at a distance.
    pub fn within(self, radius: f32) -> Self {
        Self { limit: MapLimit::at(radius), ..self }
    }

    /// Sets [`MapFrame::limit`].
    pub fn with_limit(self, limit: MapLimit<'a>) -> Self {
        Self { limit, ..self }
    }

    /// Sets [`MapFrame::unreached`].
    pub fn with_unreached(self, unreached: f32) -> Self {
        Self { unreached, ..self }
    }

    /// Sets [`MapFrame::levels`].
    pub fn with_levels(self, levels: LevelInput<'a>) -> Self {
        Self { levels, ..self }
    }

    /// Sets [`MapFrame::log_map_radius`] and [`MapFrame::beyond`].
    pub fn with_log_map_within(self, radius: f32, beyond: f32) -> Self {
        Self { log_map_radius: radius, beyond, ..self }
    }
}
