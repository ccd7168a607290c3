#version 450
// Colours of a map with lines of equal distance, for a mesh whose texture coordinates are columns and rows of
// the grid. examples/render.rs has the same in WGSL.

layout(set = 0, binding = 0) uniform texture2D distances; // GeosweepImage::view
layout(set = 0, binding = 1) uniform sampler nearest;     // texels are fetched: any sampler does
layout(set = 0, binding = 2) uniform Look {
    float step;      // distance from line to line
    float farthest;  // distance that has the last colour
    float width;     // of lines, in pixels
    float unreached; // as GeosweepFrame::unreached, a negative number
} look;

layout(location = 0) in vec2 place; // column and row
layout(location = 0) out vec4 colour;

void main() {
    // Devices need not filter the format, and screen derivatives of fetched values are noise where triangles are a
    // few pixels large. So the gradient comes from the four texels around.
    ivec2 last = textureSize(sampler2D(distances, nearest), 0) - 2;
    ivec2 low = clamp(ivec2(place), ivec2(0), last);
    vec2 part = place - vec2(low);
    float a = texelFetch(sampler2D(distances, nearest), low, 0).r;
    float b = texelFetch(sampler2D(distances, nearest), low + ivec2(1, 0), 0).r;
    float c = texelFetch(sampler2D(distances, nearest), low + ivec2(0, 1), 0).r;
    float d = texelFetch(sampler2D(distances, nearest), low + ivec2(1, 1), 0).r;
    vec2 gradient = vec2(mix(b - a, d - c, part.y), mix(c - a, d - b, part.x));
    float a_pixel = length(vec2(dot(gradient, dFdx(place)), dot(gradient, dFdy(place))));
    if (min(min(a, b), min(c, d)) <= look.unreached) {
        colour = vec4(0.5, 0.5, 0.5, 1.0);
        return;
    }
    float found = mix(mix(a, b, part.x), mix(c, d, part.x), part.y);
    float t = found / look.step;
    float away = abs(fract(t - 0.5) - 0.5) * look.step / max(a_pixel, 1e-6);
    float line = 1.0 - smoothstep(0.5 * look.width - 0.6, 0.5 * look.width + 0.6, away);
    vec3 near = vec3(1.0, 0.93, 0.72);
    vec3 far = vec3(0.30, 0.12, 0.42);
    vec3 base = mix(near, far, clamp(found / look.farthest, 0.0, 1.0));
    colour = vec4(mix(base, vec3(0.12, 0.06, 0.12), 0.8 * line), 1.0);
}
