// Surroundings of the surface: a background without a horizon, and a soft shadow on the ground.

@group(0) @binding(1) var<storage, read> positions: array<vec4<f32>>;

struct Back {
    @builtin(position) clip: vec4<f32>,
    @location(0) height: f32,
}

// One triangle over the whole picture.
@vertex
fn back_vertex(@builtin(vertex_index) index: u32) -> Back {
    let at = vec2(f32(index & 1u), f32(index >> 1u)) * 4.0 - 1.0;
    return Back(vec4(at, 1.0, 1.0), 0.5 + 0.5 * at.y);
}

@fragment
fn back_fragment(in: Back) -> @location(0) vec4<f32> {
    return vec4(background(in.height) + dither(in.clip.xy), 1.0);
}

struct Shadow {
    @builtin(position) clip: vec4<f32>,
    @location(0) at: vec2<f32>,
}

@vertex
fn shadow_vertex(@builtin(vertex_index) index: u32) -> Shadow {
    let corner = vec2(f32(index & 1u), f32(index >> 1u)) * 2.0 - 1.0;
    let at = corner * (view.half + 3.0 * view.softness);
    return Shadow(view.projection * vec4(at.x, view.ground, at.y, 1.0), at);
}

// A box in one dimension, blurred by a kernel close to a Gaussian.
fn edge(at: f32, half: f32) -> f32 {
    let scale = 1.7 / view.softness;
    return 0.5 * (tanh(scale * (at + half)) - tanh(scale * (at - half)));
}

@fragment
fn shadow_fragment(in: Shadow) -> @location(0) vec4<f32> {
    // The shadow is shifted away from the light.
    let at = in.at + 0.35 * view.softness * normalize(view.light).xz;
    let shadow = edge(at.x, view.half.x) * edge(at.y, view.half.y);
    return vec4(0.05, 0.07, 0.11, 0.62 * shadow);
}
