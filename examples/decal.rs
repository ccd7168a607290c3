//! A decal and a brush on cloth in motion, placed by log maps of each frame. Every frame one command buffer moves
//! the cloth, strokes a brush over it, and computes the log map of the decal's place. The picture shows the
//! last frame twice: on the left the decal is projected along the cloth's normal, and smears over the folds;
//! on the right its coordinates are those of the log map, and it lies on the cloth as if it were glued there.
//!
//! `cargo run --release --features formats --example decal -- decal.png`

mod shared;

use std::error::Error;

use geosweep::glam::Vec3;
use geosweep::surface::Chart;
use geosweep::vulkan::embed::{
    Access, Frame, LogMapFrame, MapLimit, PointSource, Points, Reader, SourceInput, SurfaceInfo,
};

pub(crate) use shared::host::Host;
use shared::{Map, Picture, groups};

const CHART: Chart = Chart { rows: 120, cols: 160 };
const FRAMES: u32 = 36;
/// Size of each half of the picture.
const SIZE: [u32; 2] = [720, 640];
/// Number of drawn pixels along each side of a pixel of the picture.
const FINER: u32 = 2;
/// Radii of the decal and the brush.
const DECAL: f32 = 34.0;
const BRUSH: f32 = 9.0;
/// Distance beyond these radii up to which maps are solved, since a log map also looks at the points around each of
/// its points. The rest of the cloth costs nothing.
const AROUND: f32 = 4.0;
/// Value of u and v beyond the radius.
const NOWHERE: f32 = 1e6;

/// Moves the cloth, one point per invocation.
const MOVE: &str = "
    @group(0) @binding(0) var<storage, read> time: array<f32>;
    @group(0) @binding(1) var<storage, read_write> points: array<vec4<f32>>;
    @compute @workgroup_size(64)
    fn main(@builtin(global_invocation_id) id: vec3<u32>) {
        if (id.x >= 160u * 120u) { return; }
        let x = f32(id.x % 160u) - 79.5;
        let y = f32(id.x / 160u) - 59.5;
        let t = time[0];
        // Folds hang along y, and move sideways.
        let fold = 11.0 * sin(0.21 * x + 0.05 * y + t) + 4.0 * sin(0.11 * y - 0.6 * t);
        points[id.x] = vec4<f32>(0.72 * x, y, fold * (0.75 + 0.25 * sin(0.03 * y)), 0.0);
    }";

/// Strokes the brush, one texel of the paint per invocation. A cell has 4 x 4 texels. The bristles have fixed places in
/// the brush's log map, so they leave streaks on the cloth.
const STROKE: &str = "
    @group(0) @binding(0) var<storage, read_write> paint: array<f32>;
    @group(0) @binding(1) var log_map: texture_2d<f32>;
    @compute @workgroup_size(64)
    fn main(@builtin(global_invocation_id) id: vec3<u32>) {
        if (id.x >= 640u * 480u) { return; }
        let uv = log_map_at(0.25 * vec2<f32>(vec2<u32>(id.x % 640u, id.x / 640u)));
        let far = length(uv) / 9.0;
        let bristles = 0.55 + 0.45 * sin(2.6 * uv.y) * sin(2.2 * uv.y + 1.0);
        let ink = bristles * (1.0 - smoothstep(0.7, 1.0, far));
        paint[id.x] = max(paint[id.x], ink);
    }";

/// Coordinates of the log map at a column and a row. Four texels are loaded, since not all devices filter them.
const SAMPLE: &str = "
    fn log_map_at(place: vec2<f32>) -> vec2<f32> {
        let low = min(vec2<i32>(place), vec2<i32>(158, 118));
        let part = place - vec2<f32>(low);
        let a = textureLoad(log_map, low, 0).xy;
        let b = textureLoad(log_map, low + vec2<i32>(1, 0), 0).xy;
        let c = textureLoad(log_map, low + vec2<i32>(0, 1), 0).xy;
        let d = textureLoad(log_map, low + vec2<i32>(1, 1), 0).xy;
        return mix(mix(a, b, part.x), mix(c, d, part.x), part.y);
    }";

