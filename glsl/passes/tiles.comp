// Runs one round of tiles with two points of a line for each invocation.

#include "passes/tile_round.glsl"
