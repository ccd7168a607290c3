//! Ten thousand agents walk to a tower over terrain that is cratered while they walk. Every frame one command
//! buffer makes the terrain, computes the distances to the tower and the directions of all ways back, and
//! moves the agents along them. Nothing is read back but the picture of their trails, and two sums: how many
//! agents have arrived, and how far all have walked.
//!
//! `cargo run --release --features formats --example horde -- horde.png`
//!
//! With `--links` agents walk to one of eight neighbours instead, as agents on grids usually do. Their trails
//! keep to eight directions, and are longer.

mod shared;

use std::error::Error;

use geosweep::Spacing;
use geosweep::surface::Chart;
use geosweep::vulkan::embed::{
    Access, DirectionFrame, Frame, PointKind, PointSource, Points, Reader, SourceInput, SurfaceInfo,
};

pub(crate) use shared::host::Host;
use shared::{Map, groups};

const SIDE: usize = 192;
const AGENTS: u32 = 10_000;
const FRAMES: u32 = 110;
/// Number of pixels along each side of a cell.
const FINE: usize = 4;
const WIDTH: usize = FINE * (SIDE - 1);
const TOWER: [f32; 2] = [96.0, 176.0];

/// Constants and a function that the passes share. A crater opens every 15 to 20 frames, across the agents' way.
const SHARED: &str = "
    const SIDE = 192u;
    const WIDTH = 764u;
    const AGENTS = 10000u;
    const TOWER = vec2<f32>(176.0, 96.0);
    fn height(at: vec2<f32>, frame: f32) -> f32 {
        var craters = array<vec3<f32>, 4>(vec3<f32>(80.0, 96.0, 10.0), vec3<f32>(112.0, 60.0, 30.0),
                                          vec3<f32>(118.0, 118.0, 50.0), vec3<f32>(146.0, 88.0, 65.0));
        var z = 5.0 * sin(0.05 * at.x + 1.0) * cos(0.06 * at.y) + 2.0 * sin(0.11 * at.y - 0.07 * at.x);
        for (var i = 0; i < 4; i++) {
            let far = distance(at, craters[i].xy) / 15.0;
            let rim = 10.0 * exp(-12.0 * (far - 1.0) * (far - 1.0));
            let bowl = 26.0 * (1.0 - smoothstep(0.3, 1.0, far));
            z += select(0.0, rim - bowl, frame >= craters[i].z);
        }
        return z;
    }";

/// Makes the terrain, one grid point per invocation.
const TERRAIN: &str = "
    @group(0) @binding(0) var<storage, read> frame: array<f32>;
    @group(0) @binding(1) var<storage, read_write> heights: array<f32>;
    @compute @workgroup_size(64)
    fn main(@builtin(global_invocation_id) id: vec3<u32>) {
        if (id.x >= SIDE * SIDE) { return; }
        heights[id.x] = height(vec2<f32>(vec2<u32>(id.x % SIDE, id.x / SIDE)), frame[0]);
    }";

/// Moves the agents, one per invocation. `heading` is one of the functions below.
const WALK: &str = "
    @group(0) @binding(0) var<storage, read> frame: array<f32>;
    @group(0) @binding(1) var<storage, read_write> agents: array<vec2<f32>>;
    @group(0) @binding(2) var<storage, read_write> trails: array<atomic<u32>>;
    @group(0) @binding(3) var field: texture_2d<f32>;
    fn start(agent: u32) -> vec2<f32> {
        let a = fract(f32(agent) * 0.75487767);
        let b = fract(f32(agent) * 0.56984029);
        return vec2<f32>(4.0 + 14.0 * a, 12.0 + 168.0 * b);
    }
    @compute @workgroup_size(64)
    fn main(@builtin(global_invocation_id) id: vec3<u32>) {
        if (id.x >= AGENTS) { return; }
        var place = agents[id.x];
        if (frame[0] == 0.0) { place = start(id.x); }
        // Two sums follow the pixels: the agents at the tower, and 16ths of cells walked.
        for (var step = 0; step < 8 && distance(place, TOWER) > 2.0; step++) {
            let next = clamp(place + 0.25 * heading(place), vec2<f32>(0.0), vec2<f32>(f32(SIDE - 1u)));
            let way = vec3<f32>(next - place, height(next, frame[0]) - height(place, frame[0]));
            atomicAdd(&trails[WIDTH * WIDTH + 1u], u32(16.0 * length(way) + 0.5));
            place = next;
            let pixel = min(vec2<u32>(4.0 * place), vec2<u32>(WIDTH - 1u));
            atomicAdd(&trails[pixel.y * WIDTH + pixel.x], 1u);
            if (distance(place, TOWER) <= 2.0) { atomicAdd(&trails[WIDTH * WIDTH], 1u); }
        }
        agents[id.x] = place;
    }";

/// Functions that choose the direction of a step, from the example `viewer`.
const WAYS: &str = concat!(
    include_str!("viewer/shaders/bilinear.wgsl"),
    include_str!("viewer/shaders/ways.wgsl"),
    "fn apart(a: vec2<i32>, b: vec2<i32>) -> f32 { return distance(vec2<f32>(a), vec2<f32>(b)); }"
);
const ALONG_DIRECTIONS: &str =
    "fn heading(place: vec2<f32>) -> vec2<f32> { return along_directions(field, place); }";
const ALONG_LINKS: &str =
    "fn heading(place: vec2<f32>) -> vec2<f32> { return to_neighbour(field, place); }";