const DRAW: &str = "
    struct View { transform: mat4x4<f32>, eye: vec4<f32>, light: vec4<f32>, decal: vec4<f32> }
    @group(0) @binding(0) var<storage, read> view: View;
    @group(0) @binding(1) var<storage, read> points: array<vec4<f32>>;
    @group(0) @binding(2) var<storage, read> paint: array<f32>;
    @group(0) @binding(3) var log_map: texture_2d<f32>;

    struct Varying {
        @builtin(position) clip: vec4<f32>,
        @location(0) place: vec2<f32>,
        @location(1) position: vec3<f32>,
        @location(2) normal: vec3<f32>,
    }

    fn point(at: vec2<i32>) -> vec3<f32> {
        let inside = clamp(at, vec2<i32>(0), vec2<i32>(159, 119));
        return points[inside.y * 160 + inside.x].xyz;
    }

    // The directions of columns and rows.
    fn tangents(at: vec2<i32>) -> mat2x3<f32> {
        return mat2x3<f32>(point(at + vec2<i32>(1, 0)) - point(at - vec2<i32>(1, 0)),
                           point(at + vec2<i32>(0, 1)) - point(at - vec2<i32>(0, 1)));
    }

    @vertex
    fn vertex(@builtin(vertex_index) index: u32) -> Varying {
        var corners = array<vec2<u32>, 6>(vec2<u32>(0u, 0u), vec2<u32>(1u, 0u), vec2<u32>(0u, 1u),
                                          vec2<u32>(0u, 1u), vec2<u32>(1u, 0u), vec2<u32>(1u, 1u));
        let cell = index / 6u;
        let at = vec2<i32>(vec2<u32>(cell % 159u, cell / 159u) + corners[index % 6u]);
        let along = tangents(at);
        let position = point(at);
        return Varying(view.transform * vec4<f32>(position, 1.0), vec2<f32>(at), position,
                       normalize(cross(along[0], along[1])));
    }

    // The place in the decal's tangent plane: along its normal, without regard to the cloth between.
    fn projected(position: vec3<f32>) -> vec2<f32> {
        let at = vec2<i32>(view.decal.xy);
        let along = tangents(at);
        let u = normalize(along[0]);
        let v = normalize(along[1] - u * dot(along[1], u));
        let away = position - point(at);
        return vec2<f32>(dot(away, u), dot(away, v));
    }

    // Rings and a grid of squares, which show every distortion. The last number says how much it covers.
    fn decal(uv: vec2<f32>) -> vec4<f32> {
        let far = length(uv) / 32.0;
        let squares = fract(uv / 12.0);
        let dark = (squares.x < 0.5) == (squares.y < 0.5);
        let inside = select(vec3<f32>(0.97, 0.95, 0.90), vec3<f32>(0.16, 0.30, 0.55), dark);
        let rim = select(inside, vec3<f32>(0.82, 0.16, 0.18), far > 0.84);
        return vec4<f32>(rim, 1.0 - smoothstep(0.985, 1.0, far));
    }

    @fragment
    fn fragment(in: Varying) -> @location(0) vec4<f32> {
        let texel = vec2<u32>(4.0 * clamp(in.place, vec2<f32>(0.0), vec2<f32>(159.0, 119.0)));
        let stroke = paint[min(texel.y, 479u) * 640u + min(texel.x, 639u)];
        var colour = mix(vec3<f32>(0.80, 0.77, 0.70), vec3<f32>(0.22, 0.50, 0.33), 0.9 * stroke);
        let uv = select(projected(in.position), log_map_at(in.place), view.decal.z > 0.5);
        let on_it = decal(uv);
        colour = mix(colour, on_it.rgb, on_it.a);
        let normal = normalize(in.normal);
        let facing = abs(dot(normal, normalize(view.light.xyz)));
        return vec4<f32>(colour * (0.38 + 0.68 * facing), 1.0);
    }";

fn main() -> Result<(), Box<dyn Error>> {
    let [left, right] = draw(&mut Host::without_validation(), FRAMES);
    let width = SIZE[0] as usize;
    let rows = left.chunks(width).zip(right.chunks(width));
    let both: Vec<_> = rows.flat_map(|(left, right)| [left, right].concat()).collect();
    shared::write_png("decal.png", [2 * SIZE[0], SIZE[1]], &both)
}

