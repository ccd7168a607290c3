//! Constants shared with the shaders, generated from `glsl/shared/constants.glsl` by `build.rs`.

/// Value for "not reached" and "no such edge". It is large, and sums of such values stay finite.
pub const FAR: f64 = 1e30;
/// Limit of the times on a map without a limit. No sum of times and edges exceeds it.
pub const NO_LIMIT: f64 = 3e38;
/// Kinds of fronts: the values of the specialization constant WAVEFRONT (see wavefront.glsl), and the numbers
/// of Rust's Wavefront.
pub const PLANAR: u32 = 0;
pub const CIRCULAR: u32 = 1;
pub const CURVED: u32 = 2;
pub const ANCHORED: u32 = 3;
/// Curvature of a front at a point source, in place of infinity. A tag may enlarge it. It is a power of two,
/// which a tag of 0 leaves unchanged.
pub const SOURCE_CURVATURE: f64 = 5.764607523034235e17;
/// Number of invocations in a workgroup of most passes, all in one row. Scans, rounds of tiles, surroundings and
/// exchanges have workgroups of other sizes. Every Vulkan device offers at least 128.
pub const WORKGROUP: u32 = 64;
/// Largest number of workgroups of a dispatch along one axis that every Vulkan device offers.
pub const MOST_GROUPS: u32 = 65535;
/// Layers of the images of fronts, which have 2 x 2 points per texel. The first holds arrival times. The
/// second holds what else fronts carry, depending on their kind: a curvature, or the number of an anchor.
pub const TIME: u32 = 0;
pub const CARRIED: u32 = 1;
pub const LAYERS: u32 = 2;
/// Rounding of an angle defect, in radians; see gaussian_curvature.rs.
pub const DEFECT_NOISE: f64 = 4e-7;
/// Largest angle defect that counts, in radians; see gaussian_curvature.rs.
pub const LARGEST_DEFECT: f64 = 0.5;
/// Stands for a curvature of zero that carries a tag. Devices may flush smaller numbers to zero.
pub const FLAT: f64 = 1e-30;
/// Weight of a change of a front's curvature in the residual. The change is taken relative to 1 over the
/// arrival time, and counts beside relative changes of that time.
pub const CURVATURE_COUNTS: f64 = 1e-4;
/// Weight of a change of a front's anchor in the residual, as a relative change of its arrival time.
pub const ANCHOR_COUNTS: f64 = 1e-5;
/// Mask of the last binary digits of a number, which may hold a tag; see tag.glsl.
pub const TAG: u32 = 15;
/// Tag of a front that came through a whole triangle. It is added to the tag of the front's scan.
pub const WHOLE: u32 = 8;
/// Tag of a seed whose time is exact, in place of the number of a scan. No front replaces such a seed.
pub const EXACT: u32 = 5;
/// Tag of a front in surroundings where a front of another source may be first, in place of the number of a scan.
/// merge_surroundings.comp writes no seed where such a front is the earliest.
pub const NOT_EXACT: u32 = 6;
/// Tag of a front that comes from another copy of its point on a glued surface, in place of the number of a scan.
pub const EXCHANGED: u32 = 7;
/// Sides of the grid: it ends there, goes on at the opposite side, or goes on there in reverse order.
pub const GRID_ENDS: u32 = 0;
pub const GOES_ON: u32 = 1;
pub const REVERSES: u32 = 2;
/// Number of lines beyond a side where the grid goes on, on which lengths of edges depend.
pub const SEAM_HALO: u32 = 3;
/// Rule for the lengths of edges: along the surface, where grid lines have corners, so that the lengths of steps jump.
pub const WITH_CORNERS: u32 = 2;
/// Largest number of copies of a point among which an invocation finds the earliest front.
pub const COPIES_TOGETHER: u32 = 32;
/// Number of invocations of the workgroup that exchanges fronts between copies. Every Vulkan device offers as many.
pub const EXCHANGE_WORKGROUP: u32 = 128;
/// Number of words that describe a texel with copies of points; see exchange.comp.
pub const COPY_TEXEL_WORDS: u32 = 5;
/// Value of `fronts_meet` on maps where fronts of several sources may meet.
pub const FRONTS_MEET: u32 = 1;
/// Value of `fronts_meet` on maps where fronts may meet and sources are added later. Seeds that were exact may
/// then be replaced.
pub const FRONTS_ARE_ADDED: u32 = 2;
/// Tag of the surface value (Gaussian curvature) at points where fronts diffract. These points are tagged LACKING too.
pub const DIFFRACTS: u32 = 1;
/// Tag of the surface at points that lack an edge.
pub const LACKING: u32 = 2;
/// Tangent of 22.5 degrees. Fronts diffract at a point if the angle that is open to them exceeds a half turn by more
/// than 22.5 degrees: at corners of holes, and not along the sides of holes or the border.
pub const REFLEX: f64 = 0.41421357;
/// A triangle is obtuse at x0 if the sum of the squares of its sides there is less than this part of the
/// square of its base. This is a margin of three degrees, so that rounding makes no right angle obtuse.
pub const OBTUSE: f64 = 0.95;
/// A triangle is upright if the square of its longest side is less than this factor times the sum of the
/// squares of the others.
pub const UPRIGHT: f64 = 1.1;
/// Largest number of points examined to split an obtuse triangle.
pub const SPLIT_STEPS: u32 = 16;
/// Largest distance of such a point from x0, in rows and columns.
pub const SPLIT_REACH: u32 = 6;
/// Largest distance on surfaces on which some of these points lie farther away. It is at most the side of the smallest
/// tile. A constant metric whose axes have a ratio of 30 needs 16 rows or columns.
pub const FARTHEST_SPLIT: u32 = 16;
/// Number of points examined per row or column of the distance on these surfaces.
pub const STEPS_PER_LINE: u32 = 4;
/// Relative margin by which two unfolded points must differ in squared distance or in direction. Anything below is
/// rounding.
pub const SPLIT_MARGIN: f64 = 1e-3;
/// Part of the base by which a ray may miss it while the front along an edge still counts as going straight on, not as
/// turning around the edge's end. It is not a ratio of small whole numbers. Rays between grid points often turn by such
/// a ratio, and rounding would decide whether they turn by more.
pub const GRAZING: f64 = 0.0973;
/// A front that runs along a border which bends away from it opens into a fan of rays, often narrower than the cells
/// beside the border. The curvature of the front there is this factor times the sine of the angle of the fan, divided by
/// the width of the cells. The factor is that of the smallest errors around the rim of a cone, with cells of many
/// shapes.
pub const FAN: f64 = 1.5;
/// Least value of 1 + kappa l for a front of curvature kappa that runs on by l, so that converging fronts keep a finite
/// curvature.
pub const FOCUS: f64 = 0.1;
/// Limit of kappa (1 - d), where kappa is the curvature of a front over a base times the length of the base,
/// and d is the difference of the times at its ends divided by that length. The product is 2 if the source
/// lies on the base, and more if two sources reach the ends. The margin keeps rounding from making two sources
/// of one.
pub const STRADDLING: f64 = 2.0002;
/// A front has run along a base, up to rounding, if the times at the ends differ by more than this part of the
/// length of the base.
pub const ALONG_BASE: f64 = 0.9999;
/// A front replaces one that arrives together with it if its curvature is less by more than this part of its own
/// curvature. Both or neither must have come through whole triangles.
pub const BENT_APART: f64 = 0.005;
/// Where the nearer end of a base is a source, the front at the farther end has come from it along the base if the times
/// differ by at least this part of the length of the base.
pub const FROM_SOURCE: f64 = 0.99;
/// A front is nearly straight if the magnitude of its curvature times the length of the base is less than this.
pub const ABOUT_STRAIGHT: f64 = 0.25;
/// Fronts arrive together if their times differ by no more than this multiple of their rounding.
pub const TOGETHER: f64 = 1.0;
/// If a front may not arrive before the later end of its base, it arrives at least this many units of rounding
/// after that end.
pub const CLEARLY_LATER: f64 = 2.0;
/// A front that arrives again at the same time is the same front if its curvature differs by no more than this
/// multiple of its rounding. A tag takes 16 units.
pub const BENT_AGAIN: f64 = 1024.0;
/// Number of bends by which a point looks back for anchors other than its neighbours' own. Where several corners lie
/// close together, the region in sight between them may stay narrower than a cell over a long way.
pub const BENDS_BACK: u32 = 4;
/// Largest number of anchors through which a path is followed back, including those that lie on one line.
pub const LINES_BACK: u32 = 32;
/// With anchors, times are equal if they differ by no more than this multiple of their rounding.
pub const ALIKE: f64 = 8.0;
/// The time stored at an anchor and the one that follows from the time of a point are equal if they differ by
/// no more than this multiple of their rounding.
pub const ALIKE_AT_ANCHOR: f64 = 16.0;
/// Number of the first anchor that is a source inside a cell. Anchors with smaller numbers are grid points.
pub const FIRST_INSIDE: u32 = 33554432;
/// Largest number of sources inside cells on a map with anchors.
pub const SOURCES_INSIDE: u32 = 4096;
/// Number of texels of 2 x 2 points around the grid in every image. The image of edges, with a texel a point, has twice
/// as many. With them, no access to a neighbour needs a bounds test.
pub const BORDER: u32 = 1;
/// Number of iterations without a newly reached point after which curved fronts are no longer renewed; see
/// progress.rs.
pub const PATIENCE: u32 = 50;
/// Change in units of the last place that only a point's first front exceeds, since it takes the place of FAR.
pub const FIRST_REACHED: u32 = 167772160;
/// Passes that follow the seeds of a map, for which the pass of seeds prepares: scans, or rounds of tiles.
pub const SCANS_FOLLOW: u32 = 0;
pub const TILES_FOLLOW: u32 = 1;
/// Largest number of rounds of tiles in a recording. It is even.
pub const ROUNDS: u32 = 128;
/// Number of words that the device keeps for each round: the three numbers that its indirect dispatch reads,
/// the number of tiles on its list, the number of tiles that wait for the next round, and the urgency of the
/// first tile.
pub const ROUND_WORDS: u32 = 6;
/// Mark of a tile on a list that has waited.
pub const HAS_WAITED: u32 = 2147483648;
/// A tile waits if it is due later than the first one by more than this multiple of the width of a tile,
/// measured in typical edges. The value is not a ratio of small whole numbers, or rounding would decide on
/// even grids.
pub const BAND_SIDES: f64 = 2.03;
/// On a GPU, no tile waits if the list of a round has at most this many tiles.
pub const FEW_TILES: u32 = 64;
/// The typical edge is measured at this many texels in each direction, spread evenly over the grid.
pub const EDGE_LOOKS: u32 = 16;
/// Number of words with one bit for each dispatch of a scan in a recording, used by profiles. The bit says
/// whether the dispatch has visited its block. A word holds 32 of them.
pub const VISIT_WORDS: u32 = 1024;
/// Number of sources handled by one dispatch. Each of them is compared with all others.
pub const SOURCES_TOGETHER: u32 = 256;
/// Size in texels of each side of the surroundings of a source inside a cell, which a device solves first.
/// They extend 8 to 10 points to each side of the cell. One workgroup solves them, with one invocation per
/// texel, within what every device offers: 128 invocations and 16 KiB of shared memory.
pub const SURROUNDINGS_TEXELS: u32 = 10;
/// Stands for the first texel of surroundings if a source has none.
pub const NO_WINDOW: u32 = 1048576;
/// Number of invocations in a workgroup that solves surroundings.
pub const SURROUNDINGS_WORKGROUP: u32 = 128;
/// Largest number of updates of surroundings. Smooth surfaces need 14 to 18, surfaces that turn about within
/// some cells need 28.
pub const SURROUNDINGS_STEPS: u32 = 40;
/// Largest number of targets of a map.
pub const MOST_TARGETS: u32 = 1024;
/// Margin between the last target's time and a device's limit, as a part of that time. Until a map has converged,
/// a curved front may be renewed to come later.
pub const TARGET_MARGIN: f64 = 0.02;
/// Largest length of an edge. Squares and sums of such lengths stay within single precision and below FAR. A
/// larger coordinate in a renderer's memory marks a hole, as NaN does.
pub const LONGEST_EDGE: f64 = 1e12;
/// The turning of a surface is measured at no more than this many points in each direction, spread over the grid, and so
/// is the skew of its cells.
pub const LOOKS: u32 = 48;
/// Bits of the number of a point of this sample.
pub const SAMPLE_BITS: u32 = 12;
/// Cosine of 30 degrees. A surface turns sharply where the cosine of the angle between unit normals is
/// smaller.
pub const SHARP_COSINE: f64 = 0.8660254;
/// Fixed-point scale of sums of squared differences of normals.
pub const TURN_UNITS: u32 = 1024;
/// Stands for the number of points that a renderer's surface lacks until it has been measured.
pub const NEVER_MEASURED: u32 = 4294967295;
/// Bits of the number of a point's group of copies beside the gap between these; see glued_points.glsl.
pub const GAP_GROUP_BITS: u32 = 20;
/// Largest number of levels of the contours of one recording.
pub const LEVELS_TOGETHER: u32 = 1024;
/// Number of words of a curve's record; see curve.glsl.
pub const CURVE_WORDS: u32 = 9;
/// Number of words of a vertex of a curve; see curve.glsl.
pub const VERTEX_WORDS: u32 = 6;
/// Status of a curve.
pub const COMPLETE: u32 = 0;
pub const OUT_OF_ROOM: u32 = 1;
pub const UNREACHED: u32 = 2;
pub const OUTSIDE: u32 = 3;
pub const LOST: u32 = 4;
pub const UNDER_WAY: u32 = 5;
/// Number of words of the state of a path.
pub const PATH_WORDS: u32 = 15;
/// Number of steps of a path in one dispatch. No device takes long over these. Lavapipe ends all loops of an invocation
/// after 65,535 turns in total.
pub const STEPS_TOGETHER: u32 = 256;
/// Number of vertices of a window within which vertices of a path over a slowness slide together, number of times that
/// their moves are halved, and number of rounds.
pub const SLIDE_WINDOW: u32 = 32;
pub const SLIDE_HALVINGS: u32 = 8;
pub const SLIDE_ROUNDS: u32 = 2;
/// Number of steps by which one pass over regions extends the way of each point. On lavapipe, 3 steps take as
/// long as this at 256 points per side, and 2.4 times as long at 1024.
pub const FLOW_JUMPS: u32 = 7;
/// Number of steps in one pass over points whose ways end without a source. There are few such points.
pub const PARENT_JUMPS: u32 = 63;
/// Number of words before the sections of a buffer of ways: the earliest and the latest initial value, and a
/// word for each round of a log map; see ways.glsl. It is even.
pub const WAYS_HEADER: u32 = 34;
/// Number of points around a source, to each side, whose ways are followed to the source cell by cell. The log
/// map of other points follows from theirs.
pub const LOG_MAP_DISC: f64 = 16.0;
/// Largest number of lines of such a way.
pub const LOG_MAP_LINES: u32 = 48;
/// Number of steps to earlier places that a point takes in one round of a log map.
pub const LOG_MAP_STEPS: u32 = 3;
/// Second differences of squared times have a kink between them if they differ by more than this factor.
pub const KINK: f64 = 3.0;
/// Largest ratio of the lengths of two edges in line from which a second difference is taken.
pub const MOST_UNEVEN: f64 = 10.0;
/// Amount by which times may change faster than the length of the way, as a part of the edge. It allows for
/// curved edges and for a metric that changes.
pub const MARGIN: f64 = 0.05;
/// Largest distance from a grid point, as a part of the edge, at which the end of a line of a path is moved to that grid
/// point.
pub const AT_POINT: f64 = 1e-4;
/// Part of its length by which a straight line to a source in sight is preferred to others. If a line fits the arrival
/// time up to this part of its length, the cell on the other side of the edge is not searched.
pub const FITS: f64 = 1e-3;
/// A line falls if the arrival time falls along it by at least this part of its length.
pub const LEAST_FALL: f64 = 0.5;
/// The fronts of neighbouring points come from different sides if their ways lead to places that are farther
/// apart than this, in columns or rows.
pub const NEAR_PLACES: f64 = 2.0;
/// Ratio of the slownesses of neighbours below which the slowness may change smoothly. Otherwise the point has
/// the tag JUMPS.
pub const EVEN_SLOWNESS: f64 = 1.25;
/// Largest second difference of a smoothly changing slowness, as a part of the slowness. If it is larger, the
/// point has the tag JUMPS.
pub const ROUGH_SLOWNESS: f64 = 0.03;
/// Tag of the slowness at points where it jumps.
pub const JUMPS: u32 = 1;
/// A metric jumps fully where the ratio of lengths exceeds EVEN_SLOWNESS by 1 / JUMPS_PER_RATIO, and in part where
/// the ratio lies between both limits.
pub const JUMPS_PER_RATIO: f64 = 2.0;
/// Largest difference of the slownesses at the corners of a triangle, as a part of the sum of two of them, up to which one
/// Newton step finds where a ray crosses the base. Beyond it the update takes three steps.
pub const EVEN_CORNERS: f64 = 0.01;
/// Part of the least positive slowness that counts where the slowness is 0. Travel is free there, but edges
/// need a length.
pub const FREE: f64 = 1e-6;
/// A renderer's frame does not know the least positive slowness, and raises any smaller slowness to this
/// value.
pub const LEAST_SLOWNESS: f64 = 1e-12;
/// Largest magnitude of the cosine from which the place of a ray on the base is guessed, where the slowness is uneven and
/// where it is even.
pub const STEEPEST_GUESS: f64 = 0.95;
pub const STEEPEST: f64 = 0.9999;
