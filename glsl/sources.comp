#version 450
#extension GL_GOOGLE_include_directive : require
// Initial values around sources that lie anywhere on the grid, as seed.comp reads them. A source
// reaches no further than 2 x 2 texels: one invocation is one source and one of these texels, and
// the first source of a texel writes what all bring to it.
//
// The distance from a place in a cell to a corner follows from the lengths of the cell's edges:
// with the place p = sum of w_i p_i over the corners, and the corner at the origin,
// |p|^2 = sum of w_i w_j <p_i, p_j>, and 2 <p_i, p_j> = |p_i|^2 + |p_j|^2 - |p_i - p_j|^2.
// Nothing needs to be known of positions, and slowness is in the lengths.
// Twin: Sources::seeds in src/surface/sources.rs, in terms of positions.

#include "constants.glsl"
#include "texel.glsl"
#include "fan.glsl"
#include "cell.glsl"

layout(local_size_x = WORKGROUP) in;

struct SeedTexel {
    ivec2 texel;
    ivec2 unused; // vec4 follows on a multiple of 16 bytes
    vec4 times;
    vec4 curvatures;
};

layout(set = 0, binding = 7) writeonly restrict buffer Seeds {
    SeedTexel seeds[];
};

layout(push_constant) uniform Portion {
    ivec2 grid;     // columns and rows of the whole grid
    int first_word; // of the first source
    int count;      // of sources
};

#include "source.glsl"

// The first of the texels with points of cells around a source.
ivec2 first_texel(Source s) {
    return max(ivec2(ceil(place_of(s))) - 1, ivec2(0)) / 2 + BORDER;
}

bool reaches(Source s, ivec2 texel) {
    ivec2 from_first = texel - first_texel(s);
    return all(greaterThanEqual(from_first, ivec2(0))) && all(lessThanEqual(from_first, ivec2(1)));
}

const ivec2 CORNERS[4] = ivec2[](ivec2(0, 0), ivec2(1, 0), ivec2(0, 1), ivec2(1, 1));

// The lengths of the edges between the corners of a cell.
struct Cell {
    float lengths[16];
};

Cell cell_at(ivec2 first) {
    Cell cell;
    for (int a = 0; a < 4; a++) {
        cell.lengths[5 * a] = 0.0;
        for (int b = a + 1; b < 4; b++) {
            float size = edge_length(first + CORNERS[a], CORNERS[b] - CORNERS[a]);
            cell.lengths[4 * a + b] = size;
            cell.lengths[4 * b + a] = size;
        }
    }
    return cell;
}

// From a corner of a cell to a place in it; FAR if there is no way.
float distance_in(Cell cell, int corner, vec2 uv) {
    bvec4 there;
    for (int a = 0; a < 4; a++) {
        there[a] = false;
        for (int b = 0; b < 4; b++) {
            if (a != b && cell.lengths[4 * a + b] < FAR) there[a] = true;
        }
    }
    vec4 weights;
    if (!there[corner] || !corner_weights(there, uv, weights)) return FAR;
    float square = 0.0;
    for (int a = 0; a < 4; a++) {
        for (int b = 0; b < 4; b++) {
            if (weights[a] == 0.0 || weights[b] == 0.0) continue;
            float to_a = cell.lengths[4 * corner + a];
            float to_b = cell.lengths[4 * corner + b];
            float between = cell.lengths[4 * a + b];
            if (max(max(to_a, to_b), between) >= FAR) return FAR;
            float product = 0.5 * ((to_a * to_a + to_b * to_b) - between * between);
            square += weights[a] * weights[b] * product;
        }
    }
    return sqrt(max(square, 0.0));
}

bool has_edge(ivec2 point) {
    for (int i = 0; i < 8; i++) {
        if (edge_length(point, FAN[i]) < FAR) return true;
    }
    return false;
}

// When a source's front reaches a point of the cells around it, and its curvature there.
vec2 arrival(Source s, ivec2 point) {
    vec2 place = place_of(s);
    vec2 whole = floor(place);
    if (place == whole) {
        bool is_here = point == ivec2(whole) && has_edge(point + 2 * BORDER);
        return is_here ? vec2(s.time, s.curvature) : vec2(FAR, 0.0);
    }
    float nearest = FAR;
    for (int i = 0; i < 4; i++) {
        // The cell of which the point is this corner.
        ivec2 first = point - CORNERS[i];
        vec2 uv = place - vec2(first);
        bool inside = all(greaterThanEqual(uv, vec2(0.0))) && all(lessThanEqual(uv, vec2(1.0)));
        if (inside) nearest = min(nearest, distance_in(cell_at(first + 2 * BORDER), i, uv));
    }
    if (nearest >= FAR) return vec2(FAR, 0.0);
    return vec2(s.time + nearest, nearest > 0.0 ? 1.0 / nearest : SOURCE_CURVATURE);
}

void main() {
    int index = int(gl_GlobalInvocationID.x);
    if (index >= 4 * count) return;
    int number = index / 4;
    Source own = source(number);
    seeds[index].texel = ivec2(-1);
    if (!counts(own)) return;
    ivec2 texel = first_texel(own) + CORNERS[index & 3];
    // The image's border ends where the grid's last texel has a neighbour.
    if (any(greaterThan(2 * (texel - BORDER), grid - 1))) return;
    for (int i = 0; i < number; i++) {
        Source other = source(i);
        if (counts(other) && reaches(other, texel)) return;
    }
    vec4 times = vec4(FAR);
    vec4 curvatures = vec4(0.0);
    for (int i = number; i < count; i++) {
        Source other = source(i);
        if (!counts(other) || !reaches(other, texel)) continue;
        for (int j = 0; j < 4; j++) {
            vec2 front = arrival(other, 2 * (texel - BORDER) + CORNERS[j]);
            if (front.x < times[j]) {
                times[j] = front.x;
                curvatures[j] = with_tag(front.y, 0u);
            }
        }
    }
    seeds[index].texel = texel;
    seeds[index].times = times;
    seeds[index].curvatures = curvatures;
}
