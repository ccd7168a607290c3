// Reads and writes the fronts of a texel in the two images of a map.

#include "update/wavefront.glsl"

layout(set = 0, binding = 2, rgba32f) uniform restrict image2DArray fronts_1;
layout(set = 2, binding = 0, rgba32f) uniform restrict image2DArray fronts_0;

void load_fronts(bool from_1, ivec2 texel, out vec4 time, out vec4 held) {
    held = vec4(0.0);
    if (from_1) {
        time = imageLoad(fronts_1, ivec3(texel, TIME));
        if (CARRIES) held = imageLoad(fronts_1, ivec3(texel, CARRIED));
    } else {
        time = imageLoad(fronts_0, ivec3(texel, TIME));
        if (CARRIES) held = imageLoad(fronts_0, ivec3(texel, CARRIED));
    }
}

void store_fronts(bool to_1, ivec2 texel, vec4 time, vec4 held) {
    if (to_1) {
        imageStore(fronts_1, ivec3(texel, TIME), time);
        if (CARRIES) imageStore(fronts_1, ivec3(texel, CARRIED), held);
    } else {
        imageStore(fronts_0, ivec3(texel, TIME), time);
        if (CARRIES) imageStore(fronts_0, ivec3(texel, CARRIED), held);
    }
}
