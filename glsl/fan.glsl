// The edges of the fan of eight triangles around a point.

layout(set = 0, binding = 0, rgba32f) uniform readonly restrict image2D edges;

// Steps to the eight neighbours, counter-clockwise from east.
const ivec2 FAN[8] = ivec2[](ivec2(1, 0), ivec2(1, -1), ivec2(0, -1), ivec2(-1, -1),
                             ivec2(-1, 0), ivec2(-1, 1), ivec2(0, 1), ivec2(1, 1));

float edge_length(ivec2 point, ivec2 step) {
    return stored_here(step) ? stored_length(imageLoad(edges, point), step)
                             : stored_length(imageLoad(edges, point + step), -step);
}
