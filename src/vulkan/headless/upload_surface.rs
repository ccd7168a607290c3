//! Uploads a surface to a device, without a renderer.

use std::ops::Range;

use super::context::Unwatched;
use crate::surface::{Chart, EdgeLengths, Surface};
use crate::vulkan::grid_images::{GridImages, POINT_BYTES, bands, transfer_bytes};
use crate::vulkan::{HeadlessSolver, SurfaceOnDevice, VulkanError};

impl HeadlessSolver {
    /// Measures the edges of a surface and uploads them. The processor checks them in any case, and measures
    /// them in SIMD lanes.
    ///
    /// # Errors
    /// If an edge is too long or too short for single precision, or the grid is too large for the device's
    /// images or memory.
    pub fn upload(&self, surface: &Surface) -> Result<SurfaceOnDevice, VulkanError> {
        let chart = surface.chart();
        let texels = self.for_device.limits.texels(chart)?;
        let pipelines = &self.for_device.pipelines;
        let mut on_device = SurfaceOnDevice::new(&self.context, pipelines, surface, texels)?;
        let is_floor = on_device.anchors.is_some();
        let images = &mut on_device.images;
        let slowed = on_device.slowed;
        self.run(&mut Unwatched, images, |recorder| recorder.prepare())?;
        let origin = surface.origin();
        for rows in bands(chart, POINT_BYTES, transfer_bytes(chart)) {
            let bytes = &mut images.staging()[..rows.len() * chart.cols * POINT_BYTES];
            let texels = bytemuck::cast_slice_mut(bytes);
            on_device.splits |= surface.write_edges(rows.clone(), origin, texels)?;
            self.run(&mut Unwatched, images, |recorder| recorder.upload_edges(rows))?;
        }
        let rule = surface.edge_rule();
        let has_positions = surface.geometry().has_positions();
        // The device cannot derive these values from edges.
        let known = match slowed || !has_positions {
            true => Some(EdgeLengths::<f32>::new(surface)?),
            false => None,
        };
        if let Some(known) = &known {
            on_device.splits = known.has_obtuse_triangles();
        }
        if let Some(slowness) = known.as_ref().and_then(EdgeLengths::slowness) {
            self.upload_ground(images, slowness, true)?;
        }
        self.run(&mut Unwatched, images, |recorder| recorder.bend(rule, is_floor))?;
        if let Some(known) = known.filter(|_| !has_positions && !is_floor) {
            self.upload_ground(images, known.gaussian_curvature(), false)?;
        }
        self.context.check_validation()?;
        Ok(on_device)
    }

    /// Uploads values at the points, given as a bordered array: see
    /// [`crate::vulkan::record::Recorder::upload_ground`].
    fn upload_ground(
        &self,
        images: &mut GridImages,
        known: &[f32],
        right: bool,
    ) -> Result<(), VulkanError> {
        let chart = images.chart;
        for rows in bands(chart, POINT_BYTES, transfer_bytes(chart)) {
            let bytes = rows.len().div_ceil(2) * chart.cols.div_ceil(2) * POINT_BYTES;
            let texels = bytemuck::cast_slice_mut(&mut images.staging()[..bytes]);
            write_texels(chart, rows.clone(), known, texels);
            self.run(&mut Unwatched, images, |recorder| recorder.upload_ground(rows, right))?;
        }
        Ok(())
    }
}

/// Writes values at the points of some rows, 2 x 2 points a texel, from a bordered array. The first row must
/// be even.
fn write_texels(chart: Chart, rows: Range<usize>, known: &[f32], texels: &mut [[f32; 4]]) {
    texels.fill([1.0; 4]);
    for row in rows.clone() {
        for col in 0..chart.cols {
            let texel = (row - rows.start) / 2 * chart.cols.div_ceil(2) + col / 2;
            texels[texel][2 * (row % 2) + col % 2] = known[chart.bordered(row, col)];
        }
    }
}
