// Values of an image between grid points. Each grid point has a texel.
// The interpolation is written out, since devices need not filter 32-bit floats.

struct Around {
    // Texels above left, above right, below left and below right.
    a: vec2<f32>,
    b: vec2<f32>,
    c: vec2<f32>,
    d: vec2<f32>,
    // The place between them, from 0 to 1.
    part: vec2<f32>,
}

// The texels around a column and a row.
fn around(image: texture_2d<f32>, cell: vec2<f32>) -> Around {
    let last = vec2<i32>(textureDimensions(image)) - 1;
    let low = clamp(vec2<i32>(floor(cell)), vec2<i32>(0), last - 1);
    let a = textureLoad(image, low, 0).xy;
    let b = textureLoad(image, low + vec2<i32>(1, 0), 0).xy;
    let c = textureLoad(image, low + vec2<i32>(0, 1), 0).xy;
    let d = textureLoad(image, low + vec2<i32>(1, 1), 0).xy;
    return Around(a, b, c, d, cell - vec2<f32>(low));
}

fn between(texels: Around) -> vec2<f32> {
    let above = mix(texels.a, texels.b, texels.part.x);
    let below = mix(texels.c, texels.d, texels.part.x);
    return mix(above, below, texels.part.y);
}

// The distance at a place between grid points. Points that are not reached hold a negative number and are left out,
// since a pixel at the border of a hole may lie in the hole by rounding. The result is negative where the points that
// are left out have at least half of the weight.
fn reached_between(texels: Around) -> f32 {
    let values = vec4(texels.a.x, texels.b.x, texels.c.x, texels.d.x);
    if all(values >= vec4(0.0)) {
        return between(texels).x;
    }
    let right = vec2(1.0 - texels.part.x, texels.part.x);
    let weights = vec4(right * (1.0 - texels.part.y), right * texels.part.y);
    let reached = select(vec4(0.0), weights, values >= vec4(0.0));
    let sum = dot(reached, vec4(1.0));
    return select(-1.0, dot(reached, values) / sum, sum > 0.5);
}
