// The point of the surface at a column and a row. The includer binds `positions`.

fn point_at(place: vec2<f32>) -> vec3<f32> {
    let last = vec2<i32>(view.grid) - 1;
    let low = clamp(vec2<i32>(floor(place)), vec2<i32>(0), last - 1);
    let part = place - vec2<f32>(low);
    let cols = i32(view.grid.x);
    let index = low.y * cols + low.x;
    let above = mix(positions[index].xyz, positions[index + 1].xyz, part.x);
    let below = mix(positions[index + cols].xyz, positions[index + cols + 1].xyz, part.x);
    return mix(above, below, part.y);
}