/// Moves the cloth for some frames, and draws the last one with the projected decal and the decal by the log
/// map. Returns the pixels of both, row by row.
pub(crate) fn draw(host: &mut Host, frames: u32) -> [Vec<[u8; 3]>; 2] {
    let device = host.device.clone();
    let mut time = host.buffer_of(&[0.0]);
    let points = host.buffer(16 * CHART.points() as u64, false);
    let paint = host.buffer_of(&vec![0.0; 16 * CHART.points()]);
    let decal = PointSource::at(58.0, 84.0);

    // Once: the solver, the surface, the log map, the plan, and the host's own passes.
    let inputs = [Points::positions(points.handle, 16)];
    let map = Map::new(host, &SurfaceInfo::new(CHART).with_points(&inputs));
    let log_map = map.solver.log_map(&device, host.allocator(), &map.surface);
    let mut log_map = log_map.expect("there is memory");
    let coordinates = log_map.image(Reader::FRAGMENT.layout);
    let moving = host.pass(MOVE, &[time.handle, points.handle], None);
    let stroking = host.pass(&format!("{SAMPLE}{STROKE}"), &[paint.handle], Some(coordinates.view));
    let halves = [0.0, 1.0].map(|by_log_map| {
        let seen = host.buffer_of(&view_of(decal, by_log_map));
        let buffers = [seen.handle, points.handle, paint.handle];
        let draw = (&format!("{SAMPLE}{DRAW}")[..], &buffers[..], coordinates.view);
        (Picture::new(host, SIZE, FINER, draw), seen)
    });

    for frame in 0..frames {
        time.floats_mut()[0] = 0.09 * frame as f32;
        host.run(|commands| {
            host.dispatch(commands, &moving, groups(CHART.points()));
            let recording = map.record(host, commands);
            // The log map of the brush, for the pass that paints.
            let along = frame as f32 / FRAMES as f32;
            let brush = [PointSource::at(99.0 - 12.0 * (5.0 * along).sin(), 18.0 + 122.0 * along)];
            let sources = SourceInput::Inline(&brush);
            let frame_map = Frame::new(&map.plan, sources, Reader::COMPUTE)
                .with_before(Access::COMPUTE_WRITE)
                .with_points(0)
                .with_limit(MapLimit::at(BRUSH + AROUND));
            recording.frame(&frame_map).expect("the frame is right");
            let ways = LogMapFrame::new(sources, Reader::COMPUTE)
                .with_radius(BRUSH)
                .with_unreached(NOWHERE);
            recording.log_map(&log_map, &ways).expect("the frame is right");
            host.dispatch(commands, &stroking, groups(16 * CHART.points()));
            // The log map of the decal, for the fragment shader. The cloth has not moved since.
            let decals = [decal];
            let sources = SourceInput::Inline(&decals);
            let frame_map = frame_map.with_points(None).with_sources(sources);
            recording
                .frame(&frame_map.with_limit(MapLimit::at(DECAL + AROUND)))
                .expect("the frame is right");
            let reader = Reader::sampled(Access::FRAGMENT_READ.and(Access::COMPUTE_READ));
            let ways = ways.with_sources(sources).with_radius(DECAL).with_reader(reader);
            recording.log_map(&log_map, &ways).expect("the frame is right");
            if frame + 1 == frames {
                let read = Access::VERTEX_READ.and(Access::FRAGMENT_READ);
                host.barrier(commands, Access::COMPUTE_WRITE, read);
                halves.iter().for_each(|(picture, _)| picture.record(host, commands, CHART));
            }
        });
        map.check();
    }

    let pixels = halves.each_ref().map(|(picture, _)| picture.pixels());
    log_map.destroy(&device, host.allocator());
    map.destroy(host);
    for (picture, seen) in halves {
        picture.free(host);
        host.free(seen);
    }
    [moving, stroking].into_iter().for_each(|pass| host.destroy_pass(pass));
    [time, points, paint].into_iter().for_each(|buffer| host.free(buffer));
    pixels
}

/// Returns what the drawing passes see: the camera, the light, the decal's place, and how the decal is drawn.
fn view_of(decal: PointSource, by_log_map: f32) -> Vec<f32> {
    let eye = Vec3::new(-58.0, 112.0, 150.0);
    let mut seen = shared::camera([eye, Vec3::new(0.0, 2.0, 0.0)], [0.62, 20.0, 500.0], SIZE);
    seen.extend([eye.x, eye.y, eye.z, 0.0, -0.55, 0.25, 0.6, 0.0]);
    seen.extend([decal.col, decal.row, by_log_map, 0.0]);
    seen
}
