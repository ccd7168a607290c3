// Finds the copies of a place: all places of the grid at which a glued surface has the same point.
// Twin: crates/geometry/src/paths/seams.rs.
//
// The including shader defines
//     bool PASSES_POLES     whether paths leave a pole from another of its copies

#include "shared/times.glsl"
#include "shared/edge_image.glsl"
#include "shared/seams.glsl"
#include "passes/path_places.glsl"

// Points with more copies than this are poles. Lavapipe ends all loops of an invocation after 65,535 turns in total, so
// the cells around every copy of a pole cannot be searched.
const int MOST_COPIES = 8;

// Steps to the neighbours along rows and columns.
const ivec2 ALONG_LINES[4] = ivec2[](ivec2(1, 0), ivec2(0, 1), ivec2(-1, 0), ivec2(0, -1));

// Returns by how much the time falls along the edge from a point, per length. The result is -FAR if there is no such
// edge, the edge has no length, or its other end is not reached.
float fall_along(ivec2 at, float time, ivec2 step) {
    float size = edge_length(point_at(at), step);
    float other = time_at(at + step);
    return size > 0.0 && size < FAR && other < FAR ? (time - other) / size : -FAR;
}

// Returns the copy of a pole from which the time falls most steeply along an edge.
ivec2 steepest_copy(ivec2 members) {
    int first = members_in_list() + members.x;
    int end = members_in_list() + members.y;
    ivec2 steepest = member(members.x);
    float time = time_at(steepest);
    float most = -FAR;
    for (int i = first; i < end; i++) {
        ivec2 at = from_row_major(listed(i), grid.x);
        float along_rows = max(fall_along(at, time, ALONG_LINES[0]), fall_along(at, time, ALONG_LINES[2]));
        float along_cols = max(fall_along(at, time, ALONG_LINES[1]), fall_along(at, time, ALONG_LINES[3]));
        float fall = max(along_rows, along_cols);
        if (fall > most) {
            most = fall;
            steepest = at;
        }
    }
    return steepest;
}

// Returns which end of an edge has fewer copies: 0 for the first end, 1 for the other.
int rarer_end(ivec2 first, ivec2 along) {
    ivec2 members = copies_of(first);
    ivec2 others = copies_of(first + along);
    return others.y - others.x < members.y - members.x ? 1 : 0;
}

// Returns a place, as a grid point if it lies on an edge between copies of one point, such as a pole.
Place as_one_point(Place place) {
    if (SEAMS == 0 || is_point(place) || (place.share.x > 0.0 && place.share.y > 0.0)) return place;
    ivec2 members = copies_of(place.first);
    ivec2 others = copies_of(place.first + ivec2(greaterThan(place.share, vec2(0.0))));
    if (members.x < members.y && members == others) place.share = vec2(0.0);
    return place;
}

// Returns the number of places that copy_at() may find: the place itself and its possible copies.
int most_copies(Place place) {
    if (SEAMS == 0 || (place.share.x > 0.0 && place.share.y > 0.0)) return 1;
    ivec2 members = copies_of(place.first);
    int copies = members.y - members.x;
    if (is_point(place)) {
        if (copies <= MOST_COPIES) return 1 + copies;
        return PASSES_POLES ? 2 : 1;
    }
    ivec2 others = copies_of(place.first + ivec2(greaterThan(place.share, vec2(0.0))));
    int rarer = min(copies, others.y - others.x);
    // An edge between copies of one point has no length, and an edge between two poles is a whole meridian. Copies of
    // such edges are not searched.
    if (max(copies, others.y - others.x) == 0 || members == others || rarer > MOST_COPIES) return 1;
    return 1 + 4 * max(rarer, 1);
}

// Finds a copy of a place by its number. Number 0 is the place itself. Returns false if there is no copy with this
// number.
bool copy_at(Place place, int number, out Place copy) {
    copy = place;
    if (SEAMS == 0 || number == 0) return true;
    if (is_point(place)) {
        ivec2 members = copies_of(place.first);
        bool is_pole = members.y - members.x > MOST_COPIES;
        copy.first = is_pole ? steepest_copy(members) : member(members.x + number - 1);
        return copy.first != place.first;
    }
    // A copy of an edge joins neighbouring copies of its two ends. An end without copies stands for itself.
    ivec2 along = ivec2(greaterThan(place.share, vec2(0.0)));
    int end = rarer_end(place.first, along);
    ivec2 from = place.first + end * along;
    ivec2 to = place.first + (1 - end) * along;
    ivec2 members = copies_of(from);
    ivec2 step = ALONG_LINES[(number - 1) % 4];
    ivec2 first = members.x < members.y ? member(members.x + (number - 1) / 4) : from;
    ivec2 last = first + step;
    if (!in_grid(last, grid) || (first == from && last == to) || first_copy(last) != first_copy(to)) return false;
    // The share of the copy along its edge, counted from the end with the smaller column or row.
    float share = max(place.share.x, place.share.y);
    if ((end == 1) != (step.x + step.y < 0)) share = 1.0 - share;
    ivec2 low = min(first, last);
    // A share close to 1 may be rounded to 1.
    copy.first = share == 1.0 ? max(first, last) : low;
    copy.share = share == 1.0 ? vec2(0.0) : share * vec2(abs(step));
    return true;
}
