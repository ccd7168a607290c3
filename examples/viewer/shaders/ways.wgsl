// Directions in which agents step, as vectors of columns and rows, no longer than 1.
// The includer defines `apart`, the length between two grid points.

// The way back to the source. Where the ways of the four texels lead apart, the nearest one is as good as any.
fn along_directions(directions: texture_2d<f32>, place: vec2<f32>) -> vec2<f32> {
    let way = between(around(directions, place));
    if length(way) > 0.5 {
        return normalize(way);
    }
    return textureLoad(directions, vec2<i32>(round(place)), 0).xy;
}

// The way to the neighbour, one of eight, to which the distance falls most steeply.
fn to_neighbour(distances: texture_2d<f32>, place: vec2<f32>) -> vec2<f32> {
    let last = vec2<i32>(textureDimensions(distances)) - 1;
    let at = vec2<i32>(round(place));
    let here = textureLoad(distances, at, 0).x;
    var steepest = 0.0;
    var neighbour = at;
    for (var i = 0; i < 9; i++) {
        let to = clamp(at + vec2<i32>(i % 3 - 1, i / 3 - 1), vec2<i32>(0), last);
        let there = textureLoad(distances, to, 0).x;
        let fall = (here - there) / max(apart(at, to), 1e-6);
        // Points that are not reached may hold a negative number.
        if there >= 0.0 && fall > steepest {
            steepest = fall;
            neighbour = to;
        }
    }
    let way = vec2<f32>(neighbour) - place;
    return way / max(length(way), 1e-3);
}
