// The first fronts of a texel's points, as seed.comp takes them.
struct SeedTexel {
    ivec2 texel; // its column is negative if there are none
    ivec2 window; // the first texel of the surroundings that it belongs to, if it belongs to any
    vec4 times;
    vec4 curvatures;
};
