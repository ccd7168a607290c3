//! A renderer without a window: one command buffer moves a surface in a compute pass, computes the distances
//! on it, and draws it in colours of the map. The fragment shader draws lines of equal distance. Only the
//! picture is read back.
//!
//! `cargo run --release --features formats --example render -- picture.png`

mod shared;

use std::error::Error;

use geosweep::glam::Vec3;
use geosweep::surface::Chart;
use geosweep::vulkan::embed::{Access, Frame, Points, Reader, SourceInput, SurfaceInfo};

pub(crate) use geosweep::vulkan::embed::PointSource;
pub(crate) use shared::host::Host;
use shared::{Map, Picture};

const CHART: Chart = Chart { rows: 260, cols: 360 };
const SIZE: [u32; 2] = [1600, 900];

/// Moves the surface, one point per invocation.
const MOVE: &str = "
    @group(0) @binding(0) var<storage, read> phase: array<f32>;
    @group(0) @binding(1) var<storage, read_write> points: array<vec4<f32>>;
    @compute @workgroup_size(64)
    fn main(@builtin(global_invocation_id) id: vec3<u32>) {
        if (id.x >= 360u * 260u) { return; }
        let x = f32(id.x % 360u) - 179.5;
        let y = f32(id.x / 360u) - 129.5;
        let r = length(vec3<f32>(x + 30.0, y - 10.0, 18.0));
        let ring = 17.0 * cos(0.062 * r - phase[0]) * exp(-0.00006 * r * r);
        let swell = 9.0 * sin(0.034 * x + 0.5 * phase[0]) * cos(0.041 * y - 0.3);
        points[id.x] = vec4<f32>(x, y, ring + swell, 0.0);
    }";

const DRAW: &str = "
    struct View { transform: mat4x4<f32>, eye: vec4<f32>, light: vec4<f32>, step: vec4<f32> }
    @group(0) @binding(0) var<storage, read> view: View;
    @group(0) @binding(1) var<storage, read> points: array<vec4<f32>>;
    @group(0) @binding(2) var distances: texture_2d<f32>;

    struct Varying {
        @builtin(position) clip: vec4<f32>,
        @location(0) place: vec2<f32>,
        @location(1) position: vec3<f32>,
        @location(2) normal: vec3<f32>,
    }

    fn point(at: vec2<i32>) -> vec3<f32> {
        let inside = clamp(at, vec2<i32>(0), vec2<i32>(359, 259));
        return points[inside.y * 360 + inside.x].xyz;
    }

    @vertex
    fn vertex(@builtin(vertex_index) index: u32) -> Varying {
        var corners = array<vec2<u32>, 6>(vec2<u32>(0u, 0u), vec2<u32>(1u, 0u), vec2<u32>(0u, 1u),
                                          vec2<u32>(0u, 1u), vec2<u32>(1u, 0u), vec2<u32>(1u, 1u));
        let cell = index / 6u;
        let at = vec2<i32>(vec2<u32>(cell % 359u, cell / 359u) + corners[index % 6u]);
        let u = point(at + vec2<i32>(1, 0)) - point(at - vec2<i32>(1, 0));
        let v = point(at + vec2<i32>(0, 1)) - point(at - vec2<i32>(0, 1));
        let position = point(at);
        return Varying(view.transform * vec4<f32>(position, 1.0), vec2<f32>(at), position,
                       normalize(cross(u, v)));
    }

    // The distance, and how it changes along columns and rows: the format need not be filterable,
    // and derivatives of what is loaded are noise where triangles are a few pixels large.
    fn distance_at(place: vec2<f32>) -> vec3<f32> {
        let low = clamp(vec2<i32>(place), vec2<i32>(0), vec2<i32>(358, 258));
        let part = place - vec2<f32>(low);
        let a = textureLoad(distances, low, 0).r;
        let b = textureLoad(distances, low + vec2<i32>(1, 0), 0).r;
        let c = textureLoad(distances, low + vec2<i32>(0, 1), 0).r;
        let d = textureLoad(distances, low + vec2<i32>(1, 1), 0).r;
        return vec3<f32>(mix(mix(a, b, part.x), mix(c, d, part.x), part.y),
                         mix(b - a, d - c, part.y), mix(c - a, d - b, part.x));
    }

    fn colour(t: f32) -> vec3<f32> {
        var stops = array<vec3<f32>, 6>(
            vec3<f32>(1.00, 0.94, 0.76), vec3<f32>(0.99, 0.76, 0.45), vec3<f32>(0.91, 0.46, 0.38),
            vec3<f32>(0.66, 0.28, 0.46), vec3<f32>(0.35, 0.20, 0.47), vec3<f32>(0.12, 0.13, 0.31));
        let x = clamp(t, 0.0, 0.9999) * 5.0;
        let i = u32(x);
        return mix(stops[i], stops[i + 1u], x - f32(i));
    }

    // How much of a pixel a line covers where t is a whole number.
    fn line(t: f32, a_pixel: f32, width: f32) -> f32 {
        let away = abs(fract(t - 0.5) - 0.5) / max(a_pixel, 1e-6);
        return 1.0 - smoothstep(0.5 * width - 0.6, 0.5 * width + 0.6, away);
    }

    @fragment
    fn fragment(in: Varying) -> @location(0) vec4<f32> {
        let found = distance_at(in.place);
        let d = found.x;
        let across = vec2<f32>(dot(found.yz, dpdx(in.place)), dot(found.yz, dpdy(in.place)));
        let a_pixel = length(across);
        let normal = normalize(in.normal);
        let to_eye = normalize(view.eye.xyz - in.position);
        let to_light = normalize(view.light.xyz);
        let facing = dot(normal, to_light);
        let shine = pow(max(dot(normal, normalize(to_light + to_eye)), 0.0), 40.0);
        let base = colour(d / view.step.y);
        let fine = line(d / view.step.x, a_pixel / view.step.x, 2.0);
        let bold = line(d / (5.0 * view.step.x), a_pixel / (5.0 * view.step.x), 4.0);
        let dark = d / view.step.y > 0.55;
        let ink = select(vec3<f32>(0.16, 0.08, 0.16), vec3<f32>(1.0, 0.92, 0.84), dark);
        let inked = mix(base, ink, max(0.42 * fine, 0.85 * bold));
        let shaded = inked * (0.42 + 0.66 * max(facing, 0.0)) + 0.16 * shine;
        let source = 1.0 - smoothstep(2.6, 2.6 + 1.5 * a_pixel, d);
        let rim = 1.0 - smoothstep(3.6, 3.6 + 1.5 * a_pixel, d);
        let marked = mix(mix(shaded, vec3<f32>(1.0), rim), vec3<f32>(0.80, 0.10, 0.14), source);
        return vec4<f32>(marked, 1.0);
    }";

