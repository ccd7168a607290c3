// The layers of a batch in the images of fronts: arrival times of all maps, then what the
// fronts of all carry beside.

// Maps of a batch, at most.
layout(constant_id = 6) const int MAPS = 1;

int layer_of(uint map, int layer) {
    return layer * MAPS + int(map);
}
