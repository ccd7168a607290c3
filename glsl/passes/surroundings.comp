// Solves a map of the texels around the cell of a source, as seed.comp reads it. All points are updated from their
// eight triangles until nothing changes, or for SURROUNDINGS_STEPS steps. One workgroup is one source. One invocation
// is one texel.
//
// This pass is for sources inside cells. Near such a source many rays cross a base whose two ends are reached in
// different scans. Scans of the whole grid would then advance by about one cell an iteration.
//
// Where cells may be skewed, it is for sources at grid points too.
//
// It is also for point sources with others near them, including those at grid points. Each source is solved alone,
// since an update would take the fronts of two sources for a single front, which would arrive too early. The times of
// such a source are marked exact where no front from outside its window can be earlier. Where surroundings meet,
// merge_surroundings.comp takes the earliest fronts.
// Twin: crates/cpu/src/twins/surroundings.rs.

#include "update/wavefront.glsl"
#include "shared/surface_image.glsl"
#include "shared/seed_texel.glsl"

layout(local_size_x = SURROUNDINGS_WORKGROUP) in;

layout(set = 0, binding = 2, rgba32f) uniform readonly restrict image2DArray fronts;
layout(set = 0, binding = 3) writeonly restrict buffer Seeds {
    SeedTexel seeds[];
};

layout(push_constant) uniform Portion {
    ivec2 grid;     // columns and rows of the whole grid
    int first_word; // offset of the first source
    uint is_glued;  // whether fronts may leave the grid through its sides and come back
};

#include "update/source_arrival.glsl"

// The window holds the points of the texels and a ring of points around them. The points of the ring are read, but stay
// unreached: scans of the whole grid find the ways outside the window. If sources are added to a map, this pass may
// drop fronts of the map that came from outside the window. They stay in the images, since seed.comp writes no later
// front.
const int TEXELS = SURROUNDINGS_TEXELS;
#include "passes/window.glsl"

shared vec4 lengths[AREA];
shared float surface[CARRIES ? AREA : 1];
shared float slowness[SLOWED != 0 ? AREA : 1];
shared float times[AREA];
shared float carried[CARRIES ? AREA : 1];
// Whether a front has changed in an even step, and in an odd one.
shared uint moved[2];
// Time from the source's start until its front first leaves the window, as the bits of a float.
shared uint leaves;

// Returns the indices of the four points of the texel whose first point is at `at`.
ivec4 spots(ivec2 at) {
    return corners_row_major(at, SIDE);
}

// Returns the fronts, surface values and slowness at the four points of the texel whose first point is at
// `at`.
EndFronts ends_at(ivec2 at) {
    ivec4 s = spots(at);
    EndFronts ends = EndFronts(vec4(times[s.x], times[s.y], times[s.z], times[s.w]), vec4(0.0), vec4(0.0), vec4(0.0));
    if (SLOWED != 0) ends.slowness = vec4(slowness[s.x], slowness[s.y], slowness[s.z], slowness[s.w]);
    if (CARRIES) {
        ends.carried = vec4(carried[s.x], carried[s.y], carried[s.z], carried[s.w]);
        ends.surface = vec4(surface[s.x], surface[s.y], surface[s.z], surface[s.w]);
    }
    return ends;
}

// Returns the lengths of the edges that lead along `step` from the four points of the texel at `at`.
vec4 edge_lengths(ivec2 at, ivec2 step) {
    bool here = stored_here(step);
    ivec4 s = spots(here ? at : at + step);
    ivec2 way = here ? step : -step;
    return vec4(stored_length(lengths[s.x], way), stored_length(lengths[s.y], way),
                stored_length(lengths[s.z], way), stored_length(lengths[s.w], way));
}

// The first of the points in shared memory, as a point of the images.
ivec2 window;

// Returns the front at a point. Outside the window, none has arrived.
vec2 front_at(ivec2 point) {
    ivec2 at = point - window;
    if (!in_grid(at, ivec2(SIDE))) return vec2(FAR, 0.0);
    int i = spot(at);
    return vec2(times[i], carried[CARRIES ? i : 0]);
}

