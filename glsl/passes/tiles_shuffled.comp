// Runs one round of tiles with one point of a line for each invocation, on a device whose compute shaders can shift
// values between the invocations of a subgroup.

#define WITH_POINTS
#define WITH_SHUFFLES
#include "passes/tile_round.glsl"