/// Paints shaded terrain, and the trails over it, one pixel per invocation.
const PAINT: &str = "
    @group(0) @binding(0) var<storage, read> frame: array<f32>;
    @group(0) @binding(1) var<storage, read> agents: array<vec2<f32>>;
    @group(0) @binding(2) var<storage, read_write> trails: array<u32>;
    @compute @workgroup_size(64)
    fn main(@builtin(global_invocation_id) id: vec3<u32>) {
        if (id.x >= WIDTH * WIDTH) { return; }
        let at = 0.25 * (vec2<f32>(vec2<u32>(id.x % WIDTH, id.x / WIDTH)) + 0.5);
        let z = height(at, frame[0]);
        let slope = vec2<f32>(height(at + vec2<f32>(0.5, 0.0), frame[0]) - height(at - vec2<f32>(0.5, 0.0), frame[0]),
                              height(at + vec2<f32>(0.0, 0.5), frame[0]) - height(at - vec2<f32>(0.0, 0.5), frame[0]));
        let light = dot(normalize(vec3<f32>(-slope, 1.0)), normalize(vec3<f32>(-0.6, -0.7, 0.9)));
        let ground = mix(vec3<f32>(0.36, 0.33, 0.28), vec3<f32>(0.72, 0.71, 0.58), clamp(0.5 + 0.04 * z, 0.0, 1.0));
        var colour = ground * (0.35 + 0.75 * max(light, 0.0));
        let trail = 1.0 - exp(-0.12 * f32(trails[id.x]));
        colour = mix(colour, mix(vec3<f32>(0.15, 0.35, 0.75), vec3<f32>(0.95, 0.97, 1.0), trail * trail), 0.85 * trail);
        colour = select(colour, vec3<f32>(0.80, 0.10, 0.14), distance(at, TOWER) < 2.5);
        trails[id.x] = pack4x8unorm(vec4<f32>(colour, 1.0));
    }";

/// Result of a march.
pub(crate) struct March {
    /// Pixels, row by row.
    pub pixels: Vec<[u8; 3]>,
    /// Number of agents that have arrived.
    pub arrived: u32,
    /// Mean length of all agents' ways over the terrain, in cells.
    pub walked: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let links = std::env::args().any(|argument| argument == "--links");
    let March { pixels, arrived, walked } = march(&mut Host::without_validation(), links, FRAMES);
    println!("{arrived} of {AGENTS} agents have arrived, on ways of {walked:.1} cells");
    shared::write_png("horde.png", [WIDTH as u32; 2], &pixels)
}

/// Lets the agents walk for some frames, along directions or along links from point to point.
pub(crate) fn march(host: &mut Host, links: bool, frames: u32) -> March {
    let device = host.device.clone();
    let chart = Chart { rows: SIDE, cols: SIDE };
    let mut time = host.buffer_of(&[0.0]);
    let heights = host.buffer(4 * chart.points() as u64, false);
    let agents = host.buffer(8 * u64::from(AGENTS), false);
    let trails = host.buffer_of(&vec![0.0; WIDTH * WIDTH + 2]);

    // Once: the solver, the surface, the directions, and the host's own passes.
    let kind = PointKind::Heights(Spacing::square(1.0));
    let inputs = [Points { kind, ..Points::positions(heights.handle, 4) }];
    let map = Map::new(host, &SurfaceInfo::new(chart).with_points(&inputs));
    let directions = map.solver.directions(&device, host.allocator(), &map.surface);
    let mut directions = directions.expect("there is memory");
    let pass = |text: &str, buffers: &[_], texture| {
        host.pass(&format!("{SHARED}{text}"), buffers, texture)
    };
    let terrain = pass(TERRAIN, &[time.handle, heights.handle], None);
    let (heading, field) = match links {
        true => {
            (ALONG_LINKS, map.surface.result(0, Reader::COMPUTE.layout).expect("there is a slot"))
        }
        false => (ALONG_DIRECTIONS, directions.image(Reader::COMPUTE.layout)),
    };
    let buffers = [time.handle, agents.handle, trails.handle];
    let walk = pass(&format!("{WAYS}{heading}{WALK}"), &buffers, Some(field.view));
    let paint = pass(PAINT, &buffers, None);

    for frame in 0..frames {
        time.floats_mut()[0] = frame as f32;
        host.run(|commands| {
            host.dispatch(commands, &terrain, groups(chart.points()));
            let tower = [PointSource::at(TOWER[0], TOWER[1])];
            let sources = SourceInput::Inline(&tower);
            let recording = map.record(host, commands);
            let frame = Frame::new(&map.plan, sources, Reader::COMPUTE)
                .with_before(Access::COMPUTE_WRITE)
                .with_points(0);
            recording.frame(&frame).expect("the frame is right");
            let ways = DirectionFrame::new(sources, Reader::COMPUTE);
            recording.directions(&directions, &ways).expect("the frame is right");
            host.dispatch(commands, &walk, groups(AGENTS as usize));
        });
        map.check();
    }
    host.run(|commands| {
        host.dispatch(commands, &paint, groups(WIDTH * WIDTH));
        host.barrier(commands, Access::COMPUTE_WRITE, Access::HOST_READ);
    });

    let bytes = trails.bytes();
    let sum = |number: usize| {
        let at = 4 * (WIDTH * WIDTH + number);
        u32::from_ne_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
    };
    let march = March {
        pixels: bytes[..4 * WIDTH * WIDTH].chunks(4).map(|p| [p[0], p[1], p[2]]).collect(),
        arrived: sum(0),
        walked: f64::from(sum(1)) / 16.0 / f64::from(AGENTS),
    };
    directions.destroy(&device, host.allocator());
    map.destroy(host);
    [terrain, walk, paint].into_iter().for_each(|pass| host.destroy_pass(pass));
    [time, heights, agents, trails].into_iter().for_each(|buffer| host.free(buffer));
    march
}
