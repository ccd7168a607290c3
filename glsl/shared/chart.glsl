// Defines the chart: where each point is stored. All arithmetic on borders, neighbours, texels and lines is
// in this file. The build includes it in every shader.
//
// Coordinates are ivec2(column, row), with x to the east and y to the south:
//
//     at      a point of the grid; ivec2(0) is the north-western one
//     point   the same point in the images, which have a border around the grid
//     texel   2 x 2 points that share a texel in the images of fronts and of surface values:
//                 x y     a texel's row above, columns 2c and 2c + 1
//                 z w     its row below
//     inner   a texel counted without the border. Invocations, tiles and blocks are counted in this way
//     place   a position on the grid, between its points
//
// The image of edge lengths has one texel per point: its edges to the east, north, north-east and north-west.
// Twins: crates/surface/src/chart and src/vulkan/texel_chart.rs.

#include "shared/constants.glsl"

// The grid. Its size is given in columns and rows.

bool in_grid(ivec2 at, ivec2 size) {
    return all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, size));
}

// Returns whether `at` lies beyond the last column or row. The test is for numbers of invocations, which are
// never negative.
bool is_beyond(ivec2 at, ivec2 size) {
    return any(greaterThanEqual(at, size));
}

// Returns whether a place is finite and on the grid.
bool is_on_grid(vec2 place, ivec2 size) {
    bool finite = (floatBitsToUint(place.x) & 0x7f800000u) != 0x7f800000u
        && (floatBitsToUint(place.y) & 0x7f800000u) != 0x7f800000u;
    return finite && place.x >= 0.0 && place.y >= 0.0
        && place.x <= float(size.x - 1) && place.y <= float(size.y - 1);
}

int points_of(ivec2 size) {
    return size.x * size.y;
}

// Returns the nearest place on the grid, for a place that only rounding can have moved off the grid.
vec2 back_on_grid(vec2 place, ivec2 size) {
    return clamp(place, vec2(0.0), vec2(size - 1));
}

// Returns the nearest point of the grid, for a point that may lie beyond the last row or column.
ivec2 up_to_last(ivec2 at, ivec2 size) {
    return min(at, size - 1);
}

// Returns the number of columns and rows of cells.
ivec2 cells_of(ivec2 size) {
    return size - 1;
}

// Row-major order: the order of points in buffers, of anchors, of tiles, and of all data in shared memory.

int row_major(ivec2 at, int columns) {
    return at.y * columns + at.x;
}

ivec2 from_row_major(int index, int columns) {
    return ivec2(index % columns, index / columns);
}

// Returns the indices of a cell's corners: north-west, north-east, south-west and south-east.
ivec4 corners_row_major(ivec2 first, int columns) {
    return row_major(first, columns) + ivec4(0, 1, columns, columns + 1);
}

// Returns the step from a cell's first point to one of its corners, which are numbered in the same order, or
// from a texel's first point to another of its points.
ivec2 to_corner(int corner) {
    return ivec2(corner & 1, corner >> 1);
}

// Neighbours and edges.

// Steps to the eight neighbours, counter-clockwise from east.
const ivec2 NEIGHBOURS[8] = ivec2[](ivec2(1, 0), ivec2(1, -1), ivec2(0, -1), ivec2(-1, -1),
                                    ivec2(-1, 0), ivec2(-1, 1), ivec2(0, 1), ivec2(1, 1));

// Steps along the edges whose lengths are stored at a point.
const ivec2 STORED[4] = ivec2[](ivec2(1, 0), ivec2(0, -1), ivec2(1, -1), ivec2(-1, -1));

// Returns the component of a point's lengths for a step to the east or north.
float stored_length(vec4 lengths, ivec2 step) {
    if (step.y == 0) return lengths.x;
    return step.x == 0 ? lengths.y : step.x > 0 ? lengths.z : lengths.w;
}

// Returns the index of the component of a point's lengths for a step to the east or north.
int component_stored(ivec2 step) {
    if (step.y == 0) return 0;
    return step.x == 0 ? 1 : step.x > 0 ? 2 : 3;
}

// Returns whether the length of an edge is stored at this end, from which it leads east or north.
bool stored_here(ivec2 step) {
    return step.y < 0 || (step.y == 0 && step.x > 0);
}

// Returns the length of an edge, given the lengths that are stored at both of its ends.
float length_between(vec4 here, vec4 there, ivec2 step) {
    bool own = stored_here(step);
    return stored_length(own ? here : there, own ? step : -step);
}

