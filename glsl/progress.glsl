// How a map's iterations go, kept on the device so that no readback steers them.

layout(set = 0, binding = 4) restrict buffer Progress {
    uint residual;      // largest change of a front in this iteration, in units of the last place
    uint renews;        // 1 while curved fronts may be renewed
    uint iterations;    // done so far: of four scans, of updates of all points, or rounds of tiles
    uint last_residual; // that of the last iteration done
    uint since_reached; // iterations since a point was first reached
    uint done;          // 1 once the map has converged, or iterations have run out
    uint tolerance;     // residual at which a map has converged
    uint most;          // iterations, at most
    uint fronts_meet;   // 0, FRONTS_MEET or FRONTS_ARE_ADDED; see wavefront.glsl
    // What the dispatches of further iterations read, zero groups once the map is done.
    uint grid_groups[3];   // of the grid
    uint rounds[ROUND_WORDS * (ROUNDS + 1)]; // of the tiles on the list of each round; then what else is kept of it
    uint unsettled[ROUNDS]; // largest change of a round that another one has to pass on
    uint reached;           // 1 once a round has reached a point
    uint settled;           // texels that settle.comp has copied, for profiles
    uint visits[VISIT_WORDS]; // a bit for each dispatch of a scan that has visited its block, for profiles
    float typical_edge; // about as long as the surface's edges along rows and columns are; 0 if it has none
    // What a renderer is to know of its input, which no iteration changes.
    uint prepared;    // the number that the surface's last preparation to run has written
    uint passed_over; // sources of the map that reach no point
    uint holes;       // points that cannot be used; NEVER_MEASURED before there are any edges
    uint no_length;   // edges between points that can be used, of length 0 or beyond FAR
    // Of some of the edges, see turns.glsl.
    uint sharp;       // those at whose ends normals differ by much
    uint compared;    // all
    uint continued;   // those beyond which the normal is known too
    uint turns[2];    // of these the sums of squared differences of normals, one and two steps apart
};
