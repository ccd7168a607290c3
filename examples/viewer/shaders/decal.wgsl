// A decal on the surface, around the source. This text is appended to surface.wgsl.

// Row, column, time and curvature.
@group(0) @binding(6) var<storage, read> source: vec4<f32>;
@group(0) @binding(9) var log_map: texture_2d<f32>;

const TAU = 6.2831853;

// Rings and sectors within radius 1, which show every distortion. The last number is their opacity.
fn decal(at: vec2<f32>) -> vec4<f32> {
    let far = length(at);
    let waves = sin(TAU * 3.0 * far) * sin(12.0 * atan2(at.y, at.x));
    let dark = smoothstep(-0.12, 0.12, waves);
    let board = mix(vec3(0.86, 0.80, 0.70), vec3(0.45, 0.01, 0.22), dark);
    let color = mix(board, vec3(0.45, 0.01, 0.22), smoothstep(0.90, 0.92, far));
    return vec4(color, 1.0 - smoothstep(0.985, 1.0, far));
}

fn with_decal(in: Fragment, front: bool, at: vec2<f32>) -> vec4<f32> {
    let distance = distance_at(in.cell);
    let on_it = decal(at / view.decal);
    return shown(in, front, distance, mix(painted(distance), on_it.rgb, on_it.a));
}

// The log map gives every point of the surface its place in the decal.
@fragment
fn log_map_fragment(in: Fragment, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    return with_decal(in, front, between(around(log_map, in.cell)));
}

// The decal is projected from above, without regard to the shape of the surface.
@fragment
fn projected_fragment(in: Fragment, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    return with_decal(in, front, (in.position - point_at(source.yx)).xz);
}
