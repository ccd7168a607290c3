// Finds the copies of points on glued surfaces, in pipelines that are also made for open surfaces. A shader that is for
// open surfaces alone defines OPEN_ONLY.
//
// The including shader declares
//     ivec2 grid;        columns and rows of the whole grid

#ifdef OPEN_ONLY

const int SEAMS = 0;

ivec2 copies_of(ivec2 at) {
    return ivec2(0);
}

int first_copy(ivec2 at) {
    return row_major(at, grid.x);
}

ivec2 member(int number) {
    return ivec2(0);
}

int members_in_list() {
    return 0;
}

int listed(int word) {
    return 0;
}

#else

// Whether the surface is glued.
layout(constant_id = 17) const int SEAMS = 0;

// On open surfaces another buffer is bound, and not read.
layout(set = 0, binding = 3) readonly restrict buffer CopiesByRow {
    uint copies[];
};

#include "shared/copies_by_row.glsl"

// Returns the members of a point's group: the first of them, and the one after the last. Points without copies have
// none.
ivec2 copies_of(ivec2 at) {
    return SEAMS != 0 ? members_of(at) : ivec2(0);
}

// Returns the row-major index of the first copy of a point, which stands for all of them. A point without copies is its
// own first copy.
int first_copy(ivec2 at) {
    ivec2 members = copies_of(at);
    return members.x < members.y ? member_index(members.x) : row_major(at, grid.x);
}

#endif
