//! Parts of the examples without a window: a renderer, a map on a surface of it, and pictures.

#![allow(dead_code, reason = "each example uses its part")]

#[path = "../../tests/common/host/mod.rs"]
pub mod host;

use std::error::Error;

use geosweep::ash::vk;
use geosweep::glam::Vec3;
use geosweep::glam::camera::rh::{proj, view};
use geosweep::surface::Chart;
use geosweep::vulkan::embed::{self, FrameSurface, Plan, Recording, Solver, SurfaceInfo};
use geosweep::vulkan::{Method, Schedule};
use geosweep::{Stop, Wavefront};

use host::{Canvas, Host, HostBuffer, HostPass};

const FORMAT: vk::Format = vk::Format::R8G8B8A8_UNORM;
const DEPTH: vk::Format = vk::Format::D16_UNORM;
const BACKGROUND: [f32; 4] = [0.93, 0.92, 0.90, 1.0];

/// A solver with raster scans and curved fronts, a surface, and a plan for maps of each frame.
pub struct Map {
    pub solver: Solver,
    pub surface: FrameSurface,
    pub plan: Plan,
}

impl Map {
    /// Creates the objects that are needed once.
    pub fn new(host: &mut Host, info: &SurfaceInfo) -> Self {
        let device = host.device.clone();
        let passes = [(Schedule::Raster, Wavefront::Curved)];
        let solver = embed::Solver::new(&host.instance, host.physical_device, &device, &passes);
        let solver = solver.expect("the device meets the requirements");
        let surface = solver.surface(&device, host.allocator(), info).expect("there is memory");
        let method = Method::new(Wavefront::Curved, Stop::within(1e-4).or_after(100));
        let plan = solver.plan(info.chart, method, 12).expect("the passes are there");
        let plan = if surface.is_glued() { plan.over_seams() } else { plan };
        host.run(|commands| solver.record(&device, commands, &surface).prepare());
        Self { solver, surface, plan }
    }

    pub fn record<'a>(&'a self, host: &'a Host, commands: vk::CommandBuffer) -> Recording<'a> {
        self.solver.record(&host.device, commands, &self.surface)
    }

    /// Asserts that the map of the last frame has converged.
    pub fn check(&self) {
        let outcome = self.surface.outcome(0).expect("there is a slot");
        assert!(outcome.converged, "{outcome:?}");
    }

    pub fn destroy(mut self, host: &mut Host) {
        let device = host.device.clone();
        self.surface.destroy(&device, host.allocator());
        self.solver.destroy(&device);
    }
}

/// Returns the workgroups of 64 invocations for a number of items.
pub fn groups(items: usize) -> u32 {
    items.div_ceil(64) as u32
}

/// Returns the numbers of the transformation to clip coordinates for an eye that looks at a place, with z upwards.
/// `lens` has the vertical angle of view and the nearest and the farthest depth.
pub fn camera([eye, at]: [Vec3; 2], lens: [f32; 3], [width, height]: [u32; 2]) -> Vec<f32> {
    let aspect = width as f32 / height as f32;
    // In clip coordinates of WGSL the y axis points upwards, as in DirectX.
    let transform = proj::directx::perspective(lens[0], aspect, lens[1], lens[2])
        * view::look_at_mat4(eye, at, Vec3::Z);
    transform.to_cols_array().to_vec()
}

/// A picture of a grid that is drawn with finer pixels, and the pass that draws it.
pub struct Picture {
    canvas: Canvas,
    drawing: HostPass,
    copy: HostBuffer,
    size: [u32; 2],
    finer: u32,
}

impl Picture {
    /// Creates a picture that draws from WGSL, with `finer` times as many pixels in each direction.
    pub fn new(
        host: &mut Host,
        size: [u32; 2],
        finer: u32,
        (wgsl, buffers, texture): (&str, &[vk::Buffer], vk::ImageView),
    ) -> Self {
        let extent = vk::Extent2D { width: finer * size[0], height: finer * size[1] };
        let canvas = host.canvas(extent, FORMAT, DEPTH);
        let drawing = host.draw_pass(wgsl, buffers, texture, &canvas);
        let copy = host.buffer(4 * u64::from(extent.width) * u64::from(extent.height), true);
        Self { canvas, drawing, copy, size, finer }
    }

    /// Records the drawing of two triangles for each cell, and a copy of the picture.
    pub fn record(&self, host: &Host, commands: vk::CommandBuffer, chart: Chart) {
        let cells = (chart.rows - 1) * (chart.cols - 1);
        host.draw(commands, &self.drawing, &self.canvas, 6 * cells as u32, BACKGROUND);
        host.copy_canvas(commands, &self.canvas, &self.copy);
    }

    /// Returns the pixels, row by row: the mean of each square of finer ones.
    pub fn pixels(&self) -> Vec<[u8; 3]> {
        let (fine, finer) = (self.copy.bytes(), self.finer as usize);
        let [width, height] = self.size.map(|side| side as usize);
        let channel = |row: usize, col: usize, channel: usize| {
            let at = |i: usize| (row * finer + i / finer) * finer * width + col * finer + i % finer;
            let sum: usize =
                (0..finer * finer).map(|i| usize::from(fine[4 * at(i) + channel])).sum();
            (sum / (finer * finer)) as u8
        };
        let places = (0..height * width).map(|index| (index / width, index % width));
        places.map(|(row, col)| [0, 1, 2].map(|index| channel(row, col, index))).collect()
    }

    pub fn free(self, host: &mut Host) {
        host.destroy_pass(self.drawing);
        host.free_canvas(self.canvas);
        host.free(self.copy);
    }
}

/// Writes a PNG to the path that the command line names, or to another one.
pub fn write_png(
    default: &str,
    [width, height]: [u32; 2],
    pixels: &[[u8; 3]],
) -> Result<(), Box<dyn Error>> {
    let named = std::env::args().skip(1).find(|argument| !argument.starts_with('-'));
    let path = named.unwrap_or_else(|| default.into());
    let file = std::io::BufWriter::new(std::fs::File::create(&path)?);
    let mut encoder = png::Encoder::new(file, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(pixels.as_flattened())?;
    writer.finish()?;
    println!("wrote {path}");
    Ok(())
}
