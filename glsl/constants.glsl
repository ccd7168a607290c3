// Constants shared with Rust: build.rs turns each #define below into a Rust constant.

// Stands for "not reached" and "no such edge": large, finite, and its sums stay finite.
#define FAR 1e30
// Curvature of a front at a point source: stands for infinity in the same way.
#define SOURCE_CURVATURE 1e18
// Invocations of a workgroup; 128 is the most that every Vulkan device offers, and a row or
// column of texels is the whole dispatch, so small groups fill a device sooner.
#define WORKGROUP 64
// Texels around the grid's own in every image, so that no neighbour needs a bounds test.
#define BORDER 1
