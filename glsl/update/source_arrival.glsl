// Computes when a source's front reaches the points around it.
//
// The distance from a place in a cell to a corner follows from the lengths of the cell's edges and diagonals. Let the
// place be p = sum of w_i p_i, with the positions p_i and weights w_i of the corners, and this corner be at 0. Then
// |p|^2 = sum of w_i w_j <p_i, p_j>, and 2 <p_i, p_j> = |p_i|^2 + |p_j|^2 - |p_i - p_j|^2.
// No positions are needed. Over a slowness, lengths are those on the surface, and a line costs its length times the mean
// slowness of its ends.
// Twin: Sources::seeds in crates/surface/src/sources, in terms of positions.

#include "shared/edge_image.glsl"
#include "shared/cell.glsl"
#include "shared/source.glsl"
#include "shared/surface_image.glsl"

struct Cell {
    float lengths[16]; // of the edges between the corners a and b, at the index 4 a + b
    vec4 slowness;     // at the corners; 1 without a slowness
};

// Returns the cell with a given north-western corner.
Cell cell_at(ivec2 first) {
    Cell cell;
    // If the slowness varies, its image has a texel for each point of a row, as the edges have.
    bool is_slowed = imageSize(gaussians).x >= imageSize(edges).x;
    for (int a = 0; a < 4; a++) cell.slowness[a] = is_slowed ? slowness_at(first + to_corner(a)) : 1.0;
    for (int a = 0; a < 4; a++) {
        cell.lengths[5 * a] = 0.0;
        for (int b = a + 1; b < 4; b++) {
            float size = edge_length(first + to_corner(a), to_corner(b) - to_corner(a));
            if (is_slowed && size < FAR) size /= 0.5 * (cell.slowness[a] + cell.slowness[b]);
            cell.lengths[4 * a + b] = size;
            cell.lengths[4 * b + a] = size;
        }
    }
    return cell;
}

// Returns the distance from a corner of a cell to a place in it, or FAR if no part of the cell connects them. `uv` is
// the place, from 0 to 1 along both axes.
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
    return sqrt(max(square, 0.0)) * 0.5 * (cell.slowness[corner] + dot(cell.slowness, weights));
}

// Returns the time at which a source's front reaches a point of the cells around it, and the front's curvature there.
// The result is FAR and 0 if the front does not reach the point through these cells.
vec2 arrival(Source s, ivec2 at) {
    vec2 place = place_of(s);
    vec2 whole = floor(place);
    if (place == whole) {
        bool is_here = at == ivec2(whole) && has_edge(point_at(at));
        return is_here ? vec2(s.time, s.curvature) : vec2(FAR, 0.0);
    }
    float nearest = FAR;
    for (int i = 0; i < 4; i++) {
        // The cell whose i-th corner is the point.
        ivec2 first = at - to_corner(i);
        vec2 uv = place - vec2(first);
        bool inside = all(greaterThanEqual(uv, vec2(0.0))) && all(lessThanEqual(uv, vec2(1.0)));
        if (inside) nearest = min(nearest, distance_in(cell_at(point_at(first)), i, uv));
    }
    if (nearest >= FAR) return vec2(FAR, 0.0);
    return vec2(s.time + nearest, nearest > 0.0 ? 1.0 / nearest : SOURCE_CURVATURE);
}
