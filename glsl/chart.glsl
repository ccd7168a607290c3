// The chart: which point lies where. All arithmetic on borders, neighbours, texels and lines is here; a
// surface glued along its borders would change this file, and fill a halo.
//
// Coordinates are ivec2(column, row), x to the east and y to the south:
//
//     at      a point of the grid, of which ivec2(0) is the north-western one
//     point   the same point in the images, which have a border around the grid
//     texel   2 x 2 points of the images of fronts and of what the surface brings, which share a texel:
//                 x y     a texel's row above, columns 2c and 2c + 1
//                 z w     its row below
//     inner   a texel counted without the border, as invocations, tiles and blocks are
//     place   somewhere on the grid, between its points
//
// The image of edge lengths has one texel a point: its edges to the east, north, north-east and north-west.
// Twins: src/surface/chart and src/vulkan/texel_chart.rs.

// The grid, by its size in columns and rows.

bool in_grid(ivec2 at, ivec2 size) {
    return all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, size));
}

// The same where `at` counts invocations, none of which lies before the first.
bool is_beyond(ivec2 at, ivec2 size) {
    return any(greaterThanEqual(at, size));
}

// Not infinite nor NaN, and on the grid.
bool is_on_grid(vec2 place, ivec2 size) {
    bool finite = (floatBitsToUint(place.x) & 0x7f800000u) != 0x7f800000u
        && (floatBitsToUint(place.y) & 0x7f800000u) != 0x7f800000u;
    return finite && place.x >= 0.0 && place.y >= 0.0
        && place.x <= float(size.x - 1) && place.y <= float(size.y - 1);
}

int points_of(ivec2 size) {
    return size.x * size.y;
}

// A place that only rounding can have led off the grid.
vec2 back_on_grid(vec2 place, ivec2 size) {
    return clamp(place, vec2(0.0), vec2(size - 1));
}

// The last point in line with one beyond the grid's last row or column.
ivec2 up_to_last(ivec2 at, ivec2 size) {
    return min(at, size - 1);
}

// Columns and rows of cells.
ivec2 cells_of(ivec2 size) {
    return size - 1;
}

// Row by row: the order of points in buffers, of anchors, of tiles, and of all that shared memory has.

int row_major(ivec2 at, int columns) {
    return at.y * columns + at.x;
}

ivec2 from_row_major(int index, int columns) {
    return ivec2(index % columns, index / columns);
}

// Of the corners of a cell, north-west, north-east, south-west and south-east.
ivec4 corners_row_major(ivec2 first, int columns) {
    return row_major(first, columns) + ivec4(0, 1, columns, columns + 1);
}

// From a cell's first point to one of its corners, in that order; from a texel's first point to another one.
ivec2 to_corner(int corner) {
    return ivec2(corner & 1, corner >> 1);
}

// Neighbours and edges.

// Steps to the eight neighbours, counter-clockwise from east.
const ivec2 NEIGHBOURS[8] = ivec2[](ivec2(1, 0), ivec2(1, -1), ivec2(0, -1), ivec2(-1, -1),
                                    ivec2(-1, 0), ivec2(-1, 1), ivec2(0, 1), ivec2(1, 1));

// Where the edges lead whose lengths a point has.
const ivec2 STORED[4] = ivec2[](ivec2(1, 0), ivec2(0, -1), ivec2(1, -1), ivec2(-1, -1));

// The component of a point's lengths that leads a step to the east or north.
float stored_length(vec4 lengths, ivec2 step) {
    if (step.y == 0) return lengths.x;
    return step.x == 0 ? lengths.y : step.x > 0 ? lengths.z : lengths.w;
}

// Where the length of an edge is stored: at the end from which it leads east or north.
bool stored_here(ivec2 step) {
    return step.y < 0 || (step.y == 0 && step.x > 0);
}

// Points and texels of the images.

// A grid point's point in the images, and back.
ivec2 point_at(ivec2 at) {
    return at + 2 * BORDER;
}

ivec2 at_point(ivec2 point) {
    return point - 2 * BORDER;
}

// The same for texels.
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

// A point's component of its texel.
int component_of(ivec2 point) {
    return 2 * (point.y & 1) + (point.x & 1);
}

// From a texel to one of the 3 x 3 around it.
ivec2 around_texel(int index) {
    return from_row_major(index, 3) - 1;
}

ivec2 first_point(ivec2 texel) {
    return 2 * texel;
}

// Inner texels of a grid, in columns and rows.
ivec2 texels_of(ivec2 size) {
    return (size + 1) / 2;
}

// Texels of an image, in columns and rows, of which these are the inner ones.
ivec2 all_texels(ivec2 inner) {
    return inner + 2 * BORDER;
}

ivec2 last_texel(ivec2 inner) {
    return all_texels(inner) - 1;
}

ivec2 last_point(ivec2 inner) {
    return 2 * all_texels(inner) - 1;
}

// Scans, from 0 in the order of an iteration: down, up, right and left. A scan passes line after line, and in a
// texel two of them, each from west to east or from north to south.

// The scan's direction.
ivec2 ahead_of(int scan) {
    int way = 1 - 2 * (scan & 1);
    return scan < 2 ? ivec2(0, way) : ivec2(way, 0);
}

// From point to point of its lines.
ivec2 along_of(int scan) {
    return scan < 2 ? ivec2(1, 0) : ivec2(0, 1);
}

// Points of each of its lines, and lines, in a grid.
int points_of_line(ivec2 size, int scan) {
    return scan < 2 ? size.x : size.y;
}

int lines_of(ivec2 size, int scan) {
    return scan < 2 ? size.y : size.x;
}

// From point to point of its lines and from line to line, where rows lie so far apart.
int stride_along(int scan, int pitch) {
    return scan < 2 ? 1 : pitch;
}

int stride_ahead(int scan, int pitch) {
    return scan < 2 ? pitch : 1;
}

// Which row or column something lies in.
int line_of(ivec2 at, int scan) {
    return scan < 2 ? at.y : at.x;
}

// What is so far along a line.
ivec2 in_line(int line, int place, ivec2 ahead, ivec2 along) {
    return line * abs(ahead) + place * along;
}

// How far a step leads ahead.
int lines_ahead(ivec2 step, ivec2 ahead) {
    ivec2 way = step * ahead;
    return way.x + way.y;
}

// The texel so far along a line of texels, or the line's nearest one.
int texel_in_line(int texel, int last) {
    return max(min(texel, last), BORDER);
}

// The first point of a texel's first line.
ivec2 first_point_of_line(ivec2 texel, ivec2 ahead) {
    return first_point(texel) + max(-ahead, 0);
}

// What a texel has for its first line.
vec2 first_line(vec4 texel, ivec2 ahead) {
    if (ahead.y != 0) return ahead.y > 0 ? texel.xy : texel.zw;
    return ahead.x > 0 ? texel.xz : texel.yw;
}

vec2 second_line(vec4 texel, ivec2 ahead) {
    return first_line(texel, -ahead);
}

// The texel made of two such lines.
vec4 texel_of_lines(vec2 first, vec2 second, ivec2 ahead) {
    bool forward = ahead.x + ahead.y > 0;
    vec2 low = forward ? first : second;
    vec2 high = forward ? second : first;
    return ahead.y != 0 ? vec4(low, high) : vec4(low.x, high.x, low.y, high.y);
}

// Pairs of points of a line that has so many.
int pairs_of(int points) {
    return (points + 1) / 2;
}

// The point so far along a line, or the nearest of its ends.
int point_in_line(int index, int points) {
    return clamp(index, 0, points - 1);
}
