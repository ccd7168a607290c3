// Computes the direction in which the way back leaves each grid point, as a unit vector in columns and rows.
// Copies of a point of a glued surface have the same direction, each in the columns and rows of its own side, except at
// poles and at the corners of octahedral maps. One invocation is one point.
// Twin: src/geometry/directions, in double precision.

#include "shared/edge_image.glsl"
#include "shared/cell.glsl"
#include "shared/times.glsl"
#include "shared/start.glsl"
#include "passes/path_cell.glsl"
#include "passes/path_profile.glsl"
#include "passes/path_places.glsl"
#include "passes/local_metric.glsl"

layout(local_size_x = WORKGROUP) in;

#include "passes/ways.glsl"
#include "shared/source.glsl"
#include "shared/seams.glsl"
#include "shared/lattice.glsl"
#include "passes/over_seams.glsl"
// At a pole, columns and rows have no common plane. So a way that leaves from another copy would be of no use.
const bool PASSES_POLES = false;
#include "passes/path_copies.glsl"
#include "passes/step_over_seams.glsl"
#include "passes/path_line.glsl"
#include "passes/way.glsl"

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (is_beyond(at, grid)) return;
    vec2 way = is_reached(time_at(at)) ? way_from(at) : vec2(0.0);
    ways[word_of(1, index_of(at))] = packHalf2x16(way);
}
