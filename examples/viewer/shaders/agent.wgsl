// Agents as discs that face the eye.
// Drawn with an instance for each agent and four vertices for each instance.

@group(0) @binding(1) var<storage, read> positions: array<vec4<f32>>;
// Column, row, and the number of starts so far.
@group(0) @binding(7) var<storage, read> agents: array<vec3<f32>>;

// Radius in pixels at the centre of the picture.
const RADIUS = 2.4;

struct Fragment {
    @builtin(position) clip: vec4<f32>,
    // The place in the disc, whose radius is 1.
    @location(0) at: vec2<f32>,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) agent: u32) -> Fragment {
    let corner = vec2(f32(index & 1u), f32(index >> 1u)) * 2.0 - 1.0;
    // A little of the way toward the eye, so that the agent lies above the surface.
    let middle = mix(point_at(agents[agent].xy), view.eye, 0.004);
    let toward_eye = normalize(view.eye - middle);
    let right = normalize(cross(vec3(0.0, 1.0, 0.0), toward_eye));
    let up = cross(toward_eye, right);
    let away = RADIUS * view.pixel * (corner.x * right + corner.y * up);
    return Fragment(view.projection * vec4(middle + away, 1.0), corner);
}

@fragment
fn fragment(in: Fragment) -> @location(0) vec4<f32> {
    let far = length(in.at);
    if far > 1.0 {
        discard;
    }
    let color = mix(vec3(0.90, 0.13, 0.02), vec3(0.16, 0.02, 0.01), smoothstep(0.55, 0.85, far));
    return vec4(color, 1.0 - smoothstep(0.85, 1.0, far));
}
