// Describes a cell of the grid and the distances in it, from the lengths of its edges alone. Lengths are in
// units of the cell's longest edge, so that products of squares stay within single precision. Over a slowness, the
// longest edge is the one that takes longest; lengths are those on the surface, times the largest slowness of the cell.
// Twin: crates/geometry/src/paths/cell.rs, where the arithmetic is explained.
//
// The including shader declares the push constant `slowed`.

#include "shared/edge_image.glsl"
#include "shared/surface_image.glsl"
#include "shared/times.glsl"

// Corners at both ends of each of a cell's sides: north, west, east and south.
const ivec2 SIDES[4] = ivec2[](ivec2(0, 1), ivec2(0, 2), ivec2(1, 3), ivec2(2, 3));
// Stands for the squared length of an edge that does not exist.
const float NO_EDGE = 1e20;

struct Cell {
    ivec2 first;  // its north-western corner
    float unit;   // length of its longest edge; 0 if it has none
    vec4 times;   // at its corners
    vec4 slowness; // at its corners, as parts of the largest; 1 without a slowness
    mat4 squares; // squared lengths between its corners
};

// The corners at the ends of a cell's edges, in the order of edges_of_cell().
const ivec2 ENDS[6] = ivec2[](ivec2(0, 1), ivec2(0, 2), ivec2(0, 3), ivec2(1, 2), ivec2(1, 3), ivec2(2, 3));

float square_of(float size, float unit) {
    float scaled = size / unit;
    return size < FAR ? scaled * scaled : NO_EDGE;
}

// Returns the cell with a given north-western corner.
Cell cell_at(ivec2 first) {
    float sizes[6] = edges_of_cell(point_at(first));
    Cell cell;
    cell.first = first;
    cell.unit = 0.0;
    for (int i = 0; i < 6; i++) {
        if (sizes[i] < FAR) cell.unit = max(cell.unit, sizes[i]);
    }
    cell.times = times_at_corners(first);
    if (cell.unit == 0.0) return cell;
    cell.slowness = vec4(1.0);
    if (slowed != 0) {
        for (int i = 0; i < 4; i++) cell.slowness[i] = slowness_at(point_at(first + to_corner(i)));
        float largest = 0.0;
        for (int i = 0; i < 6; i++) {
            if (sizes[i] < FAR) largest = max(largest, max(cell.slowness[ENDS[i].x], cell.slowness[ENDS[i].y]));
        }
        // The slowness of missing corners does not matter.
        if (largest > 0.0) cell.slowness = min(cell.slowness / largest, 1.0);
    }
    float squares[6];
    for (int i = 0; i < 6; i++) {
        float mean = 0.5 * (cell.slowness[ENDS[i].x] + cell.slowness[ENDS[i].y]);
        // Where travel is free, the length on the surface is not known, and does not count.
        float size = sizes[i] < FAR && mean > 0.0 ? sizes[i] / mean : sizes[i];
        squares[i] = square_of(size, cell.unit);
    }
    float north = squares[0];
    float west = squares[1];
    float falling = squares[2];
    float rising = squares[3];
    float east = squares[4];
    float south = squares[5];
    cell.squares = mat4(0.0, north, west, falling,
                        north, 0.0, rising, east,
                        west, rising, 0.0, south,
                        falling, east, south, 0.0);
    return cell;
}

// Returns the squared distances from a place to the corners. At missing corners, they are too large for any
// distance.
vec4 squares_from(Cell cell, vec4 place) {
    vec4 products = cell.squares * place;
    return products - 0.5 * dot(products, place);
}

// Returns the cost of a straight line between two places whose squared distance is given: its length times the mean
// slowness of its ends.
float cost_of(Cell cell, float square, vec4 a, vec4 b) {
    float mean = slowed != 0 ? 0.5 * dot(cell.slowness, a + b) : 1.0;
    return sqrt(max(square, 0.0)) * mean;
}

// Returns the cost of a straight line between two places.
float cost_between(Cell cell, vec4 a, vec4 b) {
    vec4 apart = a - b;
    return cost_of(cell, -0.5 * dot(cell.squares * apart, apart), a, b);
}

// Returns the weights of a corner.
vec4 corner_alone(int corner) {
    return vec4(equal(ivec4(corner), ivec4(0, 1, 2, 3)));
}

bvec4 reached_corners(Cell cell) {
    return lessThan(cell.times, vec4(FAR));
}
