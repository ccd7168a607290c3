// Finds the copies of single points of a glued grid.
// Counterpart: crates/geometry/src/copies.rs.
//
// The including shader declares
//     ivec2 grid;        columns and rows of the whole grid
//     uint copies[];     buffer that begins with the list, which src/vulkan/copies.rs writes: the number of groups. Then
//                        for each row its first copy, and the number of copies at the end. Then the columns of all
//                        copies, and then the numbers of their groups. Then for each group its first member, and the
//                        number of members at the end. Then the members of groups, by their row-major indices.

const int FIRST_ROW = 1;

int groups_in_list() {
    return int(copies[0]);
}

// Returns the number of copies.
int copies_in_list() {
    return int(copies[FIRST_ROW + grid.y]);
}

// Returns where the columns of copies begin.
int first_col() {
    return FIRST_ROW + grid.y + 1;
}

// Returns where the first members of groups begin.
int first_group() {
    return first_col() + 2 * copies_in_list();
}

// Returns the members of a group: the first of them, and the one after the last.
ivec2 members_of_group(int group) {
    int at = first_group() + group;
    return ivec2(copies[at], copies[at + 1]);
}

// Returns the number of a point's group. It is -1 for points without copies.
int group_of(ivec2 at) {
    int low = int(copies[FIRST_ROW + at.y]);
    int end = int(copies[FIRST_ROW + at.y + 1]);
    int high = end;
    while (low < high) {
        int middle = (low + high) / 2;
        if (int(copies[first_col() + middle]) < at.x) low = middle + 1; else high = middle;
    }
    if (low == end || int(copies[first_col() + low]) != at.x) return -1;
    return int(copies[first_col() + copies_in_list() + low]);
}

// Returns the members of a point's group. Points without copies have none.
ivec2 members_of(ivec2 at) {
    int group = group_of(at);
    return group < 0 ? ivec2(0) : members_of_group(group);
}

int listed(int word) {
    return int(copies[word]);
}

// Returns where the members of groups begin.
int members_in_list() {
    return first_group() + groups_in_list() + 1;
}

// Returns the row-major index of the point with this number among the members of groups.
int member_index(int number) {
    return int(copies[members_in_list() + number]);
}

ivec2 member(int number) {
    return from_row_major(member_index(number), grid.x);
}
