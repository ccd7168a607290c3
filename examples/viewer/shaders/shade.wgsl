// Normals, and how much of the sky a point sees.
// Dispatched with one thread a grid point.

@group(0) @binding(1) var<storage, read> positions: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> shading: array<vec4<f32>>;

const DIRECTIONS = 8;
const STEPS = 7;

fn at(cell: vec2<i32>) -> vec3<f32> {
    let inside = clamp(cell, vec2(0), vec2<i32>(view.grid) - 1);
    return positions[inside.y * i32(view.grid.x) + inside.x].xyz;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= view.grid.x * view.grid.y {
        return;
    }
    let cell = vec2<i32>(i32(id.x % view.grid.x), i32(id.x / view.grid.x));
    let east = at(cell + vec2(1, 0)) - at(cell - vec2(1, 0));
    let south = at(cell + vec2(0, 1)) - at(cell - vec2(0, 1));
    let normal = normalize(cross(south, east));

    let here = positions[id.x].xyz;
    var open = 0.0;
    for (var direction = 0; direction < DIRECTIONS; direction++) {
        let angle = 6.2831853 * (f32(direction) + 0.5) / f32(DIRECTIONS);
        var horizon = 0.0;
        var reach = 1.5;
        for (var step = 0; step < STEPS; step++) {
            let to = at(cell + vec2<i32>(round(reach * vec2(cos(angle), sin(angle))))) - here;
            let away = max(length(to.xz), 1e-6);
            horizon = max(horizon, to.y / away);
            reach *= 1.6;
        }
        // The part of a vertical arc above the horizon, weighted by the cosine.
        open += 1.0 - horizon * inverseSqrt(1.0 + horizon * horizon);
    }
    shading[id.x] = vec4(normal, open / f32(DIRECTIONS));
}
