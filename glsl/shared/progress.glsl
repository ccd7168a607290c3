// Declares the progress of a map's iterations. It is kept on the device, so that no readback is needed to
// steer them.

layout(set = 0, binding = 4) restrict buffer Progress {
    uint residual;      // largest change of a front in this iteration, in units of the last place
    uint renews;        // 1 while curved fronts may be renewed
    uint iterations;    // number done: iterations of four scans, or rounds of tiles
    uint last_residual; // residual of the last iteration done
    uint since_reached; // number of iterations since a point was last reached for the first time
    uint done;          // 1 once the map has converged or the iterations have run out
    uint tolerance;     // largest residual at which a map has converged
    uint most;          // largest number of iterations
    uint visited;       // number of workgroups that have updated a tile or a part of a block
    uint fronts_meet;   // 0, FRONTS_MEET or FRONTS_ARE_ADDED; see wavefront.glsl
    float limit;        // time after which fronts do not matter; NO_LIMIT if there is none
    float end;          // time after which points count as unreached; with targets a little earlier than `limit`
    // The first and the last texel, by column and row and counted without the border, where fronts of a map with
    // a limit have changed. Maps without a limit do not write them.
    int changed_first[2];
    int changed_last[2];
    // For each scan, bits of the blocks past the middle of the grid that are due in the next iteration; see
    // blocks.glsl. Bit 0 is the block next to the middle.
    uint due_past_middle[4];
    uint rounds[ROUND_WORDS * (ROUNDS + 1)]; // the words of each round of tiles; see ROUND_WORDS
    uint unsettled[ROUNDS]; // largest change of a round that another round has to pass on
    uint reached;           // 1 once a round has reached a point
    uint settled;           // number of texels copied by settle.comp, for profiles
    uint visits[VISIT_WORDS]; // a bit for each block of a scan, set if the scan has visited the block, for profiles
    // The targets of a map: their number, the number of those that must be reached, and their rows and columns.
    uint target_count;
    uint targets_needed;
    uint targets[2 * MOST_TARGETS];
    float typical_edge; // typical length of edges along rows and columns; 0 if there are no edges
    // Properties of a renderer's input. No iteration changes them.
    uint prepared;    // number written by the last preparation of the surface that has run
    uint passed_over; // number of sources of the map that reach no point
    uint holes;       // number of unusable points; NEVER_MEASURED until there are edges
    uint no_length;   // number of edges between usable points that have length 0 or a length beyond FAR
    // Properties of a sample of the edges; see turns.glsl.
    uint sharp;       // number of edges at whose ends the normals differ by much
    uint compared;    // number of all sampled edges
    uint continued;   // number of sampled edges beyond which the normal is known too
    uint turns[2];    // for these edges, sums of squared differences of normals one and two steps apart
    uint skew;        // largest distance of points that split triangles, and its place; see skew.glsl
    uint seam_gap;    // largest gap between copies of a point, and its group; see glued_points.glsl
};

// Notes that a front at a texel, counted without the border, has changed.
void note_place(ivec2 inner) {
    if (limit >= NO_LIMIT) return;
    // Most changes lie inside, and need no write.
    for (int i = 0; i < 2; i++) {
        if (inner[i] < changed_first[i]) atomicMin(changed_first[i], inner[i]);
        if (inner[i] > changed_last[i]) atomicMax(changed_last[i], inner[i]);
    }
}
