// Shares contouring by marching triangles among the shaders contour_*.comp. Segments are counted, their
// places are found by prefix sums, and then they are written. Their order is always the same: by rows of
// cells from north to south.
//
// In contour_counts.comp and contour_segments.comp, one workgroup is a row of cells, and one invocation is a
// strip of cells in it.
// Twin: crates/geometry/src/contours.rs, and crates/surface/src/chart for which triangles there are.

#include "shared/times.glsl"

layout(set = 1, binding = 0) restrict buffer Counts {
    // The levels as floats, in ascending order. Then for each row of cells, the number of segments in the
    // rows before it, or at first in the row itself. Then for each strip of each row, the number of segments
    // in the strips before it.
    uint counts[];
};

layout(push_constant) uniform Contours {
    ivec2 grid;       // columns and rows of the whole grid
    uint levels;
    int first_vertex; // index of the word at which the vertices begin
    int capacity;     // number of vertices, even
    float start;      // time that is subtracted before times are squared
};

// Returns a level by its index.
float level(uint index) {
    return uintBitsToFloat(counts[index]);
}

uint row_index(int row) {
    return LEVELS_TOGETHER + row;
}

uint strip_index(int row, uint strip) {
    return LEVELS_TOGETHER + grid.y + row * WORKGROUP + strip;
}

// Returns the range of columns of cells in an invocation's strip: the first, and the one after the last.
ivec2 strip_columns() {
    int cells = cells_of(grid).x;
    int width = (cells + WORKGROUP - 1) / WORKGROUP;
    int first = int(gl_LocalInvocationID.x) * width;
    return min(ivec2(first, first + width), cells);
}

const uint MISSING = 0xffffffffu;

// Returns the number of levels that a point has passed, or MISSING. A point has passed a level if its time is
// at least as large as the level.
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

// The corners of a cell, north-west, north-east, south-west and south-east. For each corner there are the
// number of levels that it has passed, and its time.
struct Corners {
    uvec4 passed;
    vec4 times;
};

// Returns the corners of a cell. If `west` is true, `before` is the cell to the west, whose eastern corners
// are reused.
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

// Triangles, counter-clockwise as seen in a picture, by the numbers of their corners. The first two belong to
// a cell that is cut from north-west to south-east, the others to a cell that is cut the other way.
const ivec3 TRIANGLES[4] = ivec3[](ivec3(0, 2, 3), ivec3(0, 3, 1), ivec3(0, 2, 1), ivec3(2, 3, 1));

// Returns the first of a cell's triangles, and the one after its last. The cell is cut along the diagonal on
// which the map rises more, so that curves cross it.
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

// Returns the first level that passes through a triangle, and the one after the last.
uvec2 levels_through(Corners cell, ivec3 triangle) {
    uvec3 ends = uvec3(cell.passed[triangle.x], cell.passed[triangle.y], cell.passed[triangle.z]);
    return uvec2(min(min(ends.x, ends.y), ends.z), max(max(ends.x, ends.y), ends.z));
}