#include "update/splits.glsl"
#include "passes/chart_lines.glsl"

// Updates the texel whose first point is at `at` through the two triangles of each scan.
void update_texel(ivec2 at, inout vec4 time, inout vec4 held) {
    vec4 own = ends_at(at).surface;
    vec4 own_slowness = ends_at(at).slowness;
    Fronts fronts;
    // This is a loop, since drivers are slow to compile the same code several times.
    for (int triangle = 0; triangle < 8; triangle++) {
        int scan = triangle / 2;
        ivec2 ahead = ahead_of(scan);
        ivec2 along = along_of(scan);
        ivec2 first = -ahead + ((triangle & 1) - 1) * along;
        ivec2 second = first + along;
        bvec4 alone = are_alone(edge_lengths(at, -ahead));
        vec4 l1 = edge_lengths(at, first);
        vec4 l2 = edge_lengths(at, second);
        vec4 base = edge_lengths(at + first, along);
        EndFronts end1 = ends_at(at + first);
        EndFronts end2 = ends_at(at + second);
        bvec4 obtuse = are_obtuse_at_x0(end1, end2, own_slowness, l1, l2, base);
        Fronts through = update(end1, end2, own, own_slowness, l1, l2, bases_of_acute(obtuse, base), alone);
        bvec4 none = bvec4(false);
        bool is_left = (triangle & 1) == 0;
        Places four = Places(window + at, ivec2(1, 0), ivec2(0, 1), ahead, along);
        add_parts(four, is_left ? obtuse : none, is_left ? none : obtuse, through);
        if (is_left) {
            fronts = through;
        } else {
            accept(earlier(fronts, through), uint(scan) + 1u, true, time, held);
        }
    }
}

bool is_inside_cell(Source s) {
    return place_of(s) != floor(place_of(s));
}

// Returns the first texel of a source's window.
ivec2 first_texel(Source s) {
    return texel_of(point_at(ivec2(place_of(s)))) - (TEXELS / 2 - 1);
}

bool is_point(Source s) {
    return s.curvature == SOURCE_CURVATURE;
}

// Returns whether other sources lie within TEXELS rows and columns of grid points of a point source, and all of these
// are point sources. The result matters to curved fronts only, and is false for others.
bool is_crowded(Source own) {
    if (!HAS_CURVATURE || !is_point(own)) return false;
    bool found = false;
    for (int i = 0; i < int(gl_NumWorkGroups.x); i++) {
        Source other = source(i);
        vec2 apart = abs(place_of(other) - place_of(own));
        if (!counts(other) || apart == vec2(0.0) || any(greaterThan(apart, vec2(TEXELS)))) continue;
        if (!is_point(other)) return false;
        found = true;
    }
    return found;
}

// Returns the start time of the earliest source.
float first_start() {
    float first = FAR;
    for (int i = 0; i < int(gl_NumWorkGroups.x); i++) {
        Source other = source(i);
        if (counts(other)) first = min(first, other.time);
    }
    return first;
}

// Computes a source's own fronts at the points of a texel.
void take_own(Source own, ivec2 texel, out vec4 time, out vec4 held) {
    for (int j = 0; j < 4; j++) {
        vec2 front = arrival(own, at_point(first_point(texel) + to_corner(j)));
        time[j] = front.x;
        held[j] = with_tag(front.y, SOURCE_TAG);
    }
}

// Returns whether the grid continues beyond a texel of the window, or fronts may leave through a side of the grid
// there.
bool is_at_way_out(ivec2 in_window, ivec2 inner, ivec2 texels) {
    if (is_glued != 0u && !in_grid(inner - 1, texels - 2)) return true;
    bvec2 low = bvec2(uvec2(equal(in_window, ivec2(0))) & uvec2(greaterThan(inner, ivec2(0))));
    bvec2 high = bvec2(uvec2(equal(in_window, ivec2(TEXELS - 1))) & uvec2(lessThan(inner, texels - 1)));
    return any(low) || any(high);
}

