// Data that all shaders of the viewer share: the twin of `View` in view.rs.

struct View {
    projection: mat4x4<f32>,
    // The projection that enlarges the pixel under the pointer to the whole picture.
    pick: mat4x4<f32>,
    eye: vec3<f32>,
    // Length of a pixel at the centre of the picture, in units of the world.
    pixel: f32,
    // Half the extents of the surface along x and z.
    half: vec2<f32>,
    // Height of the ground.
    ground: f32,
    // Time of the deformation, in seconds.
    phase: f32,
    grid: vec2<u32>,
    // Distance between lines; negative if the surface's shader does not draw them.
    spacing: f32,
    // Softness of the shadow on the ground.
    softness: f32,
    // Radius of the decal.
    decal: f32,
    // Length that agents walk this frame.
    pace: f32,
    // Directions to the sun, of any length, and to the brightest part of the sky.
    light: vec3<f32>,
    sky: vec3<f32>,
}

@group(0) @binding(0) var<uniform> view: View;

const PAPER = vec3<f32>(0.80, 0.83, 0.86);

// The calm background, from the height in the picture: 0 below, 1 above.
fn background(height: f32) -> vec3<f32> {
    return mix(PAPER * 0.80, PAPER * 1.10, smoothstep(0.0, 1.0, height));
}

// Noise of less than a step of 8 bits, so that gradients show no bands.
fn dither(at: vec2<f32>) -> f32 {
    return (fract(52.9829189 * fract(dot(at, vec2(0.06711056, 0.00583715)))) - 0.5) / 255.0;
}