// Points and texels of the images.

// Converts a grid point to its point in the images, and back.
ivec2 point_at(ivec2 at) {
    return at + 2 * BORDER;
}

ivec2 at_point(ivec2 point) {
    return point - 2 * BORDER;
}

// Converts a texel counted without the border to the same texel in the images, and back.
ivec2 with_border(ivec2 inner) {
    return inner + BORDER;
}

ivec2 without_border(ivec2 texel) {
    return texel - BORDER;
}

int without_border(int texel) {
    return texel - BORDER;
}

ivec2 texel_of(ivec2 point) {
    return point / 2;
}

// Returns the component of a point in its texel.
int component_of(ivec2 point) {
    return 2 * (point.y & 1) + (point.x & 1);
}

ivec2 first_point(ivec2 texel) {
    return 2 * texel;
}

// Returns the number of inner texels of a grid, in columns and rows.
ivec2 texels_of(ivec2 size) {
    return (size + 1) / 2;
}

// Returns the size of an image in texels, given the columns and rows of its inner texels.
ivec2 all_texels(ivec2 inner) {
    return inner + 2 * BORDER;
}

ivec2 last_texel(ivec2 inner) {
    return all_texels(inner) - 1;
}

ivec2 last_point(ivec2 inner) {
    return 2 * all_texels(inner) - 1;
}

// Scans, numbered from 0 in the order of an iteration: down, up, right and left. A scan visits one line after
// another, two of them in each texel. Each line runs from west to east or from north to south.

// Returns the scan's direction.
ivec2 ahead_of(int scan) {
    int way = 1 - 2 * (scan & 1);
    return scan < 2 ? ivec2(0, way) : ivec2(way, 0);
}

// Returns the step from point to point of a line.
ivec2 along_of(int scan) {
    return scan < 2 ? ivec2(1, 0) : ivec2(0, 1);
}

// Returns the number of points of each line of a scan, and the number of its lines.
int points_of_line(ivec2 size, int scan) {
    return scan < 2 ? size.x : size.y;
}

int lines_of(ivec2 size, int scan) {
    return scan < 2 ? size.y : size.x;
}

// Returns the distance in memory from point to point of a line, and from line to line. `pitch` is the
// distance between rows.
int stride_along(int scan, int pitch) {
    return scan < 2 ? 1 : pitch;
}

int stride_ahead(int scan, int pitch) {
    return scan < 2 ? pitch : 1;
}

// Returns the number of the row or column in which a point or texel lies.
int line_of(ivec2 at, int scan) {
    return scan < 2 ? at.y : at.x;
}

// Returns the point or texel at a place of a line.
ivec2 in_line(int line, int place, ivec2 ahead, ivec2 along) {
    return line * abs(ahead) + place * along;
}

// Returns how far a step leads ahead, in lines.
int lines_ahead(ivec2 step, ivec2 ahead) {
    ivec2 way = step * ahead;
    return way.x + way.y;
}

// Returns the number of a texel in a line of texels, or the number of the nearest texel of the line if it
// lies beyond.
int texel_in_line(int texel, int last) {
    return max(min(texel, last), BORDER);
}

// Returns the first point of a texel's first line.
ivec2 first_point_of_line(ivec2 texel, ivec2 ahead) {
    return first_point(texel) + max(-ahead, 0);
}

// Returns the values of a texel's first line.
vec2 first_line(vec4 texel, ivec2 ahead) {
    if (ahead.y != 0) return ahead.y > 0 ? texel.xy : texel.zw;
    return ahead.x > 0 ? texel.xz : texel.yw;
}

vec2 second_line(vec4 texel, ivec2 ahead) {
    return first_line(texel, -ahead);
}

// Returns the values of a texel, given the values of its first and its second line.
vec4 texel_of_lines(vec2 first, vec2 second, ivec2 ahead) {
    bool forward = ahead.x + ahead.y > 0;
    vec2 low = forward ? first : second;
    vec2 high = forward ? second : first;
    return ahead.y != 0 ? vec4(low, high) : vec4(low.x, high.x, low.y, high.y);
}

// Returns the number of pairs of points of a line with this number of points.
int pairs_of(int points) {
    return (points + 1) / 2;
}

// Returns the index of a point in a line, or the index of the nearest end of the line if it lies beyond.
int point_in_line(int index, int points) {
    return clamp(index, 0, points - 1);
}
