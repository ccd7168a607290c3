// The first fronts of a texel's points, as seed.comp takes them.
struct SeedTexel {
    ivec2 texel; // its column is negative if there are none
    ivec2 unused; // vec4 follows on a multiple of 16 bytes
    vec4 times;
    vec4 curvatures;
};
