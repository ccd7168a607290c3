// Stores the state of paths, for path_starts.comp, paths.comp and path_slides.glsl. Between the records and the
// vertices lie the starts (row and column), and then the states.

layout(push_constant) uniform Batch {
    ivec2 grid;       // columns and rows of the whole grid
    int paths;        // number of paths that have a start
    int records;      // number of records
    int first_vertex; // index of the word at which the vertices begin
    int capacity;     // largest number of vertices of a path
    int first_word;   // offset of the first source
    int count;        // number of sources
    int slowed;       // 1 if lengths are weighted by a slowness
    int halvings;     // number of times that moves of sliding vertices have been halved
};

#include "shared/times.glsl"
#include "shared/curve.glsl"
#include "shared/source.glsl"
#include "passes/path_places.glsl"

// Returns the column and row at which a path starts.
vec2 start_of(int path) {
    int at = records * CURVE_WORDS + 2 * path;
    return vec2(uintBitsToFloat(curves[at + 1]), uintBitsToFloat(curves[at]));
}

// Writes one more vertex. Returns false if there is no room.
bool add(int number, inout Path path, vec2 at, float time) {
    if (path.vertices >= uint(capacity)) {
        path.status = OUT_OF_ROOM;
        return false;
    }
    int vertex = number * capacity + int(path.vertices);
    write_vertex(first_vertex + VERTEX_WORDS * vertex, at, time);
    path.vertices += 1u;
    path.last = at;
    return true;
}

// Puts a path back to its start.
void begin(int number, inout Path path, float start) {
    path.vertices = 0u;
    path.status = UNDER_WAY;
    path.source = -1;
    path.size = 0.0;
    vec2 at = start_of(number);
    path.place = place_from(at);
    bool is_known = is_point(path.place);
    // Between grid points, the earliest time of the corners serves as the base time.
    path.base_time = time_at(path.place.first);
    for (int i = 0; i < 4 && !is_known; i++) {
        path.base_time = min(path.base_time, time_at(path.place.first + to_corner(i)));
    }
    path.below = is_known ? 0.0 : UNKNOWN;
    path.time = is_known ? path.base_time : UNKNOWN;
    path.lowest = FAR;
    path.from = NO_CELL;
    path.zero_time = start;
    add(number, path, at, path.time);
}

// Writes the record and the state of a path.
void save(int number, Path path) {
    uint drawn = path.status == COMPLETE ? path.vertices : 0u;
    write_record(number, drawn, uint(number * capacity), path.vertices, path.status);
    int record = number * CURVE_WORDS;
    curves[record + 6] = uint(path.source);
    curves[record + 7] = floatBitsToUint(path.time);
    curves[record + 8] = floatBitsToUint(path.size);
    int at = records * (CURVE_WORDS + 2) + number * PATH_WORDS;
    curves[at] = uint(path.place.first.x);
    curves[at + 1] = uint(path.place.first.y);
    curves[at + 2] = floatBitsToUint(path.place.share.x);
    curves[at + 3] = floatBitsToUint(path.place.share.y);
    curves[at + 4] = floatBitsToUint(path.below);
    curves[at + 5] = floatBitsToUint(path.base_time);
    curves[at + 6] = floatBitsToUint(path.lowest);
    curves[at + 7] = uint(path.from.x);
    curves[at + 8] = uint(path.from.y);
    curves[at + 9] = floatBitsToUint(path.last.x);
    curves[at + 10] = floatBitsToUint(path.last.y);
    curves[at + 11] = floatBitsToUint(path.zero_time);
    curves[at + 12] = floatBitsToUint(path.earliest);
    curves[at + 13] = floatBitsToUint(path.latest);
    curves[at + 14] = uint(path.own);
}

// Reads the record and the state of a path.
Path load(int number) {
    Path path;
    int record = number * CURVE_WORDS;
    path.vertices = curves[record + 4];
    path.status = curves[record + 5];
    path.source = int(curves[record + 6]);
    path.time = uintBitsToFloat(curves[record + 7]);
    path.size = uintBitsToFloat(curves[record + 8]);
    int at = records * (CURVE_WORDS + 2) + number * PATH_WORDS;
    path.place.first = ivec2(curves[at], curves[at + 1]);
    path.place.share = vec2(uintBitsToFloat(curves[at + 2]), uintBitsToFloat(curves[at + 3]));
    path.below = uintBitsToFloat(curves[at + 4]);
    path.base_time = uintBitsToFloat(curves[at + 5]);
    path.lowest = uintBitsToFloat(curves[at + 6]);
    path.from = ivec2(curves[at + 7], curves[at + 8]);
    path.last = vec2(uintBitsToFloat(curves[at + 9]), uintBitsToFloat(curves[at + 10]));
    path.zero_time = uintBitsToFloat(curves[at + 11]);
    path.earliest = uintBitsToFloat(curves[at + 12]);
    path.latest = uintBitsToFloat(curves[at + 13]);
    path.own = int(curves[at + 14]);
    return path;
}
