// The first fronts at the points of a texel, as seed.comp reads them.
struct SeedTexel {
    ivec2 texel; // a negative column means that this entry is not used
    ivec2 window; // first texel of the surroundings that the texel belongs to, if any
    vec4 times;
    vec4 curvatures;
};
