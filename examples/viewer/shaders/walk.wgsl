// Moves agents along their ways, by `view.pace` on the surface. An agent at the source starts again far away.
// Dispatched with one thread an agent.

@group(0) @binding(1) var<storage, read> positions: array<vec4<f32>>;
@group(0) @binding(5) var distances: texture_2d<f32>;
// Row, column, time and curvature.
@group(0) @binding(6) var<storage, read> source: vec4<f32>;
// Column, row, and the number of starts so far.
@group(0) @binding(7) var<storage, read_write> agents: array<vec3<f32>>;
@group(0) @binding(8) var directions: texture_2d<f32>;

const STEPS = 8;
// Distance from the source, in cells, within which an agent has arrived.
const ARRIVED = 1.5;
// Number of random places, of which an agent takes the farthest as its start.
const PLACES = 3u;

fn apart(a: vec2<i32>, b: vec2<i32>) -> f32 {
    let cols = i32(view.grid.x);
    return distance(positions[a.y * cols + a.x].xyz, positions[b.y * cols + b.x].xyz);
}

// A number from 0 to 1 (PCG hash).
fn hash(seed: u32) -> f32 {
    let state = seed * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return f32(((word >> 22u) ^ word) >> 8u) / 16777216.0;
}

fn start(index: u32, starts: u32) -> vec2<f32> {
    var best = vec2(0.0);
    var farthest = -2.0;
    for (var i = 0u; i < PLACES; i++) {
        let seed = 2u * (PLACES * (starts * arrayLength(&agents) + index) + i);
        let place = vec2(hash(seed), hash(seed + 1u)) * (vec2<f32>(view.grid) - 1.0);
        let far = textureLoad(distances, vec2<i32>(round(place)), 0).x;
        if far > farthest {
            farthest = far;
            best = place;
        }
    }
    return best;
}

// The agent at the place where it begins this frame.
fn begun(index: u32) -> vec3<f32> {
    let agent = agents[index];
    if agent.z > 0.0 && distance(agent.xy, source.yx) > ARRIVED {
        return agent;
    }
    return vec3(start(index, u32(agent.z)), agent.z + 1.0);
}

// One step along a way, at most half a cell.
fn stepped(place: vec2<f32>, way: vec2<f32>) -> vec2<f32> {
    let ahead = clamp(place + 0.5 * way, vec2(0.0), vec2<f32>(view.grid) - 1.0);
    let away = distance(point_at(place), point_at(ahead));
    return mix(place, ahead, min(view.pace / f32(STEPS) / max(away, 1e-6), 1.0));
}

@compute @workgroup_size(64)
fn by_directions(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&agents) {
        return;
    }
    let agent = begun(id.x);
    var place = agent.xy;
    for (var step = 0; step < STEPS; step++) {
        place = stepped(place, along_directions(directions, place));
    }
    agents[id.x] = vec3(place, agent.z);
}

@compute @workgroup_size(64)
fn to_neighbours(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&agents) {
        return;
    }
    let agent = begun(id.x);
    var place = agent.xy;
    for (var step = 0; step < STEPS; step++) {
        place = stepped(place, to_neighbour(distances, place));
    }
    agents[id.x] = vec3(place, agent.z);
}
