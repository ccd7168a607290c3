// Reads the lengths of edges in and around a tile: from shared memory where there is room, and from their
// image otherwise. Included by tile_round.glsl.

// Whether the lengths are copied to shared memory.
layout(constant_id = 15) const int EDGES_SHARED = 1;

// Edge lengths at all points of the window: first all edges to one neighbour, then all edges to the next, for the four
// neighbours whose edges are stored. Neighbouring invocations thus read neighbouring words.
shared float lengths[EDGES_SHARED != 0 ? 4 * AREA : 1];

// First point of the window, as a point of the images.
ivec2 window;

vec4 lengths_in_image(ivec2 at) {
    return imageLoad(edges, min(window + at, last_point(texels)));
}

void load_edges() {
    if (EDGES_SHARED == 0) return;
    for (uint i = gl_LocalInvocationIndex; i < AREA; i += INVOCATIONS) {
        vec4 all = lengths_in_image(from_row_major(int(i), SIDE));
        for (int j = 0; j < 4; j++) lengths[j * AREA + i] = all[j];
    }
}

// Returns the length of an edge from a point of the window.
float edge_in_tile(ivec2 at, ivec2 step) {
    bool here = stored_here(step);
    ivec2 from = here ? at : at + step;
    ivec2 stored = here ? step : -step;
    if (EDGES_SHARED == 0) return stored_length(lengths_in_image(from), stored);
    return lengths[component_stored(stored) * AREA + spot(from)];
}

// Lengths that an update of a point x0 needs: of the edges from x0 to the three points behind, and of the bases of both
// triangles.
struct Edges {
    float left, middle, right;
    float base_left, base_right;
};

// Edge lengths as the image stores them: at a point, and at the points diagonally behind it, before and after it along
// the line.
struct StoredLengths {
    vec4 here, before, after;
};

// Returns the stored lengths that edges_of() needs at a point. Scans read them two lines ahead, since such a read takes
// longer than a line.
StoredLengths lengths_around(ivec2 at, ivec2 ahead, ivec2 along) {
    if (EDGES_SHARED != 0) return StoredLengths(vec4(0.0), vec4(0.0), vec4(0.0));
    return StoredLengths(lengths_in_image(at), lengths_in_image(at - ahead - along), lengths_in_image(at - ahead + along));
}

// Returns the edges of a point. `all` has the lengths stored around it. `behind` has the lengths stored at the point
// behind. For the next line, `behind` receives the lengths stored at this point.
Edges edges_of(ivec2 at, ivec2 ahead, ivec2 along, StoredLengths all, inout vec4 behind) {
    if (EDGES_SHARED != 0) {
        return Edges(edge_in_tile(at, -ahead - along), edge_in_tile(at, -ahead), edge_in_tile(at, along - ahead),
                     edge_in_tile(at - ahead - along, along), edge_in_tile(at - ahead, along));
    }
    Edges edges = Edges(length_between(all.here, all.before, -ahead - along), length_between(all.here, behind, -ahead),
                        length_between(all.here, all.after, along - ahead), length_between(all.before, behind, along),
                        length_between(behind, all.after, along));
    behind = all.here;
    return edges;
}
