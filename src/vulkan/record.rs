//! Recording: each function appends commands to a command buffer that the caller has begun, and
//! ends with a barrier after which the next function may be recorded. None submits or waits.

use ash::vk;
use bytemuck::{NoUninit, bytes_of};

use super::barrier::{self, CLEAR, COPY, HOST_READ, SHADER, SHADER_WRITE};
use super::plan::{Scan, Step};
use super::{GridImages, Pipelines, ScanPipelines};
use crate::constants::{CURVATURE, FAR, GAUSSIAN, TIME, WORKGROUP};
use crate::surface::{Chart, EdgeRule, Geometry, Spacing, Surface};

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
}

#[derive(Clone, Copy, NoUninit)]
#[repr(C)]
struct UnpackBand {
    grid: [i32; 2],
    first_row: i32,
    band_rows: i32,
}

#[derive(Clone, Copy, NoUninit)]
#[repr(C)]
struct Line {
    line: i32,
    first: i32,
    count: i32,
    renews: u32,
}

/// Brings new images into their layout, with no edge and no point reached.
pub fn prepare(device: &ash::Device, commands: vk::CommandBuffer, grid: &GridImages) {
    for image in [&grid.edges, &grid.fronts[0], &grid.fronts[1]] {
        barrier::into_general(device, commands, image.image, CLEAR);
    }
    clear(device, commands, grid.edges.image, 0, FAR);
    for image in &grid.fronts {
        clear(device, commands, image.image, TIME, FAR);
        clear(device, commands, image.image, CURVATURE, 0.0);
        clear(device, commands, image.image, GAUSSIAN, 0.0);
    }
    barrier::memory(device, commands, CLEAR, SHADER);
}

/// The rows whose points are needed to measure the edges of a band: two before, since an edge to
/// the north also depends on how the surface bends at its other end, and one after.
pub fn rows_around(band: &std::ops::Range<usize>, chart: Chart) -> std::ops::Range<usize> {
    band.start.saturating_sub(BEFORE)..(band.end + AFTER).min(chart.rows)
}

const BEFORE: usize = 2;
const AFTER: usize = 1;
/// Rows around a band, at most.
pub(crate) const HALO: usize = BEFORE + AFTER;

/// Measures the edges of a band of rows; the points of [`rows_around`] it are in the upload buffer.
pub fn measure_edges(
    device: &ash::Device,
    commands: vk::CommandBuffer,
    pipelines: &Pipelines,
    grid: &GridImages,
    surface: &Surface,
    rows: std::ops::Range<usize>,
) {
    let (pipeline, spacing) = match surface.geometry() {
        Geometry::Positions(_) => (pipelines.edges_from_positions, Spacing::square(1.0)),
        Geometry::Heights { spacing, .. } => (pipelines.edges_from_heights, *spacing),
        Geometry::Metric(_) => (pipelines.edges_from_metric, Spacing::square(1.0)),
    };
    let band = EdgesBand {
        grid: [grid.chart.cols as i32, grid.chart.rows as i32],
        first_row: rows.start as i32,
        band_rows: rows.len() as i32,
        buffer_row: rows_around(&rows, grid.chart).start as i32,
        dx: spacing.dx as f32,
        dy: spacing.dy as f32,
        arcs: (surface.edge_rule() == EdgeRule::Arc).into(),
    };
    bind(device, commands, pipelines, grid, pipeline, 0);
    dispatch(device, commands, pipelines, &band, grid.chart.cols as u32, rows.len() as u32);
    barrier::memory(device, commands, SHADER_WRITE, SHADER);
}

/// Computes the surface's Gaussian curvature, once all edges are measured by the rule.
pub fn bend(
    device: &ash::Device,
    commands: vk::CommandBuffer,
    pipelines: &Pipelines,
    grid: &GridImages,
    rule: EdgeRule,
) {
    let size = FanSize {
        texels: [grid.texels.inner_cols().len() as u32, grid.texels.inner_rows().len() as u32],
        share_of_fan: rule.share_of_fan() as f32,
    };
    for pipeline in [pipelines.fan_curvature, pipelines.gaussian_curvature] {
        bind(device, commands, pipelines, grid, pipeline, 0);
        dispatch(device, commands, pipelines, &size, size.texels[0], size.texels[1]);
        barrier::memory(device, commands, SHADER_WRITE, SHADER);
    }
    // What the first pass has left for the second.
    barrier::memory(device, commands, SHADER, CLEAR);
    clear(device, commands, grid.fronts[1].image, CURVATURE, 0.0);
    barrier::memory(device, commands, CLEAR, SHADER);
}

/// Forgets the map: no point is reached in either image.
pub fn forget(device: &ash::Device, commands: vk::CommandBuffer, grid: &GridImages) {
    barrier::memory(device, commands, SHADER, CLEAR);
    for image in &grid.fronts {
        clear(device, commands, image.image, TIME, FAR);
        clear(device, commands, image.image, CURVATURE, 0.0);
    }
    barrier::memory(device, commands, CLEAR, SHADER);
}

/// Sets the texels with sources, `count` of which are in the upload buffer, in image 0.
pub fn seed(
    device: &ash::Device,
    commands: vk::CommandBuffer,
    pipelines: &Pipelines,
    grid: &GridImages,
    count: u32,
) {
    bind(device, commands, pipelines, grid, pipelines.seed, 0);
    dispatch(device, commands, pipelines, &count, count, 1);
    barrier::memory(device, commands, SHADER_WRITE, SHADER);
}

