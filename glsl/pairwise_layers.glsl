// The layers of a batch in the images of fronts: of each map its arrival times, then what its fronts carry
// beside. Include after wavefront.glsl.

const int LAYERS_OF_MAP = CARRIES ? LAYERS : 1;

int layer_of(uint map, int layer) {
    return int(map) * LAYERS_OF_MAP + layer;
}