fn main() -> Result<(), Box<dyn Error>> {
    let pixels = render(&mut Host::without_validation(), 2, 1.1, PointSource::at(150.0, 210.0));
    shared::write_png("render.png", SIZE, &pixels)
}

/// Draws the surface in a phase of its motion, with `finer` times as many pixels in each direction. Returns their
/// means, row by row.
pub(crate) fn render(host: &mut Host, finer: u32, phase: f32, source: PointSource) -> Vec<[u8; 3]> {
    let points = host.buffer(16 * CHART.points() as u64, false);
    let phase = host.buffer_of(&[phase]);
    let eye = Vec3::new(-75.0, 320.0, 245.0);
    let mut seen = shared::camera([eye, Vec3::new(-2.0, 16.0, -10.0)], [0.66, 100.0, 900.0], SIZE);
    seen.extend([eye.x, eye.y, eye.z, 0.0, -0.45, 0.05, 0.6, 0.0, 4.0, 285.0, 0.0, 0.0]);
    let seen = host.buffer_of(&seen);

    // Once: the solver, the surface, the plan, and the host's own passes.
    let inputs = [Points::positions(points.handle, 16)];
    let map = Map::new(host, &SurfaceInfo::new(CHART).with_points(&inputs));
    let result = map.surface.result(0, Reader::FRAGMENT.layout).expect("there is a slot");
    let moving = host.pass(MOVE, &[phase.handle, points.handle], None);
    let draw = (DRAW, &[seen.handle, points.handle][..], result.view);
    let picture = Picture::new(host, SIZE, finer, draw);

    // Every frame.
    host.run(|commands| {
        host.dispatch(commands, &moving, shared::groups(CHART.points()));
        let places = [source];
        let frame = Frame::new(&map.plan, SourceInput::Inline(&places), Reader::FRAGMENT)
            .with_before(Access::COMPUTE_WRITE)
            .with_points(0)
            .with_unreached(-1.0);
        map.record(host, commands).frame(&frame).expect("the frame is right");
        host.barrier(commands, Access::COMPUTE_WRITE, Access::VERTEX_READ);
        picture.record(host, commands, CHART);
    });
    map.check();

    let pixels = picture.pixels();
    map.destroy(host);
    host.destroy_pass(moving);
    picture.free(host);
    [points, phase, seen].into_iter().for_each(|buffer| host.free(buffer));
    pixels
}
