// Constants shared with Rust: build/main.rs turns each #define below into a Rust constant.

// Stands for "not reached" and "no such edge": large, finite, and its sums stay finite.
#define FAR 1e30
// The kinds of front: what the specialization constant WAVEFRONT says, see wavefront.glsl, and the numbers of
// Rust's Wavefront.
#define PLANAR 0
#define CIRCULAR 1
#define CURVED 2
#define ANCHORED 3
// Curvature of a front at a point source, at least: stands for infinity in the same way. A power of
// two, which a tag of 0 leaves as it is.
#define SOURCE_CURVATURE 5.764607523034235e17
// Invocations of a workgroup; 128 is the most that every Vulkan device offers, and a row or
// column of texels is the whole dispatch, so small groups fill a device sooner.
#define WORKGROUP 64
// Workgroups of a dispatch along one axis: the most that every Vulkan device offers.
#define MOST_GROUPS 65535
// Layers of the images of fronts, each with 2 x 2 points a texel: arrival times, and what else fronts
// carry, by their kind: a curvature, or the number of an anchor.
#define TIME 0
#define CARRIED 1
#define LAYERS 2
// Rounding of an angle defect, and the largest one that counts; see gaussian_curvature.rs.
#define DEFECT_NOISE 4e-7
#define LARGEST_DEFECT 0.5
// Stands for a curvature of zero that carries a flag: devices may flush what is smaller.
#define FLAT 1e-30
// What a change of a front's curvature counts in the residual, relative to 1 over its arrival
// time, beside a relative change of that time.
#define CURVATURE_COUNTS 1e-4
// Numbers of origins that fronts carry in place of a curvature begin at minus this; see src/update/curvature.rs. What
// another origin counts, times CURVATURE_COUNTS.
#define FIRST_ORIGIN 2305843009213693952.0
#define ORIGIN_COUNTS 0.1
// The number of origins that have a number.
#define MOST_ORIGINS 16777216
// See src/update/sight.rs. A front is in sight of its origin if its time is that of the straight line but for this part
// of it, and on the line but for rounding if it is but for the second.
#define IN_SIGHT 0.02
#define ON_LINE 1e-4
// A ray that runs past an edge by less than this part of it is taken for one along it.
#define PAST_EDGE 1e-4
// By how much of the base the other end's front may be later than this one's, which is not kept off then.
#define UNBLOCKED 0.01
// Gaussian curvature times the squared distance up to which the curvature of a front follows from its distance.
#define BENDS_MOST 0.1
// What another anchor of a front counts.
#define ANCHOR_COUNTS 1e-5
// The last binary digits of a number, which may hold a tag; see tag.glsl.
#define TAG 15
// Tag of a front that came from a whole triangle, beside that of its scan.
#define WHOLE 8
// In place of a scan: a seed whose time is exact, so that no front replaces it.
#define EXACT 5
// The same of one that only tells, until surroundings are merged, where another source's is not the first.
#define NOT_EXACT 6
// Where fronts may meet, and where they may and sources are added to a map, so that what was exact may be replaced.
#define FRONTS_MEET 1
#define FRONTS_ARE_ADDED 2
// Tags of the surface: where waves diffract, and at points that lack an edge, of which they are some.
#define DIFFRACTS 1
#define LACKING 2
// Waves diffract where the angle that is open to them is more than a half turn by 22.5 degrees, of which this is the
// tangent: at corners of holes, and not along their sides and the border.
#define REFLEX 0.41421357
// A triangle is obtuse at x0 if the squares of its sides there are together less than so much of the base's: by
// three degrees, so that rounding makes no right angle obtuse. How many points are looked for to split it, and how
// many rows and columns away.
#define OBTUSE 0.95
// A triangle is upright if the square of its longest side is less than so many times those of the others.
#define UPRIGHT 1.1
#define SPLIT_STEPS 16
#define SPLIT_REACH 6
// Below such a part of squared lengths what tells the places of two such points apart is rounding.
#define SPLIT_MARGIN 1e-3
// See curved.rs. GRAZING is no ratio of small whole numbers, or rounding would decide whether rays between
// grid points, which often turn by such a ratio, turn by more.
#define GRAZING 0.0973
#define FOCUS 0.1
// The curvature of a front over a base, in units of it, times 1 less the difference of its ends' times is 2 where the
// source lies on the base, and more where the ends are reached from two. With a margin, so that rounding does not tell
// of two where there is one.
#define STRADDLING 2.0002
// A front whose times at the ends of a base differ by more of its length has come along it, but for rounding.
#define ALONG_BASE 0.9999
#define BENT_APART 0.005
#define FROM_SOURCE 0.99
#define ABOUT_STRAIGHT 0.25
// Fronts whose times differ by no more than so many times their rounding arrive together.
#define TOGETHER 1.0
// Units of rounding by which a front arrives after the later end of a base where it may not arrive before it.
#define CLEARLY_LATER 2.0
// A front that comes again, together with itself, is the same if its curvature differs by no more than
// so many times its rounding: a tag takes 16.
#define BENT_AGAIN 1024.0
// How many bends back a point looks for anchors beside its neighbours' own: where several corners lie close
// together, what is lit from between them may be narrower than a cell for long.
#define BENDS_BACK 4
// Through how many anchors a way is followed back, those that lie on one line included.
#define LINES_BACK 32
// With anchors, times that differ by no more than so many times their rounding are the same.
#define ALIKE 8.0
// The same for an anchor's time and what follows for it from a point's.
#define ALIKE_AT_ANCHOR 16.0
// Numbers of anchors from here on are those of sources inside cells.
#define FIRST_INSIDE 33554432
// Sources inside cells that a map with anchors has room for.
#define SOURCES_INSIDE 4096
// Texels around the grid's own in every image, so that no neighbour needs a bounds test.
#define BORDER 1
// Iterations after the last in which a point was reached, from which on curved fronts are no
// longer renewed; see progress.rs.
#define PATIENCE 50
// No change of a front but that from FAR is of so many units of the last place.
#define FIRST_REACHED 167772160
// What follows the seeds of a map, which they are to prepare for: scans, updates of all points, or rounds
// of tiles.
#define SCANS_FOLLOW 0
#define NOTHING_FOLLOWS 1
#define TILES_FOLLOW 2
// Rounds of tiles in a recording, at most, and an even number of them.
#define ROUNDS 128
// Words that the device keeps of each round: the three numbers that its dispatch reads, the number of tiles on its list,
// the number of those that wait for the next round, and the urgency of the first.
#define ROUND_WORDS 6
// Marks a tile on a list that has waited.
#define HAS_WAITED 2147483648
// Tiles wait that are due later than the first by more than so many times the way across a tile, in typical edges. No
// ratio of small whole numbers, or on even grids rounding would decide.
#define BAND_SIDES 2.03
// On a GPU no tile waits while the list of a round has this many tiles or fewer.
#define FEW_TILES 64
// The typical edge is measured at this many texels along each side of the grid.
#define EDGE_LOOKS 16
// Words of 32 dispatches of scans of a recording, for profiles: whether they have visited their block.
#define VISIT_WORDS 1024
// Sources that one dispatch looks at, of which each looks at all others.
#define SOURCES_TOGETHER 256
// Texels on a side of the surroundings of a source inside a cell, which are solved first on a device: 8 to
// 10 points to each side of the cell. One workgroup has them, an invocation each, within what every device
// offers: 128 invocations and 16 KiB of shared memory. And how often they are updated, at most: 14 to 18
// times are enough on smooth surfaces, 28 on ones that turn about within some cells.
#define SURROUNDINGS_TEXELS 10
// In place of the first texel of surroundings that a source has not.
#define NO_WINDOW 1048576
#define SURROUNDINGS_WORKGROUP 128
#define SURROUNDINGS_STEPS 40
// Longest length of an edge: squares and sums of such lengths stay within single precision and below
// FAR. A coordinate beyond it in memory of a renderer's marks a hole, as NaN does.
#define LONGEST_EDGE 1e12
// How sharply a surface turns is looked at from so many points to each side of the grid, at most; where unit normals'
// cosine is below that of 30 degrees it turns sharply; sums of squares are kept in so many parts of 1.
#define LOOKS 48
#define SHARP_COSINE 0.8660254
#define TURN_UNITS 1024
// How many points a renderer's surface lacks, before they have been looked at.
#define NEVER_MEASURED 4294967295
// Levels of the contours of one recording, at most.
#define LEVELS_TOGETHER 1024
// Words of a curve's record and of its vertices; see curve.glsl.
#define CURVE_WORDS 9
#define VERTEX_WORDS 6
// What has become of a curve.
#define COMPLETE 0
#define OUT_OF_ROOM 1
#define UNREACHED 2
#define OUTSIDE 3
#define LOST 4
#define UNDER_WAY 5
// Words of the state of a path, and steps of one dispatch: no device takes long over these, and
// lavapipe ends loops after some thousand turns in all.
#define PATH_WORDS 15
#define STEPS_TOGETHER 256
// How often the ways of points are followed on in one pass over regions (on lavapipe 3 take from as
// long at 256 points a side to 2.4 times as long at 1024), and in one pass over those points whose ways
// lead nowhere, of which there are few.
#define FLOW_JUMPS 7
#define PARENT_JUMPS 63
// Second differences of squares of times that differ by more than this factor have a kink between them.
#define KINK 3.0
// How much faster times may change than the way is long, in shares of an edge: curved edges, and a metric that
// changes.
#define MARGIN 0.05
// A line of a path that ends nearer than this to a grid point, in shares of the edge, ends there.
#define AT_POINT 1e-4
// A straight line to the source in sight is preferred to others by this part of its length; and a line that
// fits the arrival time as well needs no other to be compared with.
#define FITS 1e-3
// A line falls if it does so by this part of its length.
#define LEAST_FALL 0.5
// Ways of neighbouring points that lead to places further apart than so many columns or rows are
// those of fronts that come from different sides.
#define NEAR_PLACES 2.0
// Slownesses of neighbours whose ratio is below the first belong to one that changes smoothly, unless its second
// difference is a larger part of it than the second; else the point has this tag. A metric jumps where the ratio of
// lengths exceeds the first by one over the last, and in part between both.
#define EVEN_SLOWNESS 1.25
#define ROUGH_SLOWNESS 0.03
#define JUMPS 1
#define JUMPS_PER_RATIO 2.0
// Steps by which the place is found where a ray crosses the base of a triangle with an uneven slowness: two for a
// smooth one, in single precision, and one more where it jumps.
#define CROSSING_STEPS 3
// Where the slowness is 0 travel is free, but edges need a length: this part of the least positive slowness counts. A
// renderer's frame does not know that one, and takes any slowness below LEAST_SLOWNESS for that.
#define FREE 1e-6
#define LEAST_SLOWNESS 1e-12
// Between these cosines a ray's place on the base is guessed.
#define STEEPEST_GUESS 0.95
