// Runs one round of tiles with one point of a line for each invocation.

#define WITH_POINTS
#include "passes/tile_round.glsl"
