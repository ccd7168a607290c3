// Runs iterations of four rotated scans on maps that lie in shared memory. One workgroup is one source. One
// invocation handles some pairs of neighbouring points of each line. A map that is not done after the largest
// number of iterations is stored, and continues in the next dispatch.
// Twin: scan_outward in crates/cpu/src/twins/scan.rs.

#include "passes/pairwise_progress.glsl"
#include "passes/pairwise_fans.glsl"
#include "passes/count.glsl"
#include "shared/distance.glsl"

layout(local_size_x_id = 3) in;

// Number of points that fit into shared memory: rows times pitch, or more.
layout(constant_id = 15) const int ROOM = 1;
// Size of the maps, if the pipeline is for a single size. Otherwise these are 0, and the size is a push
// constant. Loops with known bounds are 6 to 9 % faster on CPUs. Drivers for GPUs take seconds to compile
// them.
layout(constant_id = 4) const int ITERATIONS = 0;
layout(constant_id = 7) const int ROWS = 0;
layout(constant_id = 8) const int COLS = 0;
layout(constant_id = 9) const int PITCH = 0;

layout(push_constant) uniform Size {
    ivec2 grid;     // columns and rows
    int pitch;      // distance from a point to the one below it. It is odd if there is room, so that the
                    // points of a column lie in different banks of shared memory
    int iterations; // largest number of iterations in a dispatch
} size;

ivec2 grid() {
    return ROWS > 0 ? ivec2(COLS, ROWS) : size.grid;
}

int pitch() {
    return PITCH > 0 ? PITCH : size.pitch;
}

int most_iterations() {
    return ITERATIONS > 0 ? ITERATIONS : size.iterations;
}

layout(set = 0, binding = 3) readonly restrict buffer Fans {
    float fans[];
};
layout(set = 2, binding = 2) writeonly restrict buffer Distances {
    uint distances[]; // as in distance.glsl, one row per map
};
layout(set = 2, binding = 1) restrict buffer Kept {
    float kept[]; // the fronts of maps that are not done
};

const int INVOCATIONS = int(gl_WorkGroupSize.x);

// Arrival times, followed by the values that fronts carry.
shared float fronts[CARRIES ? 2 * ROOM : ROOM];

// Returns the size of a layer of a map, in numbers.
int area() {
    return grid().y * pitch();
}

// Returns where a layer of a map is stored between dispatches.
int kept_place(uint map, int layer) {
    return (int(map) * (CARRIES ? 2 : 1) + layer) * area();
}

vec4 at_four(int places[4], int layer) {
    return vec4(fronts[layer + places[0]], fronts[layer + places[1]],
                fronts[layer + places[2]], fronts[layer + places[3]]);
}

// Reads one of the numbers of a pair.
#define NUMBER(k) fans[first + (k) * pairs]

// Updates a pair of points from the line behind. Returns how much they have changed.
uint pass_pair(int scan, int line, int behind, int pair, int points, bool may_renew) {
    int pairs = pairs_of(points);
    int across = stride_ahead(scan, pitch());
    int step = stride_along(scan, pitch());
    int first = fan_place(grid(), scan, line, pair, pairs);
    // No edge leads beyond the ends of a line. The point at an end stands in for the points beyond it.
    int places[4];
    for (int i = 0; i < 4; i++) {
        places[i] = behind * across + point_in_line(2 * pair + i - 1, points) * step;
    }
    int a = line * across + 2 * pair * step;
    bool has_b = 2 * pair + 1 < points;
    int b = has_b ? a + step : a;

    EndFronts ends = EndFronts(at_four(places, 0), vec4(0.0), vec4(0.0), vec4(0.0));
    vec4 old_carried = vec4(0.0);
    vec2 surface = vec2(0.0);
    if (CARRIES) {
        ends.carried = at_four(places, ROOM);
        ends.surface = vec4(NUMBER(9), NUMBER(10), NUMBER(11), NUMBER(12));
        surface = vec2(NUMBER(13), NUMBER(14));
        old_carried = vec2(fronts[ROOM + a], fronts[ROOM + b]).xyxy;
    }
    vec4 old_time = vec2(fronts[a], fronts[b]).xyxy;

    // Left triangles in xy, right triangles in zw.
    vec4 l1 = vec4(NUMBER(0), NUMBER(3), NUMBER(1), NUMBER(4));
    vec4 l2 = vec4(l1.zw, NUMBER(2), NUMBER(5));
    vec4 base = vec4(NUMBER(6), NUMBER(7), NUMBER(7), NUMBER(8));
    vec4 time = old_time;
    vec4 carried = old_carried;
    accept(update_pair(ends, surface, vec2(0.0), l1, l2, base), uint(scan) + 1u, may_renew, time, carried);
    if (!has_b) {
        time.yw = old_time.yw;
        carried.yw = old_carried.yw;
    }
    fronts[a] = time.x;
    if (has_b) fronts[b] = time.y;
    if (CARRIES) {
        fronts[ROOM + a] = carried.x;
        if (has_b) fronts[ROOM + b] = carried.y;
    }
    return change_of(old_time.xyxy, time.xyxy, old_carried.xyxy, carried.xyxy);
}

