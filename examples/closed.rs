//! A closed tube that moves, without a window. The last column of the tube's grid is its first one again, and the lines
//! of equal distance go on across this seam. One command buffer moves the tube, computes the distances over the
//! seam, and draws the tube. The seam faces the eye.
//!
//! `cargo run --release --features formats --example closed -- picture.png`

#[path = "../tests/common/host/mod.rs"]
mod host;

use std::error::Error;

use geosweep::ash::vk;
use geosweep::glam::Vec3;
use geosweep::glam::camera::rh::{proj, view};
use geosweep::surface::{Chart, Gluing};
use geosweep::vulkan::embed::{self, Access, Frame, Points, Reader, SourceInput, SurfaceInfo};
use geosweep::vulkan::{Method, Schedule};
use geosweep::{Stop, Wavefront};

pub(crate) use geosweep::vulkan::embed::PointSource;
pub(crate) use host::Host;

const CHART: Chart = Chart { rows: 241, cols: 161 };
pub(crate) const WIDTH: u32 = 1200;
pub(crate) const HEIGHT: u32 = 700;
const PICTURE: vk::Format = vk::Format::R8G8B8A8_UNORM;
const DEPTH: vk::Format = vk::Format::D16_UNORM;

/// One invocation is one point. The last column has the points of the first.
const MOVE: &str = "
    @group(0) @binding(0) var<storage, read> time: array<f32>;
    @group(0) @binding(1) var<storage, read_write> points: array<vec4<f32>>;
    @compute @workgroup_size(64)
    fn main(@builtin(global_invocation_id) id: vec3<u32>) {
        if (id.x >= 161u * 241u) { return; }
        let angle = 6.2831853 * f32((id.x % 161u) % 160u) / 160.0;
        let along = f32(id.x / 161u) - 120.0;
        let radius = 38.0 * (1.0 + 0.22 * sin(0.045 * along + time[0]) + 0.10 * cos(3.0 * angle + 0.03 * along));
        let centre = vec2<f32>(14.0 * sin(0.02 * along + time[0]), 10.0 * cos(0.027 * along - time[0]));
        points[id.x] = vec4<f32>(along, centre + radius * vec2<f32>(-cos(angle), sin(angle)), 0.0);
    }";

const DRAW: &str = "
    struct View { transform: mat4x4<f32>, light: vec4<f32> }
    @group(0) @binding(0) var<storage, read> view: View;
    @group(0) @binding(1) var<storage, read> points: array<vec4<f32>>;
    @group(0) @binding(2) var distances: texture_2d<f32>;

    struct Varying {
        @builtin(position) clip: vec4<f32>,
        @location(0) place: vec2<f32>,
        @location(1) normal: vec3<f32>,
    }

    // Columns go on beyond the seam.
    fn point(at: vec2<i32>) -> vec3<f32> {
        return points[clamp(at.y, 0, 240) * 161 + (at.x + 160) % 160].xyz;
    }

    @vertex
    fn vertex(@builtin(vertex_index) index: u32) -> Varying {
        var corners = array<vec2<u32>, 6>(vec2<u32>(0u, 0u), vec2<u32>(1u, 0u), vec2<u32>(0u, 1u),
                                          vec2<u32>(0u, 1u), vec2<u32>(1u, 0u), vec2<u32>(1u, 1u));
        let cell = index / 6u;
        let at = vec2<i32>(vec2<u32>(cell % 160u, cell / 160u) + corners[index % 6u]);
        let u = point(at + vec2<i32>(1, 0)) - point(at - vec2<i32>(1, 0));
        let v = point(at + vec2<i32>(0, 1)) - point(at - vec2<i32>(0, 1));
        return Varying(view.transform * vec4<f32>(point(at), 1.0), vec2<f32>(at), normalize(cross(v, u)));
    }

    fn load(at: vec2<i32>) -> f32 {
        return textureLoad(distances, at, 0).r;
    }

    // The distance, and how it changes along columns and rows.
    fn distance_at(place: vec2<f32>) -> vec3<f32> {
        let low = clamp(vec2<i32>(place), vec2<i32>(0), vec2<i32>(159, 239));
        let part = place - vec2<f32>(low);
        let north = vec2<f32>(load(low), load(low + vec2<i32>(1, 0)));
        let south = vec2<f32>(load(low + vec2<i32>(0, 1)), load(low + vec2<i32>(1, 1)));
        let row = mix(north, south, part.y);
        let down = south - north;
        return vec3<f32>(mix(row.x, row.y, part.x), row.y - row.x, mix(down.x, down.y, part.x));
    }

    @fragment
    fn fragment(in: Varying) -> @location(0) vec4<f32> {
        let found = distance_at(in.place);
        let a_pixel = length(vec2<f32>(dot(found.yz, dpdx(in.place)), dot(found.yz, dpdy(in.place))));
        let away = 10.0 * abs(fract(found.x / 10.0 - 0.5) - 0.5);
        let line = 1.0 - smoothstep(0.7 * a_pixel, 1.7 * a_pixel, away);
        let shade = 0.45 + 0.55 * max(dot(normalize(in.normal), normalize(view.light.xyz)), 0.0);
        let near = exp(-0.008 * found.x);
        let base = mix(vec3<f32>(0.24, 0.30, 0.47), vec3<f32>(0.99, 0.83, 0.55), near) * shade;
        let source = 1.0 - smoothstep(3.0, 3.0 + 1.5 * a_pixel, found.x);
        let inked = mix(base, vec3<f32>(0.10, 0.07, 0.14), 0.75 * line);
        return vec4<f32>(mix(inked, vec3<f32>(0.80, 0.10, 0.14), source), 1.0);
    }";

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).unwrap_or_else(|| "closed.png".into());
    // The source is beside the seam.
    let pixels = draw(&mut Host::without_validation(), 0.8, PointSource::at(95.0, 12.0));
    let file = std::io::BufWriter::new(std::fs::File::create(&path)?);
    let mut encoder = png::Encoder::new(file, WIDTH, HEIGHT);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&pixels)?;
    writer.finish()?;
    println!("wrote {path}");
    Ok(())
}

