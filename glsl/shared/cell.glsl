// Returns the bilinear weights of a cell's corners at a place. `uv` is the offset of the place from the first
// corner, in columns and rows.
vec4 bilinear(vec2 uv) {
    vec2 not_uv = 1.0 - uv;
    return vec4(not_uv.x * not_uv.y, uv.x * not_uv.y, not_uv.x * uv.y, uv.x * uv.y);
}

// Computes the weights of a cell's corners at a place, where some corners may be missing. The order is
// north-west, north-east, south-west, south-east. `uv` is the offset of the place from the first corner, in
// columns and rows. Returns false if the place lies in a hole.
// Twin: corner_weights() in crates/surface/src/chart, where the weights are explained.
bool corner_weights(bvec4 there, vec2 uv, out vec4 weights) {
    vec2 not_uv = 1.0 - uv;
    weights = bilinear(uv);
    int missing = 0;
    int hole = 0;
    for (int i = 0; i < 4; i++) {
        if (!there[i]) {
            missing += 1;
            hole = i;
        }
    }
    if (missing == 1) {
        float v = hole < 2 ? uv.y : not_uv.y;
        float u = (hole & 1) == 0 ? uv.x : not_uv.x;
        weights[hole ^ 1] = 1.0 - v;
        weights[hole ^ 2] = 1.0 - u;
        weights[hole ^ 3] = v + u - 1.0;
        weights[hole] = 0.0;
    }
    bool usable = true;
    for (int i = 0; i < 4; i++) {
        if (abs(weights[i]) < 1e-6) weights[i] = 0.0;
        usable = usable && (weights[i] == 0.0 || (weights[i] > 0.0 && there[i]));
    }
    return usable;
}
