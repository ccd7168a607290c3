//! Contours, paths and regions in the host's buffers, compared with the CPU's on the same map.

mod closed;
pub mod contours;
pub mod directions;
mod draw;
mod log_map;
mod paths;
mod refused;
mod regions;

use geosweep::ash;
use geosweep::gpu_allocator::vulkan::Allocator;
use geosweep::surface::Chart;
use geosweep::vulkan::Schedule;
use geosweep::vulkan::embed::{
    Access, CurveBuffer, CurveRecord, CurveVertex, PointSource, Recording, SourceInput,
};
use geosweep::{DistanceMap, Report, Surface, UsedEngine, Wavefront};

use crate::common::Lent;
use crate::embed::stage::{Kept, RASTER, Stage, positions_of};

/// A surface on the device, and a map on it.
pub struct Scene {
    stage: Stage,
    map: DistanceMap,
}

impl Scene {
    fn new(host: impl Into<Lent<Kept>>, surface: &Surface, sources: &[PointSource]) -> Self {
        let stage = Stage::on(host, &RASTER, (surface, None), positions_of(surface));
        let plan = stage.plan(Schedule::Raster, Wavefront::Curved, 6);
        let map = map_of(surface.chart(), stage.map(0, SourceInput::Inline(sources), &plan));
        Self { stage, map }
    }

    /// Records curves, and reads them.
    fn read(
        &mut self,
        curves: CurveBuffer,
        record: impl FnOnce(Recording),
    ) -> (Vec<CurveRecord>, Vec<CurveVertex>) {
        let Stage { host, solver, surface, .. } = &mut self.stage;
        let device = host.device.clone();
        let vertices = (curves.curves * curves.capacity) as usize;
        let bytes = curves.vertices_offset + (vertices * size_of::<CurveVertex>()) as u64;
        let copy = host.buffer(bytes, true);
        host.run(|commands| {
            let recording = solver.record(&device, commands, surface);
            recording.begin(Access::NONE);
            record(recording);
            host.copy_buffer(commands, curves.buffer, &copy, bytes);
        });
        let (records, rest) = copy.bytes().split_at(curves.vertices_offset as usize);
        let record = |number| {
            let first = number * CurveRecord::BYTES as usize;
            bytemuck::pod_read_unaligned(&records[first..][..CurveRecord::BYTES as usize])
        };
        let records = (0..curves.curves as usize).map(record).collect();
        let vertices = rest.chunks_exact(size_of::<CurveVertex>()).take(vertices);
        let vertices = vertices.map(bytemuck::pod_read_unaligned).collect();
        host.free(copy);
        (records, vertices)
    }

    /// Asserts that nothing is left in the allocator, and that the validation layers have reported nothing.
    fn end(self) {
        self.stage.end([]);
    }

    /// Destroys an output of the surface, twice, and ends as [`Self::end`].
    fn end_with(mut self, mut destroy: impl FnMut(&ash::Device, &mut Allocator)) {
        let device = self.stage.host.device.clone();
        destroy(&device, self.stage.host.allocator());
        destroy(&device, self.stage.host.allocator());
        self.end();
    }
}

/// Returns a map in the form in which the engine returns it.
pub fn map_of(chart: Chart, distances: Vec<f32>) -> DistanceMap {
    DistanceMap::new(chart, distances, Report::new(UsedEngine::Vulkan, Wavefront::Curved))
}

/// Returns the vertices of a curve.
fn vertices<'a>(
    record: &CurveRecord,
    number: usize,
    curves: CurveBuffer,
    all: &'a [CurveVertex],
) -> &'a [CurveVertex] {
    assert_eq!((record.instance_count, record.first_instance), (1, 0));
    assert_eq!(record.first_vertex, number as u32 * curves.capacity);
    &all[record.first_vertex as usize..][..record.vertices.min(curves.capacity) as usize]
}

/// Returns the largest distance of the vertices from the surface, relative to its extent.
fn lifted_off(surface: &Surface, vertices: &[CurveVertex]) -> f64 {
    let extent = (positions_of(surface).1)
        .into_iter()
        .filter(|x| x.is_finite())
        .fold(0.0, |a: f32, x| a.max(x.abs()));
    let off = |vertex: &CurveVertex| {
        let exact = lifted(surface, [vertex.row.into(), vertex.col.into()]);
        exact.distance(geosweep::glam::Vec3::from(vertex.position).as_dvec3())
    };
    vertices.iter().map(off).fold(0.0, f64::max) / f64::from(extent)
}

/// Returns the position of a place. A place that rounding has moved off the surface may be in a hole.
fn lifted(surface: &Surface, [row, col]: [f64; 2]) -> geosweep::glam::DVec3 {
    let nudges = [0.0, 1e-5, -1e-5];
    let places = nudges.iter().flat_map(|r| nudges.map(|c| [row + r, col + c]));
    let lift = |place| {
        let curve = geosweep::geometry::Curve { vertices: vec![place], closed: false };
        curve.lift(surface).ok()
    };
    let mut found = places.filter_map(lift).flatten();
    found.next().unwrap_or_else(|| panic!("{row},{col} is off the surface"))
}
