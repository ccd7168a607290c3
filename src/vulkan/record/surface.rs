//! Records the preparation of a surface: its images, the lengths of its edges, and its curvature.

use std::ops::Range;

use ash::vk;

use super::pass_kind::PassKind;
use super::recorder::Recorder;
use crate::constants::{FAR, LAYERS, WITH_CORNERS};
use crate::surface::{Chart, EdgeRule, Spacing};
use crate::vulkan::TexelChart;
use crate::vulkan::device::bands::rows_around;
use crate::vulkan::device::barrier::{SHADER, SHADER_WRITE, TRANSFER_WRITE};
use crate::vulkan::device::passes::{FAN_CURVATURE, GAUSSIAN_CURVATURE, TYPICAL_EDGE};
use crate::vulkan::device::shaders::{
    edges_from_heights, fan_curvature, gaussian_curvature, typical_edge,
};
use crate::vulkan::point_kind::PointKind;

impl Recorder<'_> {
    /// Transitions new images into their layout, and clears them: there are no edges, and all points are unreached.
    pub(crate) fn prepare(&self) {
        // Four points' edges, the surface's curvature and two images of fronts.
        let written = (4 + 1 + 2 * u64::from(LAYERS)) * 16;
        let _pass = self.pass_over_images(PassKind::Prepare, written);
        let grid = self.grid;
        let layouts = (vk::ImageLayout::UNDEFINED, vk::ImageLayout::GENERAL);
        for image in [&grid.edges, &grid.gaussian, &grid.fronts[0], &grid.fronts[1]] {
            // The barrier covers passes of an earlier map, if the surface is prepared again.
            self.image_barrier(image.image, SHADER, TRANSFER_WRITE, layouts);
        }
        self.clear(grid.edges.image, 0, FAR);
        // The image of curvatures also holds the slownesses, if the surface has them. The whole image is then cleared
        // to 1. At texels without points, a curvature of 1 has no effect, since no edge leads to them.
        self.clear(grid.gaussian.image, 0, if grid.is_slowed() { 1.0 } else { 0.0 });
        self.clear_fronts();
        if let Some(copies) = &self.grid.copies {
            self.write_copies(copies);
        }
        self.barrier(TRANSFER_WRITE, SHADER);
    }

    /// Measures the edges of a band of rows. The upload buffer must hold the points of the rows that [`rows_around`]
    /// returns for the band.
    pub(crate) fn measure(&self, kind: PointKind, arcs: bool, rows: Range<usize>) {
        let chart = self.grid.chart;
        let size = [chart.cols as u32, rows.len() as u32];
        let halo = self.grid.lattice.halo();
        let around = rows_around(&rows, chart, halo[1]);
        // Each point has four lengths.
        let wide = self.grid.lattice.with_halo(chart);
        let read = kind.uploaded_bytes() * (around.len() * wide.cols) as u64;
        let written = 16 * (rows.len() * chart.cols) as u64;
        let _pass = self.pass_moving(PassKind::Edges, [Some(read), Some(written)]);
        let spacing = kind.spacing().unwrap_or(Spacing::square(1.0));
        let band = edges_from_heights::Push {
            grid: [chart.cols as i32, chart.rows as i32],
            halo: halo.map(|lines| lines as i32),
            first_row: rows.start as i32,
            band_rows: rows.len() as i32,
            buffer_row: around.start as i32,
            dx: spacing.dx as f32,
            dy: spacing.dy as f32,
            arcs: if arcs && self.grid.lattice.is_folded {
                WITH_CORNERS as i32
            } else {
                arcs.into()
            },
            slowed: self.grid.is_slowed().into(),
        };
        let is_last = rows.end == chart.rows;
        self.run(self.pipelines.of(kind.edges()), 0, &band, size);
        self.barrier(SHADER_WRITE, SHADER);
        if is_last {
            self.find_typical_edge();
        }
    }

    /// Finds the typical length of edges after all of them have been measured. It determines the order in which maps
    /// visit tiles.
    fn find_typical_edge(&self) {
        let texels = self.grid.texels.inner().map(|texels| texels as i32);
        self.run(self.pipelines.of(TYPICAL_EDGE), 0, &typical_edge::Push { texels }, [1, 1]);
    }

    /// Copies the edges of a band of rows, four lengths a point, from one `half` of the upload buffer to their image.
    pub(crate) fn upload_edges(&self, rows: Range<usize>, half: usize) {
        let border = TexelChart::POINTS_BEFORE;
        let first = [border, border + rows.start as u32];
        let size = [self.grid.chart.cols as u32, rows.len() as u32];
        self.upload(self.grid.edges.image, first, size, half);
        if rows.end == self.grid.chart.rows {
            self.find_typical_edge();
        }
    }

    /// Copies values at the points of a band of rows, 2 x 2 a texel, from one `half` of the upload buffer. If `right`
    /// is set, these are slownesses, whose texels lie to the right of those of the Gaussian curvature.
    pub(crate) fn upload_ground(&self, rows: Range<usize>, right: bool, half: usize) {
        let (row, col, _) = TexelChart::texel_of(rows.start, 0);
        let first = [if right { self.grid.texels.cols + col } else { col }, row];
        let size = [self.grid.chart.cols.div_ceil(2) as u32, rows.len().div_ceil(2) as u32];
        self.upload(self.grid.gaussian.image, first, size, half);
    }

    /// Copies texels from one `half` of the upload buffer to an image. `first` is the column and row of the first
    /// texel, and `size` their number in both directions.
    fn upload(&self, image: vk::Image, [x, y]: [u32; 2], [width, height]: [u32; 2], half: usize) {
        let bytes = 16 * u64::from(width) * u64::from(height);
        let _pass = self.pass_moving(PassKind::Edges, [Some(bytes); 2]);
        self.barrier(SHADER, TRANSFER_WRITE);
        let offset = vk::Offset3D { x: x as i32, y: y as i32, z: 0 };
        let extent = vk::Extent3D { width, height, depth: 1 };
        let to = (image, vk::ImageLayout::GENERAL);
        self.copy_to_image(self.grid.upload_at(half), to, (offset, extent));
        self.barrier(TRANSFER_WRITE, SHADER);
    }

    /// Computes the surface's Gaussian curvature after all edges have been measured by `rule`. On floor plans
    /// (`is_floor`) it also finds the corners at which shortest paths can bend.
    pub(crate) fn compute_gaussian_curvature(&self, rule: EdgeRule, is_floor: bool) {
        let inner = self.grid.texels.inner();
        let texels = inner.map(|texels| texels as i32);
        let share_of_fan = rule.share_of_fan() as f32;
        let Chart { rows, cols } = self.grid.chart;
        let (grid, lattice) = ([cols as i32, rows as i32], self.grid.lattice.codes());
        // Each pass reads the lengths of four points' edges. The second pass also reads the fan curvature of each
        // point.
        let pass = self.pass_of_each(PassKind::Curvature, inner, [64, 16]);
        let is_slowed = self.grid.is_slowed().into();
        let size = fan_curvature::Push { texels, share_of_fan, is_slowed, grid, lattice };
        self.run(self.pipelines.of(FAN_CURVATURE), 0, &size, inner);
        self.barrier(SHADER_WRITE, SHADER);
        drop(pass);
        let _pass = self.pass_of_each(PassKind::Curvature, inner, [64 + 16, 16]);
        let (is_floor, is_glued) = (is_floor.into(), self.grid.copies.is_some().into());
        let size =
            gaussian_curvature::Push { texels, share_of_fan, is_floor, grid, lattice, is_glued };
        self.run(self.pipelines.of(GAUSSIAN_CURVATURE), 0, &size, inner);
        self.barrier(SHADER_WRITE, SHADER);
    }
}
