// Numbers the layers of a batch in the images of fronts. Each map has a layer of arrival times. If fronts
// carry a value, a layer of the carried values follows.

#include "update/wavefront.glsl"

const int LAYERS_OF_MAP = CARRIES ? LAYERS : 1;

int layer_of(uint map, int layer) {
    return int(map) * LAYERS_OF_MAP + layer;
}
