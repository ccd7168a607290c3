// Contours and paths as lines, from the vertices that geosweep has written.

struct Line {
    @builtin(position) clip: vec4<f32>,
    // The distance in spacings of lines.
    @location(0) level: f32,
}

// Moves a vertex by the fraction `nearer` of its way toward the eye: it then lies above the surface, in the same pixel.
fn placed(position: vec3<f32>, time: f32, nearer: f32) -> Line {
    let above = mix(position, view.eye, nearer);
    return Line(view.projection * vec4(above, 1.0), time / abs(view.spacing));
}

@vertex
fn contour_vertex(@location(0) position: vec3<f32>, @location(1) time: f32) -> Line {
    return placed(position, time, 0.0015);
}

@fragment
fn thin_fragment(in: Line) -> @location(0) vec4<f32> {
    return vec4(0.012, 0.014, 0.016, 0.62);
}

// Every fifth contour is a strong one.
@fragment
fn strong_fragment(in: Line) -> @location(0) vec4<f32> {
    let fifth = in.level / 5.0;
    if abs(fifth - round(fifth)) > 0.05 {
        discard;
    }
    return vec4(0.012, 0.014, 0.016, 0.92);
}

@vertex
fn rim_vertex(@location(0) position: vec3<f32>, @location(1) time: f32) -> Line {
    return placed(position, time, 0.003);
}

@fragment
fn rim_fragment(in: Line) -> @location(0) vec4<f32> {
    return vec4(0.02, 0.02, 0.02, 1.0);
}

@vertex
fn path_vertex(@location(0) position: vec3<f32>, @location(1) time: f32) -> Line {
    return placed(position, time, 0.0045);
}

@fragment
fn path_fragment(in: Line) -> @location(0) vec4<f32> {
    return vec4(0.90, 0.90, 0.90, 1.0);
}