/// Dispatches every scan over no texel, since drivers may compile a pipeline at its first
/// dispatch.
pub fn warm_up(
    device: &ash::Device,
    commands: vk::CommandBuffer,
    pipelines: &Pipelines,
    scans: &ScanPipelines,
    grid: &GridImages,
) {
    for pipeline in scans.scans {
        bind(device, commands, pipelines, grid, pipeline, 0);
        dispatch(
            device,
            commands,
            pipelines,
            &Line { line: 0, first: 0, count: 0, renews: 0 },
            1,
            1,
        );
        barrier::memory(device, commands, SHADER_WRITE, SHADER);
    }
}

/// Runs the steps of an iteration, which may renew curved fronts, and leaves its residual in the
/// host's buffer.
pub fn iterate(
    device: &ash::Device,
    commands: vk::CommandBuffer,
    pipelines: &Pipelines,
    scans: &ScanPipelines,
    grid: &GridImages,
    steps: &[Step],
    renews: bool,
) {
    barrier::memory(device, commands, COPY, CLEAR);
    // SAFETY: the buffer holds one word, and the barrier has ended its last copy.
    unsafe { device.cmd_fill_buffer(commands, grid.residual.buffer, 0, vk::WHOLE_SIZE, 0) };
    barrier::memory(device, commands, CLEAR, SHADER);

    let mut bound = None;
    for step in steps {
        match step {
            Step::Pass(pass) => {
                if bound != Some(pass.scan) {
                    let pipeline = scans.scans[pipeline_index(pass.scan)];
                    bind(device, commands, pipelines, grid, pipeline, pass.writes);
                    bound = Some(pass.scan);
                }
                let count = pass.texels.end - pass.texels.start;
                let line = Line {
                    line: pass.line as i32,
                    first: pass.texels.start as i32,
                    count: count as i32,
                    renews: renews.into(),
                };
                dispatch(device, commands, pipelines, &line, count, 1);
            }
            Step::Barrier => barrier::memory(device, commands, SHADER_WRITE, SHADER),
        }
    }

    barrier::memory(device, commands, SHADER_WRITE, COPY);
    let copy = [vk::BufferCopy::default().size(size_of::<u32>() as u64)];
    // SAFETY: both buffers hold one word.
    unsafe {
        device.cmd_copy_buffer(commands, grid.residual.buffer, grid.residual_on_host.buffer, &copy);
    }
    barrier::memory(device, commands, CLEAR, HOST_READ);
}

/// Unpacks the arrival times in image 0, a band of rows, into the read-back buffer.
pub fn unpack(
    device: &ash::Device,
    commands: vk::CommandBuffer,
    pipelines: &Pipelines,
    grid: &GridImages,
    rows: std::ops::Range<usize>,
) {
    let band = UnpackBand {
        grid: [grid.chart.cols as i32, grid.chart.rows as i32],
        first_row: rows.start as i32,
        band_rows: rows.len() as i32,
    };
    // The set that writes image 1 reads image 0.
    bind(device, commands, pipelines, grid, pipelines.unpack, 1);
    let (width, height) = (grid.chart.cols.div_ceil(2), rows.len().div_ceil(2));
    dispatch(device, commands, pipelines, &band, width as u32, height as u32);
    barrier::memory(device, commands, SHADER_WRITE, HOST_READ);
}

fn pipeline_index(scan: Scan) -> usize {
    Scan::ALL.iter().position(|&other| other == scan).expect("all scans are listed")
}

/// Fills a layer of an image.
fn clear(
    device: &ash::Device,
    commands: vk::CommandBuffer,
    image: vk::Image,
    layer: u32,
    value: f64,
) {
    let value = vk::ClearColorValue { float32: [value as f32; 4] };
    let range =
        vk::ImageSubresourceRange { base_array_layer: layer, layer_count: 1, ..barrier::COLOR };
    // SAFETY: the image has the layer, is in this layout, and the layer is used by nothing else
    // until the next barrier.
    unsafe {
        let layout = vk::ImageLayout::GENERAL;
        device.cmd_clear_color_image(commands, image, layout, &value, &[range]);
    }
}

fn bind(
    device: &ash::Device,
    commands: vk::CommandBuffer,
    pipelines: &Pipelines,
    grid: &GridImages,
    pipeline: vk::Pipeline,
    writes: usize,
) {
    let compute = vk::PipelineBindPoint::COMPUTE;
    // SAFETY: pipeline, layout and set belong together and are alive.
    unsafe {
        device.cmd_bind_pipeline(commands, compute, pipeline);
        device.cmd_bind_descriptor_sets(
            commands,
            compute,
            pipelines.layout,
            0,
            &[grid.sets[writes]],
            &[],
        );
    }
}

/// Dispatches `width` x `height` invocations, in groups along the width.
fn dispatch(
    device: &ash::Device,
    commands: vk::CommandBuffer,
    pipelines: &Pipelines,
    constants: &impl NoUninit,
    width: u32,
    height: u32,
) {
    let stages = vk::ShaderStageFlags::COMPUTE;
    // SAFETY: a pipeline with this layout is bound, and the constants fit its range.
    unsafe {
        device.cmd_push_constants(commands, pipelines.layout, stages, 0, bytes_of(constants));
        device.cmd_dispatch(commands, width.div_ceil(WORKGROUP), height, 1);
    }
}
