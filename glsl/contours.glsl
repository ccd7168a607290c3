// Contours by marching triangles: what the shaders contour_*.comp share. Segments are counted,
// their places found by sums, and then they are written: always in the same order, by rows of
// cells from north to south.
//
// One workgroup is a row of cells in contour_counts.comp and contour_segments.comp, one
// invocation a strip of cells in it.
// Twin: src/geometry/contours.rs, and src/surface/chart for which triangles there are.

layout(set = 1, binding = 0) restrict buffer Counts {
    // The levels as floats, ascending; how many segments lie in the rows of cells before each, or
    // in each at first; for each row how many lie in the strips before each.
    uint counts[];
};

layout(push_constant) uniform Contours {
    ivec2 grid;       // columns and rows of the whole grid
    uint levels;
    int first_vertex; // its word
    int capacity;     // in vertices, even
    float start;      // since when squares of times count
};

float level(uint index) {
    return uintBitsToFloat(counts[index]);
}

uint row_index(int row) {
    return LEVELS_TOGETHER + row;
}

uint strip_index(int row, uint strip) {
    return LEVELS_TOGETHER + grid.y + row * WORKGROUP + strip;
}

// The columns of cells of an invocation's strip, from the first to before the last.
ivec2 strip_columns() {
    int cells = cells_of(grid).x;
    int width = (cells + WORKGROUP - 1) / WORKGROUP;
    int first = int(gl_LocalInvocationID.x) * width;
    return min(ivec2(first, first + width), cells);
}

const uint MISSING = 0xffffffffu;

// How many levels a point has passed: the time there is at least as large.
uint passed(float time) {
    if (!is_reached(time)) return MISSING;
    uint low = 0u;
    uint high = levels;
    while (low < high) {
        uint middle = (low + high) / 2u;
        if (level(middle) <= time) {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return low;
}

// A cell's corners, north-west, north-east, south-west and south-east: how many levels each has
// passed, and its time.
struct Corners {
    uvec4 passed;
    vec4 times;
};

// The cell to the east of one whose eastern corners are known; of any cell with `west` false.
Corners corners_at(ivec2 cell, bool west, Corners before) {
    Corners here;
    if (west) {
        here.passed.xz = before.passed.yw;
        here.times.xz = before.times.yw;
    } else {
        here.times.xz = vec2(time_at(cell), time_at(cell + to_corner(2)));
        here.passed.xz = uvec2(passed(here.times.x), passed(here.times.z));
    }
    here.times.yw = vec2(time_at(cell + to_corner(1)), time_at(cell + to_corner(3)));
    here.passed.yw = uvec2(passed(here.times.y), passed(here.times.w));
    return here;
}

// Counter-clockwise as seen in a picture, by the numbers of their corners: two of a cell that is
// cut from north-west to south-east, two of one that is cut the other way.
const ivec3 TRIANGLES[4] = ivec3[](ivec3(0, 2, 3), ivec3(0, 3, 1), ivec3(0, 2, 1), ivec3(2, 3, 1));

// The first of a cell's triangles, and the one after its last. The cell is cut along the diagonal
// that the map rises on, so that curves cross it.
ivec2 triangles(Corners cell) {
    int missing = 0;
    int hole = 0;
    for (int i = 0; i < 4; i++) {
        if (cell.passed[i] == MISSING) {
            missing += 1;
            hole = i;
        }
    }
    if (missing == 0) {
        bool falling = abs(cell.times.x - cell.times.w) >= abs(cell.times.y - cell.times.z);
        return falling ? ivec2(0, 2) : ivec2(2, 4);
    }
    const int LEFT_BY[4] = int[](3, 0, 1, 2);
    return missing == 1 ? ivec2(LEFT_BY[hole], LEFT_BY[hole] + 1) : ivec2(0);
}

// The first level that passes through a triangle, and the one after the last.
uvec2 levels_through(Corners cell, ivec3 triangle) {
    uvec3 ends = uvec3(cell.passed[triangle.x], cell.passed[triangle.y], cell.passed[triangle.z]);
    return uvec2(min(min(ends.x, ends.y), ends.z), max(max(ends.x, ends.y), ends.z));
}
