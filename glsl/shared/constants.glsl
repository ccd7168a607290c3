// Constants shared with Rust. build.rs turns each #define below into a Rust constant, and the comment above
// it into the documentation of that constant. An empty comment line would end that documentation.

// Value for "not reached" and "no such edge". It is large, and sums of such values stay finite.
#define FAR 1e30
// Limit of the times on a map without a limit. No sum of times and edges exceeds it.
#define NO_LIMIT 3e38
// Kinds of fronts: the values of the specialization constant WAVEFRONT (see wavefront.glsl), and the numbers
// of Rust's Wavefront.
#define PLANAR 0
#define CIRCULAR 1
#define CURVED 2
#define ANCHORED 3
// Curvature of a front at a point source, in place of infinity. A tag may enlarge it. It is a power of two,
// which a tag of 0 leaves unchanged.
#define SOURCE_CURVATURE 5.764607523034235e17
// Number of invocations in a workgroup of most passes, all in one row. Scans, rounds of tiles, surroundings and
// exchanges have workgroups of other sizes. Every Vulkan device offers at least 128.
#define WORKGROUP 64
// Largest number of workgroups of a dispatch along one axis that every Vulkan device offers.
#define MOST_GROUPS 65535
// Layers of the images of fronts, which have 2 x 2 points per texel. The first holds arrival times. The
// second holds what else fronts carry, depending on their kind: a curvature, or the number of an anchor.
#define TIME 0
#define CARRIED 1
#define LAYERS 2
// Rounding of an angle defect, in radians; see gaussian_curvature.rs.
#define DEFECT_NOISE 4e-7
// Largest angle defect that counts, in radians; see gaussian_curvature.rs.
#define LARGEST_DEFECT 0.5
// Stands for a curvature of zero that carries a tag. Devices may flush smaller numbers to zero.
#define FLAT 1e-30
// Weight of a change of a front's curvature in the residual. The change is taken relative to 1 over the
// arrival time, and counts beside relative changes of that time.
#define CURVATURE_COUNTS 1e-4
// Weight of a change of a front's anchor in the residual, as a relative change of its arrival time.
#define ANCHOR_COUNTS 1e-5
// Mask of the last binary digits of a number, which may hold a tag; see tag.glsl.
#define TAG 15
// Tag of a front that came through a whole triangle. It is added to the tag of the front's scan.
#define WHOLE 8
// Tag of a seed whose time is exact, in place of the number of a scan. No front replaces such a seed.
#define EXACT 5
// Tag of a front in surroundings where a front of another source may be first, in place of the number of a scan.
// merge_surroundings.comp writes no seed where such a front is the earliest.
#define NOT_EXACT 6
// Tag of a front that comes from another copy of its point on a glued surface, in place of the number of a scan.
#define EXCHANGED 7
// Sides of the grid: it ends there, goes on at the opposite side, or goes on there in reverse order.
#define GRID_ENDS 0
#define GOES_ON 1
#define REVERSES 2
// Number of lines beyond a side where the grid goes on, on which lengths of edges depend.
#define SEAM_HALO 3
// Rule for the lengths of edges: along the surface, where grid lines have corners, so that the lengths of steps jump.
#define WITH_CORNERS 2
// Largest number of copies of a point among which an invocation finds the earliest front.
#define COPIES_TOGETHER 32
// Number of invocations of the workgroup that exchanges fronts between copies. Every Vulkan device offers as many.
#define EXCHANGE_WORKGROUP 128
// Number of words that describe a texel with copies of points; see exchange.comp.
#define COPY_TEXEL_WORDS 5
// Value of `fronts_meet` on maps where fronts of several sources may meet.
#define FRONTS_MEET 1
// Value of `fronts_meet` on maps where fronts may meet and sources are added later. Seeds that were exact may
// then be replaced.
#define FRONTS_ARE_ADDED 2
// Tag of the surface value (Gaussian curvature) at points where fronts diffract. These points are tagged LACKING too.
#define DIFFRACTS 1
// Tag of the surface at points that lack an edge.
#define LACKING 2
// Tangent of 22.5 degrees. Fronts diffract at a point if the angle that is open to them exceeds a half turn by more
// than 22.5 degrees: at corners of holes, and not along the sides of holes or the border.
#define REFLEX 0.41421357
// A triangle is obtuse at x0 if the sum of the squares of its sides there is less than this part of the
// square of its base. This is a margin of three degrees, so that rounding makes no right angle obtuse.
#define OBTUSE 0.95
// A triangle is upright if the square of its longest side is less than this factor times the sum of the
// squares of the others.
#define UPRIGHT 1.1
// Largest number of points examined to split an obtuse triangle.
#define SPLIT_STEPS 16
// Largest distance of such a point from x0, in rows and columns.
#define SPLIT_REACH 6
// Largest distance on surfaces on which some of these points lie farther away. It is at most the side of the smallest
// tile. A constant metric whose axes have a ratio of 30 needs 16 rows or columns.
#define FARTHEST_SPLIT 16
// Number of points examined per row or column of the distance on these surfaces.
#define STEPS_PER_LINE 4
// Relative margin by which two unfolded points must differ in squared distance or in direction. Anything below is
// rounding.
#define SPLIT_MARGIN 1e-3
// Part of the base by which a ray may miss it while the front along an edge still counts as going straight on, not as
// turning around the edge's end. It is not a ratio of small whole numbers. Rays between grid points often turn by such
// a ratio, and rounding would decide whether they turn by more.
#define GRAZING 0.0973
// A front that runs along a border which bends away from it opens into a fan of rays, often narrower than the cells
// beside the border. The curvature of the front there is this factor times the sine of the angle of the fan, divided by
// the width of the cells. The factor is that of the smallest errors around the rim of a cone, with cells of many
// shapes.
#define FAN 1.5
// Least value of 1 + kappa l for a front of curvature kappa that runs on by l, so that converging fronts keep a finite
// curvature.
#define FOCUS 0.1
// Limit of kappa (1 - d), where kappa is the curvature of a front over a base times the length of the base,
// and d is the difference of the times at its ends divided by that length. The product is 2 if the source
// lies on the base, and more if two sources reach the ends. The margin keeps rounding from making two sources
// of one.
#define STRADDLING 2.0002
// A front has run along a base, up to rounding, if the times at the ends differ by more than this part of the
// length of the base.
#define ALONG_BASE 0.9999
// A front replaces one that arrives together with it if its curvature is less by more than this part of its own
// curvature. Both or neither must have come through whole triangles.
#define BENT_APART 0.005
// Where the nearer end of a base is a source, the front at the farther end has come from it along the base if the times
// differ by at least this part of the length of the base.
#define FROM_SOURCE 0.99
// A front is nearly straight if the magnitude of its curvature times the length of the base is less than this.
#define ABOUT_STRAIGHT 0.25
// Fronts arrive together if their times differ by no more than this multiple of their rounding.
#define TOGETHER 1.0
// If a front may not arrive before the later end of its base, it arrives at least this many units of rounding
// after that end.
#define CLEARLY_LATER 2.0
// A front that arrives again at the same time is the same front if its curvature differs by no more than this
// multiple of its rounding. A tag takes 16 units.
#define BENT_AGAIN 1024.0
// Number of bends by which a point looks back for anchors other than its neighbours' own. Where several corners lie
// close together, the region in sight between them may stay narrower than a cell over a long way.
#define BENDS_BACK 4
// Largest number of anchors through which a path is followed back, including those that lie on one line.
#define LINES_BACK 32
// With anchors, times are equal if they differ by no more than this multiple of their rounding.
#define ALIKE 8.0
// The time stored at an anchor and the one that follows from the time of a point are equal if they differ by
// no more than this multiple of their rounding.
#define ALIKE_AT_ANCHOR 16.0
// Number of the first anchor that is a source inside a cell. Anchors with smaller numbers are grid points.
#define FIRST_INSIDE 33554432
// Largest number of sources inside cells on a map with anchors.
#define SOURCES_INSIDE 4096
// Number of texels of 2 x 2 points around the grid in every image. The image of edges, with a texel a point, has twice
// as many. With them, no access to a neighbour needs a bounds test.
#define BORDER 1
// Number of iterations without a newly reached point after which curved fronts are no longer renewed; see
// progress.rs.
#define PATIENCE 50
// Change in units of the last place that only a point's first front exceeds, since it takes the place of FAR.
#define FIRST_REACHED 167772160
// Passes that follow the seeds of a map, for which the pass of seeds prepares: scans, or rounds of tiles.
#define SCANS_FOLLOW 0
#define TILES_FOLLOW 1
// Largest number of rounds of tiles in a recording. It is even.
#define ROUNDS 128
// Number of words that the device keeps for each round: the three numbers that its indirect dispatch reads,
// the number of tiles on its list, the number of tiles that wait for the next round, and the urgency of the
// first tile.
#define ROUND_WORDS 6
// Mark of a tile on a list that has waited.
#define HAS_WAITED 2147483648
// A tile waits if it is due later than the first one by more than this multiple of the width of a tile,
// measured in typical edges. The value is not a ratio of small whole numbers, or rounding would decide on
// even grids.
#define BAND_SIDES 2.03
// On a GPU, no tile waits if the list of a round has at most this many tiles.
#define FEW_TILES 64
// The typical edge is measured at this many texels in each direction, spread evenly over the grid.
#define EDGE_LOOKS 16
// Number of words with one bit for each dispatch of a scan in a recording, used by profiles. The bit says
// whether the dispatch has visited its block. A word holds 32 of them.
#define VISIT_WORDS 1024
// Number of sources handled by one dispatch. Each of them is compared with all others.
#define SOURCES_TOGETHER 256
// Size in texels of each side of the surroundings of a source inside a cell, which a device solves first.
// They extend 8 to 10 points to each side of the cell. One workgroup solves them, with one invocation per
// texel, within what every device offers: 128 invocations and 16 KiB of shared memory.
#define SURROUNDINGS_TEXELS 10
// Stands for the first texel of surroundings if a source has none.
#define NO_WINDOW 1048576
// Number of invocations in a workgroup that solves surroundings.
#define SURROUNDINGS_WORKGROUP 128
// Largest number of updates of surroundings. Smooth surfaces need 14 to 18, surfaces that turn about within
// some cells need 28.
#define SURROUNDINGS_STEPS 40
// Largest number of targets of a map.
#define MOST_TARGETS 1024
// Margin between the last target's time and a device's limit, as a part of that time. Until a map has converged,
// a curved front may be renewed to come later.
#define TARGET_MARGIN 0.02
// Largest length of an edge. Squares and sums of such lengths stay within single precision and below FAR. A
// larger coordinate in a renderer's memory marks a hole, as NaN does.
#define LONGEST_EDGE 1e12
// The turning of a surface is measured at no more than this many points in each direction, spread over the grid, and so
// is the skew of its cells.
#define LOOKS 48
// Bits of the number of a point of this sample.
#define SAMPLE_BITS 12
// Cosine of 30 degrees. A surface turns sharply where the cosine of the angle between unit normals is
// smaller.
#define SHARP_COSINE 0.8660254
// Fixed-point scale of sums of squared differences of normals.
#define TURN_UNITS 1024
// Stands for the number of points that a renderer's surface lacks until it has been measured.
#define NEVER_MEASURED 4294967295
// Bits of the number of a point's group of copies beside the gap between these; see glued_points.glsl.
#define GAP_GROUP_BITS 20
// Largest number of levels of the contours of one recording.
#define LEVELS_TOGETHER 1024
// Number of words of a curve's record; see curve.glsl.
#define CURVE_WORDS 9
// Number of words of a vertex of a curve; see curve.glsl.
#define VERTEX_WORDS 6
// Status of a curve.
#define COMPLETE 0
#define OUT_OF_ROOM 1
#define UNREACHED 2
#define OUTSIDE 3
#define LOST 4
#define UNDER_WAY 5
// Number of words of the state of a path.
#define PATH_WORDS 15
// Number of steps of a path in one dispatch. No device takes long over these. Lavapipe ends all loops of an invocation
// after 65,535 turns in total.
#define STEPS_TOGETHER 256
// Number of vertices of a window within which vertices of a path over a slowness slide together, number of times that
// their moves are halved, and number of rounds.
#define SLIDE_WINDOW 32
#define SLIDE_HALVINGS 8
#define SLIDE_ROUNDS 2
// Number of steps by which one pass over regions extends the way of each point. On lavapipe, 3 steps take as
// long as this at 256 points per side, and 2.4 times as long at 1024.
#define FLOW_JUMPS 7
// Number of steps in one pass over points whose ways end without a source. There are few such points.
#define PARENT_JUMPS 63
// Number of words before the sections of a buffer of ways: the earliest and the latest initial value, and a
// word for each round of a log map; see ways.glsl. It is even.
#define WAYS_HEADER 34
// Number of points around a source, to each side, whose ways are followed to the source cell by cell. The log
// map of other points follows from theirs.
#define LOG_MAP_DISC 16.0
// Largest number of lines of such a way.
#define LOG_MAP_LINES 48
// Number of steps to earlier places that a point takes in one round of a log map.
#define LOG_MAP_STEPS 3
// Second differences of squared times have a kink between them if they differ by more than this factor.
#define KINK 3.0
// Largest ratio of the lengths of two edges in line from which a second difference is taken.
#define MOST_UNEVEN 10.0
// Amount by which times may change faster than the length of the way, as a part of the edge. It allows for
// curved edges and for a metric that changes.
#define MARGIN 0.05
// Largest distance from a grid point, as a part of the edge, at which the end of a line of a path is moved to that grid
// point.
#define AT_POINT 1e-4
// Part of its length by which a straight line to a source in sight is preferred to others. If a line fits the arrival
// time up to this part of its length, the cell on the other side of the edge is not searched.
#define FITS 1e-3
// A line falls if the arrival time falls along it by at least this part of its length.
#define LEAST_FALL 0.5
// The fronts of neighbouring points come from different sides if their ways lead to places that are farther
// apart than this, in columns or rows.
#define NEAR_PLACES 2.0
// Ratio of the slownesses of neighbours below which the slowness may change smoothly. Otherwise the point has
// the tag JUMPS.
#define EVEN_SLOWNESS 1.25
// Largest second difference of a smoothly changing slowness, as a part of the slowness. If it is larger, the
// point has the tag JUMPS.
#define ROUGH_SLOWNESS 0.03
// Tag of the slowness at points where it jumps.
#define JUMPS 1
// A metric jumps fully where the ratio of lengths exceeds EVEN_SLOWNESS by 1 / JUMPS_PER_RATIO, and in part where
// the ratio lies between both limits.
#define JUMPS_PER_RATIO 2.0
// Largest difference of the slownesses at the corners of a triangle, as a part of the sum of two of them, up to which one
// Newton step finds where a ray crosses the base. Beyond it the update takes three steps.
#define EVEN_CORNERS 0.01
// Part of the least positive slowness that counts where the slowness is 0. Travel is free there, but edges
// need a length.
#define FREE 1e-6
// A renderer's frame does not know the least positive slowness, and raises any smaller slowness to this
// value.
#define LEAST_SLOWNESS 1e-12
// Largest magnitude of the cosine from which the place of a ray on the base is guessed, where the slowness is uneven and
// where it is even.
#define STEEPEST_GUESS 0.95
#define STEEPEST 0.9999