/// Draws the tube at a time of its motion. Returns the bytes of an RGBA picture.
pub(crate) fn draw(host: &mut Host, time: f32, source: PointSource) -> Vec<u8> {
    let device = host.device.clone();
    let points = host.buffer(16 * CHART.points() as u64, false);
    let time = host.buffer_of(&[time]);
    // In clip coordinates of WGSL the y axis points upwards, as in DirectX.
    let transform = proj::directx::perspective(0.6, WIDTH as f32 / HEIGHT as f32, 100.0, 900.0)
        * view::look_at_mat4(Vec3::new(60.0, -300.0, 120.0), Vec3::ZERO, Vec3::Z);
    let mut seen = transform.to_cols_array().to_vec();
    seen.extend([-0.3, -0.7, 0.6, 0.0]);
    let seen = host.buffer_of(&seen);

    // Once: the solver, the glued surface, a plan over its seam, and the host's own passes.
    let passes = [(Schedule::Raster, Wavefront::Curved)];
    let solver = embed::Solver::new(&host.instance, host.physical_device, &device, &passes);
    let mut solver = solver.expect("the device meets the requirements");
    let (inputs, gluing) = ([Points::positions(points.handle, 16)], Gluing::columns());
    let info = SurfaceInfo::new(CHART).with_points(&inputs).with_gluing(&gluing);
    let surface = solver.surface(&device, host.allocator(), &info);
    let mut surface = surface.expect("there is memory");
    let method = Method::new(Wavefront::Curved, Stop::within(1e-4).or_after(100));
    let plan = solver.plan(CHART, method, 12).expect("the passes are there").over_seams();
    host.run(|commands| solver.record(&device, commands, &surface).prepare());
    let result = surface.result(0, Reader::FRAGMENT.layout).expect("there is a slot");
    let moving = host.pass(MOVE, &[time.handle, points.handle], None);
    let size = vk::Extent2D { width: WIDTH, height: HEIGHT };
    let canvas = host.canvas(size, PICTURE, DEPTH);
    let drawing = host.draw_pass(DRAW, &[seen.handle, points.handle], result.view, &canvas);
    let picture = host.buffer(4 * u64::from(WIDTH) * u64::from(HEIGHT), true);

    // Every frame.
    host.run(|commands| {
        host.dispatch(commands, &moving, CHART.points().div_ceil(64) as u32);
        let places = [source];
        let frame = Frame::new(&plan, SourceInput::Inline(&places), Reader::FRAGMENT)
            .with_before(Access::COMPUTE_WRITE)
            .with_points(0)
            .with_unreached(-1.0);
        let recording = solver.record(&device, commands, &surface);
        recording.frame(&frame).expect("the frame is right");
        host.barrier(commands, Access::COMPUTE_WRITE, Access::VERTEX_READ);
        let cells = (CHART.rows - 1) * (CHART.cols - 1);
        host.draw(commands, &drawing, &canvas, 6 * cells as u32, [0.93, 0.92, 0.90, 1.0]);
        host.copy_canvas(commands, &canvas, &picture);
    });
    let outcome = surface.outcome(0).expect("there is a slot");
    assert!(outcome.converged, "{outcome:?}");

    let pixels = picture.bytes().to_vec();
    surface.destroy(&device, host.allocator());
    solver.destroy(&device);
    host.destroy_pass(moving);
    host.destroy_pass(drawing);
    host.free_canvas(canvas);
    [points, time, seen, picture].into_iter().for_each(|buffer| host.free(buffer));
    pixels
}