// Initializes a map: only its source is reached.
void start(ivec2 source) {
    for (int i = int(gl_LocalInvocationIndex); i < area(); i += INVOCATIONS) {
        fronts[i] = FAR;
        if (CARRIES) fronts[ROOM + i] = 0.0;
    }
    barrier();
    if (gl_LocalInvocationIndex == 0u) {
        int place = row_major(source, pitch());
        fronts[place] = 0.0;
        if (CARRIES) fronts[ROOM + place] = with_tag(SOURCE_CURVATURE, SOURCE_TAG);
    }
}

void main() {
    uint map = gl_WorkGroupID.x;
    if (maps[map].done != 0u) return;
    int lane = int(gl_LocalInvocationIndex);
    ivec2 source = source_of(map);
    uint renews = maps[map].renews;
    uint iterations = maps[map].iterations;
    uint since_reached = maps[map].since_reached;
    uint last_residual = 0u;
    bool is_done = false;
    if (iterations == 0u) {
        start(source);
    } else {
        for (int i = lane; i < area(); i += INVOCATIONS) {
            fronts[i] = kept[kept_place(map, 0) + i];
            if (CARRIES) fronts[ROOM + i] = kept[kept_place(map, 1) + i];
        }
    }
    barrier();

    for (int n = 0; n < most_iterations(); n++) {
        uint change = 0u;
        for (int scan = 0; scan < 4; scan++) {
            int lines = lines_of(grid(), scan);
            int points = points_of_line(grid(), scan);
            bool forward = (scan & 1) == 0;
            int source_line = line_of(source, scan);
            // No line lies behind the first one. The first iteration leads away from the source.
            int start = iterations > 0u ? 1 : forward ? source_line + 1 : lines - source_line;
            for (int passed = start; passed < lines; passed++) {
                int line = forward ? passed : lines - 1 - passed;
                int behind = forward ? line - 1 : line + 1;
                for (int pair = lane; 2 * pair < points; pair += INVOCATIONS) {
                    change = max(change,
                                 pass_pair(scan, line, behind, pair, points, renews != 0u));
                }
                barrier();
            }
        }
        // Two counters take turns in gathering the largest change. The one cleared here was last read before
        // the first barrier of this iteration.
        if ((iterations & 1u) == 0u) {
            if (change > 0u) atomicMax(maps[map].residual, change);
            if (lane == 0) atomicExchange(maps[map].next_residual, 0u);
        } else {
            if (change > 0u) atomicMax(maps[map].next_residual, change);
            if (lane == 0) atomicExchange(maps[map].residual, 0u);
        }
        memoryBarrierBuffer();
        barrier();
        last_residual = (iterations & 1u) == 0u ? atomicOr(maps[map].residual, 0u)
                                                : atomicOr(maps[map].next_residual, 0u);
        is_done = count_iteration(last_residual, tolerance, most, iterations, since_reached, renews);
        if (is_done) break;
    }

    if (is_done) {
        int points = grid().x * grid().y;
        for (int i = lane; i < points; i += INVOCATIONS) {
            float time = fronts[row_major(from_row_major(i, grid().x), pitch())];
            distances[int(map) * points + i] = distance_bits(time);
        }
    } else {
        for (int i = lane; i < area(); i += INVOCATIONS) {
            kept[kept_place(map, 0) + i] = fronts[i];
            if (CARRIES) kept[kept_place(map, 1) + i] = fronts[ROOM + i];
        }
    }
    if (lane == 0) {
        maps[map].renews = renews;
        maps[map].iterations = iterations;
        maps[map].since_reached = since_reached;
        maps[map].last_residual = last_residual;
        maps[map].done = is_done ? 1u : 0u;
        if (is_done) atomicAdd(pending, ~0u);
    }
}