void main() {
    int number = int(gl_WorkGroupID.x);
    int index = int(gl_LocalInvocationIndex);
    bool is_there = index < OWN_TEXELS;
    int seed = number * OWN_TEXELS + index;
    if (is_there) {
        seeds[seed].texel = ivec2(-1);
        seeds[seed].window = ivec2(NO_WINDOW);
    }
    Source own = source(number);
    if (!counts(own)) return;
    bool crowded = is_crowded(own);
    // In skewed cells, fronts that arrive in the order of time are late beside a source at a grid point too.
    bool bends = is_inside_cell(own) || SPLITS > SPLIT_REACH;
    if (!crowded && !bends) return;

    ivec2 in_window = from_row_major(index, TEXELS);
    ivec2 first = first_texel(own);
    if (is_there) seeds[seed].window = first;
    if (index == 0) {
        leaves = floatBitsToUint(FAR);
        skew_around = 1;
    }
    window = window_at(first);
    ivec2 texel = first + in_window;
    ivec2 texels = texels_of(grid);
    is_there = is_there && in_grid(without_border(texel), texels);
    for (int i = index; i < AREA; i += SURROUNDINGS_WORKGROUP) {
        ivec2 point = clamp(window + from_row_major(i, SIDE), ivec2(0), last_point(texels));
        lengths[i] = imageLoad(edges, point);
        times[i] = FAR;
        if (CARRIES) {
            surface[i] = surface_at(point);
            carried[i] = 0.0;
        }
        if (SLOWED != 0) slowness[i] = slowness_at(point);
    }
    barrier();
    ivec2 at = first_in_window(in_window);
    ivec4 s = spots(at);
    vec4 time_before = vec4(FAR);
    vec4 held_before = vec4(0.0);
    if (is_there && crowded) {
        take_own(own, texel, time_before, held_before);
    } else if (is_there) {
        time_before = imageLoad(fronts, ivec3(texel, TIME));
        if (CARRIES) held_before = imageLoad(fronts, ivec3(texel, CARRIED));
    }
    if ((SPLITS != 0 || SLOWED != 0) && is_point(own) && bends) {
        vec2 place = place_of(own) - vec2(at_point(window));
        find_skew(index, place);
        barrier();
        if (is_there && (skew_around > 1 || SLOWED != 0)) add_lines(own, place, at, time_before, held_before);
    }
    vec4 time = time_before;
    vec4 held = held_before;
    uint change = is_there ? 1u : 0u;
    for (int step = 0; step < SURROUNDINGS_STEPS; step++) {
        if (is_there) {
            for (int j = 0; j < 4; j++) {
                times[s[j]] = time[j];
                if (CARRIES) carried[s[j]] = held[j];
            }
        }
        if (change > 0u) atomicOr(moved[step & 1], 1u);
        barrier();
        if (moved[step & 1] == 0u) break;
        change = 0u;
        if (is_there) {
            vec4 old = time;
            vec4 old_held = held;
            update_texel(at, time, held);
            change = change_of(old, time, old_held, held);
        }
        if (index == 0) moved[(step + 1) & 1] = 0u;
        barrier();
    }
    if (crowded) {
        if (is_there && is_at_way_out(in_window, without_border(texel), texels)) {
            float soonest = min(min(time.x, time.y), min(time.z, time.w));
            atomicMin(leaves, floatBitsToUint(max(soonest - own.time, 0.0)));
        }
        barrier();
        // A front from outside enters through the window's border, and not before the first source starts. It then
        // takes at least as long to a point as this source's front takes from that point to the border. So this
        // source's front is first up to the mean of two times: the time at which it leaves the window, and the start of
        // the first source.
        float until = own.time + uintBitsToFloat(leaves);
        bvec4 exact = lessThanEqual(time, vec4(until < FAR ? 0.5 * (until + first_start()) : FAR));
        held = with_tags(held, mix(uvec4(NOT_EXACT | WHOLE), uvec4(EXACT | WHOLE), exact));
    }
    if (!is_there) return;
    seeds[seed].texel = texel;
    seeds[seed].times = time;
    seeds[seed].curvatures = held;
}
