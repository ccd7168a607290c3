// Moves the points of the sheet: waves that cross, and a hill and a dent that wander.
// Dispatched with one thread a grid point.

@group(0) @binding(1) var<storage, read_write> positions: array<vec4<f32>>;

fn height(at: vec2<f32>, phase: f32) -> f32 {
    let centre = 4.6 * vec2(cos(0.6 * phase), sin(0.6 * phase));
    let away = at - centre;
    let hill = 4.2 * exp(-dot(away, away) / 5.0);
    let other = at + 1.15 * centre.yx;
    let dent = -2.0 * exp(-dot(other, other) / 7.0);
    let waves = 0.42 * sin(0.75 * at.x + 1.4 * phase) * cos(0.55 * at.y - phase)
        + 0.30 * sin(0.5 * (at.x + at.y) - 1.7 * phase);
    return hill + dent + waves;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let cols = view.grid.x;
    let rows = view.grid.y;
    if id.x >= cols * rows {
        return;
    }
    let cell = vec2<f32>(f32(id.x % cols), f32(id.x / cols));
    let at = view.half * (2.0 * cell / (vec2<f32>(view.grid) - 1.0) - 1.0);
    positions[id.x] = vec4(at.x, height(at, view.phase), at.y, 1.0);
}
