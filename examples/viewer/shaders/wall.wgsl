// Walls from the border of the surface down to the ground.
// Drawn with six vertices for each edge of the border.

@group(0) @binding(1) var<storage, read> positions: array<vec4<f32>>;

struct Fragment {
    @builtin(position) clip: vec4<f32>,
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) below: f32,
}

// The border point with the number `place`, clockwise from the corner of row 0 and column 0.
fn border(place: u32) -> vec2<u32> {
    let last = view.grid - 1u;
    let around = place % (2u * (last.x + last.y));
    if around < last.x {
        return vec2(around, 0u);
    } else if around < last.x + last.y {
        return vec2(last.x, around - last.x);
    } else if around < 2u * last.x + last.y {
        return vec2(2u * last.x + last.y - around, last.y);
    }
    return vec2(0u, 2u * (last.x + last.y) - around);
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Fragment {
    let edge = index / 6u;
    let corner = index % 6u;
    let ahead = u32(corner == 1u || corner == 3u || corner == 4u);
    let down = corner == 2u || corner == 4u || corner == 5u;
    let cell = border(edge + ahead);
    let top = positions[cell.y * view.grid.x + cell.x].xyz;
    let position = select(top, vec3(top.x, view.ground, top.z), down);
    let first = border(edge);
    let second = border(edge + 1u);
    let along = vec2<f32>(second) - vec2<f32>(first);
    let normal = vec3(along.y, 0.0, -along.x);
    return Fragment(view.projection * vec4(position, 1.0), position, normal, top.y - position.y);
}

@fragment
fn fragment(in: Fragment) -> @location(0) vec4<f32> {
    let sun = max(dot(in.normal, normalize(view.light)), 0.0);
    let rise = (in.position.y - view.ground) / max(in.position.y + in.below - view.ground, 1e-6);
    let color = mix(vec3(0.20, 0.215, 0.24), vec3(0.33, 0.345, 0.37), rise);
    return vec4(color * (0.55 + 0.75 * sun) + dither(in.clip.xy), 1.0);
}
