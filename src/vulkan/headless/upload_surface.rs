//! Uploads a surface to a device, without a renderer.

use std::ops::Range;

use rayon::prelude::*;

use super::context::{Flight, Unwatched};
use crate::surface::{Chart, EdgeLengths, Surface};
use crate::vulkan::device::bands::POINT_BYTES;
use crate::vulkan::device::passes::Splits;
use crate::vulkan::grid_images::GridImages;
use crate::vulkan::{HeadlessSolver, SurfaceOnDevice, VulkanError};

impl HeadlessSolver {
    /// Measures the edges of a surface and uploads them. The CPU has to check the edges in any case, so it
    /// also measures them, in SIMD lanes.
    ///
    /// # Errors
    /// If an edge is too long or too short for single precision, or the grid is too large for the device's images
    /// or memory.
    pub fn upload(&self, surface: &Surface) -> Result<SurfaceOnDevice, VulkanError> {
        let chart = surface.chart();
        let texels = self.for_device.limits.texels(chart)?;
        let pipelines = &self.for_device.pipelines;
        let mut on_device = SurfaceOnDevice::new(&self.context, pipelines, surface, texels)?;
        let is_floor = on_device.anchors.is_some();
        let images = &mut on_device.images;
        let has_positions = surface.geometry().has_positions();
        // The device cannot derive these values from edges.
        let known = match on_device.slowed || !has_positions || surface.is_glued() {
            true => Some(EdgeLengths::<f32>::new(surface)?),
            false => None,
        };
        let across_seams = known.as_ref().filter(|_| surface.is_glued());
        self.run(&mut Unwatched, images, |recorder| recorder.prepare())?;
        let origin = surface.origin();
        let mut flights = self.flights(images)?;
        for (rows, half) in
            images.upload_bands(POINT_BYTES).into_iter().zip(images.halves_in_turn())
        {
            flights[half].wait()?;
            let bytes = &mut images.upload_half(half)[..rows.len() * chart.cols * POINT_BYTES];
            let texels = bytemuck::cast_slice_mut(bytes);
            match across_seams {
                Some(edges) => edges.write_texels(rows.clone(), texels),
                None => {
                    let reach = surface.write_edges(rows.clone(), origin, texels)?;
                    let splits = reach.map_or(Splits::None, Splits::within);
                    on_device.splits = on_device.splits.max(splits);
                }
            }
            let flight = &mut flights[half];
            self.start(&mut Unwatched, flight, images, |r| r.upload_edges(rows, half))?;
        }
        flights.iter_mut().try_for_each(Flight::wait)?;
        let rule = surface.edge_rule();
        if let Some(known) = &known {
            on_device.splits = Splits::within(known.reach());
        }
        if let Some(slowness) = known.as_ref().and_then(EdgeLengths::slowness) {
            self.upload_ground(images, slowness, true)?;
        }
        self.run(&mut Unwatched, images, |recorder| {
            recorder.compute_gaussian_curvature(rule, is_floor)
        })?;
        let is_derived = has_positions && !surface.is_glued();
        if let Some(known) = known.filter(|_| !is_derived && !is_floor) {
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
        let mut flights = self.flights(images)?;
        for (rows, half) in
            images.upload_bands(POINT_BYTES).into_iter().zip(images.halves_in_turn())
        {
            flights[half].wait()?;
            let bytes = rows.len().div_ceil(2) * chart.cols.div_ceil(2) * POINT_BYTES;
            let texels = bytemuck::cast_slice_mut(&mut images.upload_half(half)[..bytes]);
            write_texels(chart, rows.clone(), known, texels);
            let flight = &mut flights[half];
            self.start(&mut Unwatched, flight, images, |r| r.upload_ground(rows, right, half))?;
        }
        flights.iter_mut().try_for_each(Flight::wait)
    }
}

/// Writes values at the points of some rows, 2 x 2 points a texel, from a bordered array, in parallel. The
/// first row must be even.
fn write_texels(chart: Chart, rows: Range<usize>, known: &[f32], texels: &mut [[f32; 4]]) {
    let lines = texels.par_chunks_mut(chart.cols.div_ceil(2));
    lines.zip(rows.clone().into_par_iter().step_by(2)).for_each(|(texels, first)| {
        texels.fill([1.0; 4]);
        for row in first..(first + 2).min(rows.end) {
            for col in 0..chart.cols {
                texels[col / 2][2 * (row % 2) + col % 2] = known[chart.bordered(row, col)];
            }
        }
    });
}
