// The surface in the light, coloured by the image of distances, with iso-distance lines.

@group(0) @binding(1) var<storage, read> positions: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> shading: array<vec4<f32>>;
// Perceptually uniform colors from the source to the farthest of `some_distances`, in linear RGB.
@group(0) @binding(3) var<storage, read> palette: array<vec4<f32>>;
// Distances of places that are spread over the grid.
@group(0) @binding(4) var<storage, read> some_distances: array<f32>;
@group(0) @binding(5) var distances: texture_2d<f32>;

struct Fragment {
    @builtin(position) clip: vec4<f32>,
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) open: f32,
    // Column and row.
    @location(3) cell: vec2<f32>,
}

fn grid_point(index: u32, projection: mat4x4<f32>) -> Fragment {
    let position = positions[index];
    let shade = shading[index];
    let cell = vec2<f32>(f32(index % view.grid.x), f32(index / view.grid.x));
    return Fragment(projection * vec4(position.xyz, 1.0), position.xyz, shade.xyz, shade.w, cell);
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Fragment {
    return grid_point(index, view.projection);
}

@vertex
fn pick_vertex(@builtin(vertex_index) index: u32) -> Fragment {
    return grid_point(index, view.pick);
}

// A source as the distance passes read it: row, column, time, and the curvature of a point source.
@fragment
fn pick_fragment(in: Fragment) -> @location(0) vec4<f32> {
    let inside = clamp(in.cell, vec2(0.0), vec2<f32>(view.grid) - 1.0);
    // A place on the border of a chart must not lie in the hole beside it by rounding.
    let line = round(inside);
    let cell = select(inside, line, abs(inside - line) < vec2(1e-3));
    return vec4(cell.y, cell.x, 0.0, AT_SOURCE);
}

// The distance at a column and a row; negative where most of the points around are not reached.
fn distance_at(cell: vec2<f32>) -> f32 {
    return reached_between(around(distances, cell));
}

fn color_of(distance: f32) -> vec3<f32> {
    var farthest = 0.0;
    for (var i = 0u; i < arrayLength(&some_distances); i++) {
        farthest = max(farthest, some_distances[i]);
    }
    let last = f32(arrayLength(&palette) - 1u);
    let place = clamp(distance / max(farthest, 1e-6), 0.0, 1.0) * last;
    let index = u32(min(floor(place), last - 1.0));
    return mix(palette[index].rgb, palette[index + 1u].rgb, place - f32(index));
}

// The part of the pixel that a line covers. `distance` is in spacings of lines, and `slope` is its change over a pixel.
fn line(distance: f32, slope: f32, width: f32) -> f32 {
    let away = abs(distance - round(distance)) / max(slope, 1e-6);
    let cover = clamp(0.5 * width + 0.5 - away, 0.0, 1.0);
    // Lines too close for the pixels fade.
    return cover * (1.0 - smoothstep(0.18, 0.45, slope));
}

// The surface's color with lines, before light falls on it.
fn painted(distance: f32) -> vec3<f32> {
    let lines = distance / view.spacing;
    let slope = length(vec2(dpdx(lines), dpdy(lines)));
    if distance < 0.0 {
        return vec3(0.30, 0.31, 0.33);
    }
    // Every fifth line is a strong one. There is no line at the source itself.
    let thin = 0.62 * line(lines, slope, 1.1);
    let strong = 0.95 * line(lines / 5.0, slope / 5.0, 2.4);
    let ink = max(thin, strong) * smoothstep(0.3, 0.6, lines);
    return color_of(distance) * (1.0 - 0.90 * ink);
}

// Paint in the light, with the mark of the source.
fn shown(in: Fragment, front: bool, distance: f32, paint: vec3<f32>) -> vec4<f32> {
    let toward_eye = normalize(view.eye - in.position);
    let up = normalize(in.normal);
    let normal = select(-up, up, front);
    let light = normalize(view.light);
    let open = mix(0.15, 1.0, in.open * in.open);
    let sun = max(dot(normal, light), 0.0) * mix(0.6, 1.0, in.open);
    let sky = 0.5 + 0.5 * dot(normal, view.sky);
    let lit = vec3(1.0, 0.96, 0.90) * 1.12 * sun + vec3(0.86, 0.93, 1.0) * 0.40 * sky * open;
    let halfway = normalize(light + toward_eye);
    let gloss = 0.10 * pow(max(dot(normal, halfway), 0.0), 40.0) * sun;
    var color = paint * lit + gloss;

    // A white disc with a dark rim.
    let radius = distance / view.pixel;
    if distance >= 0.0 && radius < 14.0 {
        let disc = 1.0 - smoothstep(5.5, 7.0, radius);
        let rim = 1.0 - smoothstep(8.5, 10.0, radius);
        color = mix(mix(color, vec3(0.02), rim), vec3(0.95), disc);
    }
    return vec4(color + dither(in.clip.xy), 1.0);
}

@fragment
fn fragment(in: Fragment, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    let distance = distance_at(in.cell);
    return shown(in, front, distance, painted(distance));
}
