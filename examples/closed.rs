//! A closed tube that moves, without a window. The last column of the tube's grid is its first one again, and the lines
//! of equal distance go on across this seam. One command buffer moves the tube, computes the distances over the
//! seam, and draws the tube. The seam faces the eye.
//!
//! `cargo run --release --features formats --example closed -- picture.png`

mod shared;

use std::error::Error;

use geosweep::glam::Vec3;
use geosweep::surface::{Chart, Gluing};
use geosweep::vulkan::embed::{Access, Frame, Points, Reader, SourceInput, SurfaceInfo};

pub(crate) use geosweep::vulkan::embed::PointSource;
pub(crate) use shared::host::Host;
use shared::{Map, Picture};

const CHART: Chart = Chart { rows: 241, cols: 161 };
const SIZE: [u32; 2] = [1200, 700];

/// Moves the tube, one point per invocation. The last column has the points of the first.
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
    // The source is beside the seam.
    let pixels = draw(&mut Host::without_validation(), 0.8, PointSource::at(95.0, 12.0));
    shared::write_png("closed.png", SIZE, &pixels)
}

/// Draws the tube at a time of its motion. Returns pixels, row by row.
pub(crate) fn draw(host: &mut Host, time: f32, source: PointSource) -> Vec<[u8; 3]> {
    let points = host.buffer(16 * CHART.points() as u64, false);
    let time = host.buffer_of(&[time]);
    let eye = Vec3::new(60.0, -300.0, 120.0);
    let mut seen = shared::camera([eye, Vec3::ZERO], [0.6, 100.0, 900.0], SIZE);
    seen.extend([-0.3, -0.7, 0.6, 0.0]);
    let seen = host.buffer_of(&seen);

    // Once: the solver, the glued surface, a plan over its seam, and the host's own passes.
    let (inputs, gluing) = ([Points::positions(points.handle, 16)], Gluing::columns());
    let map = Map::new(host, &SurfaceInfo::new(CHART).with_points(&inputs).with_gluing(&gluing));
    let result = map.surface.result(0, Reader::FRAGMENT.layout).expect("there is a slot");
    let moving = host.pass(MOVE, &[time.handle, points.handle], None);
    let draw = (DRAW, &[seen.handle, points.handle][..], result.view);
    let picture = Picture::new(host, SIZE, 1, draw);

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
    [points, time, seen].into_iter().for_each(|buffer| host.free(buffer));
    pixels
}
