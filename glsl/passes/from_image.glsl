// Reads the components of the host's points from an image. Include after points.glsl or lift.glsl.

layout(set = 1, binding = 2) uniform texture2D image;

// Returns NaN beyond the edges of an image that is too small, so that the point counts as missing.
float component(ivec2 at, int index) {
    bool is_there = in_grid(at, textureSize(image, 0));
    return is_there ? texelFetch(image, at, 0)[index] : uintBitsToFloat(0x7fc00000u);
}
