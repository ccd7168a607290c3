// The first fronts at the points of a texel, as seed.comp reads them.
struct SeedTexel {
    ivec2 texel; // negative column: there are none
    ivec2 window; // first texel of the surroundings that it belongs to, if any
    vec4 times;
    vec4 curvatures;
};
