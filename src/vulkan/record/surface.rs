//! A surface: its images, the lengths of its edges, its curvature.

use std::ops::Range;

use ash::vk;
use bytemuck::NoUninit;

use super::{Recorder, dispatched};
use crate::constants::{BORDER, FAR, LAYERS};
use crate::surface::{Chart, EdgeRule, Spacing};
use crate::vulkan::barrier::{CLEAR, NOTHING, SHADER, SHADER_WRITE};
use crate::vulkan::profile::{PassKind, PassRecord, Work};

/// What edges are measured from.
#[derive(Clone, Copy, Debug)]
pub(crate) enum EdgeSource {
    Positions,
    Heights,
    Metric,
}

impl EdgeSource {
    /// Numbers of a point, without its slowness.
    pub(crate) fn components(self) -> u64 {
        match self {
            Self::Positions | Self::Metric => 3,
            Self::Heights => 1,
        }
    }

    /// Bytes of a point in the upload buffer, which holds its slowness too.
    pub(crate) fn bytes(self) -> u64 {
        4 * (self.components() + 1)
    }
}

#[derive(Clone, Copy, NoUninit)]
#[repr(C)]
struct EdgesBand {
    grid: [i32; 2],
    first_row: i32,
    band_rows: i32,
    buffer_row: i32,
    dx: f32,
    dy: f32,
    arcs: i32,
}

#[derive(Clone, Copy, NoUninit)]
#[repr(C)]
struct FanSize {
    texels: [u32; 2],
    share_of_fan: f32,
    is_floor: u32,
}

/// The rows whose points are needed to measure the edges of a band. An edge to the north also depends
/// on how the surface bends at its other end; at an end where the line ends, at the next two points
/// inwards.
pub(crate) fn rows_around(band: &Range<usize>, chart: Chart) -> Range<usize> {
    band.start.saturating_sub(BEFORE)..(band.end + AFTER).min(chart.rows)
}

const BEFORE: usize = 3;
const AFTER: usize = 2;
/// Rows around a band, at most.
pub(crate) const HALO: usize = BEFORE + AFTER;

impl Recorder<'_> {
    /// Brings new images into their layout, with no edge and no point reached.
    pub(crate) fn prepare(&self) {
        // Four points' edges, the surface's curvature and two images of fronts.
        let written = (4 + 1 + 2 * u64::from(LAYERS)) * 16;
        let _pass = self.pass_over_images(PassKind::Prepare, 0, written);
        let grid = self.grid;
        let layouts = (vk::ImageLayout::UNDEFINED, vk::ImageLayout::GENERAL);
        for image in [&grid.edges, &grid.gaussian, &grid.fronts[0], &grid.fronts[1]] {
            self.image_barrier(image.image, NOTHING, CLEAR, layouts);
        }
        self.clear(grid.edges.image, 0, FAR);
        self.clear(grid.gaussian.image, 0, 0.0);
        self.clear_fronts();
        self.barrier(CLEAR, SHADER);
    }

    /// Measures the edges of a band of rows; the points of [`rows_around`] it are in the upload
    /// buffer.
    pub(crate) fn measure(
        &self,
        source: EdgeSource,
        spacing: Spacing,
        arcs: bool,
        rows: Range<usize>,
    ) {
        let (pipelines, chart) = (self.pipelines, self.grid.chart);
        let size = [chart.cols as u32, rows.len() as u32];
        let around = rows_around(&rows, chart);
        // Four lengths of each point.
        let [read, written] = [source.bytes() * around.len() as u64, 16 * rows.len() as u64]
            .map(|bytes| bytes * chart.cols as u64);
        let work = Work::of_bytes(read, written);
        let _pass = self.pass_with(PassRecord { work, ..dispatched(PassKind::Edges, size) });
        let pipeline = match source {
            EdgeSource::Positions => pipelines.edges_from_positions,
            EdgeSource::Heights => pipelines.edges_from_heights,
            EdgeSource::Metric => pipelines.edges_from_metric,
        };
        let band = EdgesBand {
            grid: [chart.cols as i32, chart.rows as i32],
            first_row: rows.start as i32,
            band_rows: rows.len() as i32,
            buffer_row: around.start as i32,
            dx: spacing.dx as f32,
            dy: spacing.dy as f32,
            arcs: arcs.into(),
        };
        self.bind(pipeline, 0);
        self.dispatch(&band, size);
        self.barrier(SHADER_WRITE, SHADER);
    }

    /// Copies the edges of a band of rows, four of each point, from the upload buffer.
    pub(crate) fn upload_edges(&self, rows: Range<usize>) {
        let extent = vk::Extent3D {
            width: self.grid.chart.cols as u32,
            height: rows.len() as u32,
            depth: 1,
        };
        let bytes = 16 * u64::from(extent.width) * u64::from(extent.height);
        let _pass = self.pass_of_copy(PassKind::Edges, bytes);
        self.barrier(SHADER, CLEAR);
        let border = 2 * BORDER as i32;
        let offset = vk::Offset3D { x: border, y: border + rows.start as i32, z: 0 };
        self.copy_to_image(self.grid.upload.buffer, self.grid.edges.image, (offset, extent));
        self.barrier(CLEAR, SHADER);
    }

    /// Computes the surface's Gaussian curvature, once all edges are measured by the rule, and on floor plans
    /// where shortest paths can bend.
    pub(crate) fn bend(&self, rule: EdgeRule, is_floor: bool) {
        let texels = self.grid.texels.inner();
        let share_of_fan = rule.share_of_fan() as f32;
        let size = FanSize { texels, share_of_fan, is_floor: is_floor.into() };
        for pipeline in [self.pipelines.fan_curvature, self.pipelines.gaussian_curvature] {
            // Lengths of the edges of four points, and a number of each besides in the second pass.
            let read = if pipeline == self.pipelines.fan_curvature { 64 } else { 64 + 16 };
            let _pass = self.pass_of_each(PassKind::Curvature, texels, [read, 16]);
            self.bind(pipeline, 0);
            self.dispatch(&size, texels);
            self.barrier(SHADER_WRITE, SHADER);
        }
    }
}
