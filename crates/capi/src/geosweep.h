/*
 * geosweep: geodesic distance maps on parametric surfaces, recorded into your own Vulkan command
 * buffers. docs/c.md explains how to build and link the library, and docs/embedding.md how to use it.
 *
 * Once:        geosweep_solver_create, geosweep_surface_create, geosweep_plan_create, and
 *              geosweep_record_prepare into a command buffer.
 * Every frame: geosweep_record_frame, between the passes that write its inputs and those that read
 *              the distances. The distances are then in an image on the device.
 * At the end:  geosweep_surface_destroy, geosweep_plan_destroy, geosweep_solver_destroy, before
 *              you destroy your device and instance.
 *
 * Contours, shortest paths, regions, directions and log maps can be computed in the same frame. Call geosweep_contours_create or
 * its counterparts once per surface, and geosweep_record_contours or its counterparts after the map. A
 * GeosweepProfile returns the time of each pass of a frame. If you have enabled VK_EXT_debug_utils, passes
 * have names and labels for tools.
 *
 * Errors. Calls return a GeosweepStatus, and geosweep_last_error describes the error in words. A call
 * that fails has created and recorded nothing. The GeosweepOutcome of a frame has what only the device
 * can know. During development, create the solver with GEOSWEEP_SOLVER_CHECKS.
 *
 * Ownership. You keep your Vulkan objects, which must outlive all objects created from them. Arrays and
 * structs are not needed after the call that takes them. Device memory is allocated only when surfaces,
 * contours, paths, regions, directions and log maps are created, from the solver's own blocks or from your own
 * GeosweepAllocator. geosweep_surface_bytes_for and its counterparts compute the size in advance. No call
 * submits, waits or maps your memory, and recording allocates nothing.
 *
 * Threads. Calls that take a pointer to a const object may use one object at the same time: several
 * threads may record, each with its own command pool and surface. Other calls need the object to
 * themselves.
 *
 * Units. Distances are in the unit of the points. Rows and columns are counted from 0, and arrays
 * are row by row. Start with structs that are all zero: each enum then has its usual value, and there
 * are no arrays and no barriers. Readers, slots and the value of unreached points have no usual value.
 *
 * This file is generated from crates/capi/src. Do not edit it.
 */


#ifndef GEOSWEEP_H
#define GEOSWEEP_H

#include <stdbool.h>
#include <stdint.h>

// Vulkan's types. If you use volk, which needs Vulkan's headers without prototypes, include volk.h before
// this header, or define GEOSWEEP_VULKAN_HEADER as <volk.h>. The same goes for any other header that
// declares them.
#ifdef GEOSWEEP_VULKAN_HEADER
#include GEOSWEEP_VULKAN_HEADER
#else
#include <vulkan/vulkan_core.h>
#endif


// Version of this header, which `geosweep_solver_create` compares with the library's. It grows with each
// change that makes programs compile or run differently.
#define GEOSWEEP_HEADER_VERSION 9

// Flag for `GeosweepSolverInfo::flags` that adds checks during development, at a small cost. With this flag,
// it is an error to record for one of several slots while the slot's last recording has not run, to destroy
// an object that such a recording uses, to write points that such a recording reads, and to use an object
// that was destroyed. The library keeps a few bytes of each destroyed object for this. Each recording gets
// one more fill and two more barriers.
#define GEOSWEEP_SOLVER_CHECKS 1

// Value of `GeosweepFrame::points` if the points have not changed since the last frame.
#define GEOSWEEP_POINTS_UNCHANGED 4294967295

// Value of `GeosweepSource::curvature` for a source that is one of many grid points on a straight line.
#define GEOSWEEP_STRAIGHT 1e-30

// Size in bytes of the record that `geosweep_record_outcome_to` copies.
#define GEOSWEEP_OUTCOME_BYTES 80

// Size in bytes of a curve's record in a `GeosweepCurves`. It is the stride of indirect draws, and the size
// that `geosweep_curve_record_from_bytes` reads.
#define GEOSWEEP_CURVE_RECORD_BYTES 36

// Value of `GeosweepCurveRecord::source` for a path that has not arrived at a source.
#define GEOSWEEP_NO_SOURCE 4294967295

// Label of a point without a nearest source: the point is a hole, or no front arrives there.
#define GEOSWEEP_NO_REGION 4294967295

// Value of a member of `GeosweepPass` that is not known.
#define GEOSWEEP_UNKNOWN UINT64_MAX

// Result of a call. `geosweep_last_error` describes an error in words.
typedef enum GeosweepStatus {
    // The call succeeded.
    GEOSWEEP_STATUS_SUCCESS = 0,
    // An argument cannot be used. The message says which one, and why. Nothing was created or recorded.
    GEOSWEEP_STATUS_INVALID_ARGUMENT = 1,
    // The device lacks something that is needed. The message lists everything that is missing.
    GEOSWEEP_STATUS_UNSUPPORTED = 2,
    // The grid is too large for the device's images or its memory.
    GEOSWEEP_STATUS_TOO_LARGE = 3,
    // Out of memory, on the device or in the program, or memory could not be mapped.
    GEOSWEEP_STATUS_OUT_OF_MEMORY = 4,
    // The device is lost.
    GEOSWEEP_STATUS_DEVICE_LOST = 5,
    // Another Vulkan call failed. The message names the call and its result.
    GEOSWEEP_STATUS_VULKAN_ERROR = 6,
    // A defect in geosweep, which was kept from crossing into your program. The object of the call is in an
    // unknown state: destroy it.
    GEOSWEEP_STATUS_INTERNAL_ERROR = 7,
    // The result is not available yet. Call again after the fence of the submission.
    GEOSWEEP_STATUS_NOT_READY = 8,
} GeosweepStatus;

// State of a curve after its recording has run.
typedef enum GeosweepCurveStatus {
    // The curve is complete. A path has arrived at a source.
    GEOSWEEP_CURVE_STATUS_COMPLETE = 0,
    // The curve needs more vertices than there is room for.
    GEOSWEEP_CURVE_STATUS_OUT_OF_ROOM = 1,
    // The path starts where no front arrives: in a hole, or where no source can be reached.
    GEOSWEEP_CURVE_STATUS_UNREACHED = 2,
    // The path starts off the grid or at NaN, or no start was given for it.
    GEOSWEEP_CURVE_STATUS_OUTSIDE = 3,
    // The path ends where the map does not lead on to a source. The map has not converged, belongs to other
    // sources, or has a local minimum there.
    GEOSWEEP_CURVE_STATUS_LOST = 4,
} GeosweepCurveStatus;

// Rule by which the edges between grid points are measured.
typedef enum GeosweepEdgeRule {
    // Length of a cubic through the neighbouring points, where the surface is smooth.
    GEOSWEEP_EDGE_RULE_ARC = 0,
    // Length of the straight line: the surface is a polyhedron.
    GEOSWEEP_EDGE_RULE_CHORD = 1,
} GeosweepEdgeRule;

// Sides of the grid that coincide. Each of two coinciding sides holds the points of their seam.
typedef enum GeosweepGluing {
    // None: the surface is open.
    GEOSWEEP_GLUING_NONE = 0,
    // The last column is the first one, as on a tube.
    GEOSWEEP_GLUING_COLUMNS = 1,
    // The last row is the first one.
    GEOSWEEP_GLUING_ROWS = 2,
    // Columns and rows, as on a torus.
    GEOSWEEP_GLUING_BOTH = 3,
    // The last column is the first one in reverse order, as on a Moebius strip.
    GEOSWEEP_GLUING_FLIPPED_COLUMNS = 4,
    // The last row is the first one in reverse order.
    GEOSWEEP_GLUING_FLIPPED_ROWS = 5,
    // Rows are latitudes and columns longitudes: the last column is the first one, and the first and the last row
    // are one point each.
    GEOSWEEP_GLUING_GLOBE = 6,
    // Each side of a square is folded in its middle. The middle of the grid is one pole of a sphere, and its
    // corners are the other.
    GEOSWEEP_GLUING_OCTAHEDRAL = 7,
    // The pairs of points that `GeosweepSurfaceInfo::runs` names.
    GEOSWEEP_GLUING_RUNS = 8,
} GeosweepGluing;

// Unit of work that gets its own time. Timestamps take time: the finer the grain, the longer the frame.
typedef enum GeosweepGrain {
    // Scans or rounds of tiles, and the passes around them.
    GEOSWEEP_GRAIN_SCANS = 0,
    // Blocks of lines of each scan.
    GEOSWEEP_GRAIN_BLOCKS = 1,
    // Iterations, and the passes around them.
    GEOSWEEP_GRAIN_ITERATIONS = 2,
    // Portions: all of a map from its sources to its outcome, and the passes before and after it.
    GEOSWEEP_GRAIN_PORTIONS = 3,
} GeosweepGrain;

// Meaning of the floats of a grid point.
typedef enum GeosweepPointKind {
    // Three coordinates, x, y and z.
    GEOSWEEP_POINT_KIND_POSITIONS = 0,
    // A height. The point at row r and column c is (c dx, r dy, height).
    GEOSWEEP_POINT_KIND_HEIGHTS = 1,
    // A metric in index coordinates: rr, rc and cc. A step of dr rows and dc columns has the squared length
    // rr dr^2 + 2 rc dr dc + cc dc^2. The metric is positive definite, and its entries are at most 1e12.
    GEOSWEEP_POINT_KIND_METRIC = 2,
} GeosweepPointKind;

// Order of updates. All schedules lead to the same map.
typedef enum GeosweepSchedule {
    // The best known schedule for the grid on this device, among those that the solver was created for.
    // Plans alone accept this value.
    GEOSWEEP_SCHEDULE_BEST = 0,
    // Four scans over the whole grid, in turn or in pairs. An iteration is all four scans.
    GEOSWEEP_SCHEDULE_RASTER = 1,
    // Scans inside the tiles in which something has changed. An iteration is a round of tiles.
    GEOSWEEP_SCHEDULE_TILES = 3,
} GeosweepSchedule;

// Shape of the wavefront that is assumed inside a triangle.
typedef enum GeosweepWavefront {
    // Straight front: first-order accurate and the cheapest.
    GEOSWEEP_WAVEFRONT_PLANAR = 0,
    // Circular front around a virtual point source: exact on the plane, for point sources.
    GEOSWEEP_WAVEFRONT_CIRCULAR = 1,
    // Front that carries its curvature along with the distance: second-order accurate on curved surfaces and
    // around holes.
    GEOSWEEP_WAVEFRONT_CURVED = 2,
    // Front that stores the corner or source from which it comes in a straight line: exact over planes with
    // holes. This requires a surface that is known to be such a plane. Surfaces on a device are not known to
    // be planes, so they get curved fronts.
    GEOSWEEP_WAVEFRONT_ANCHORED = 3,
    // Front that carries its curvature, its direction and its source, for maps on the CPU
    // (`geosweep_cpu_map`): where fronts of several sources meet, or a front meets itself, each goes on alone. Solvers
    // on a device use curved fronts in its place.
    GEOSWEEP_WAVEFRONT_RAYS = 4,
} GeosweepWavefront;

// Buffer for the contours of a surface, and the passes that find them. Frames in flight on one queue share
// one such object. If contours are read on other queues, create one object for each of these queues.
typedef struct GeosweepContours GeosweepContours;

// Image of the directions in which ways lead back to the sources, and the passes that find them. A texel of
// `VK_FORMAT_R16G16_SFLOAT` is a unit vector in columns and rows. It is 0, 0 at sources and at points that
// are not reached. Frames in flight on one queue share the image.
typedef struct GeosweepDirections GeosweepDirections;

// Image of the log map of point sources, and the passes that compute it. A texel of
// `VK_FORMAT_R32G32_SFLOAT` is (u, v): the direction in which the shortest path to the point leaves its
// source, times the distance. u is in the direction of increasing columns at the source, v at a right angle
// to it, on the side of increasing rows. Frames in flight on one queue share the image.
typedef struct GeosweepLogMap GeosweepLogMap;

// Buffer for the paths on a surface, and the passes that trace them. Frames in flight on one queue share one
// such object. If paths are read on other queues, create one object for each of these queues.
typedef struct GeosweepPaths GeosweepPaths;

// Passes of a recording, for any surface of one size. Many recordings may use a plan at the same time, on
// any thread.
typedef struct GeosweepPlan GeosweepPlan;

// Profile of a frame, with its own queries and buffer. Each profiled frame in flight needs its own profile.
typedef struct GeosweepProfile GeosweepProfile;

// Buffer for the regions of a surface's maps, and the passes that find them. Frames in flight on one queue
// share one such object. If regions are read on other queues, create one object for each of these queues.
typedef struct GeosweepRegions GeosweepRegions;

// Pipelines of a device, shared by all its surfaces. Any number of threads may use it at the same time.
typedef struct GeosweepSolver GeosweepSolver;

// A grid on the device: edge lengths and fronts, which all recordings share, and an image of distances for
// each slot.
typedef struct GeosweepSurface GeosweepSurface;

// Requirements for the instance and the device, to be merged with those of the program.
typedef struct GeosweepRequirements {
    // Lowest version for `VkApplicationInfo::apiVersion`. The program may use a higher one.
    uint32_t api_version;
    // Number of extensions for `VkDeviceCreateInfo::enabledExtensionCount`. It is 0 so far.
    uint32_t device_extension_count;
    // Names for `VkDeviceCreateInfo::ppEnabledExtensionNames`, which are never freed. Null if there are
    // none.
    const char *const *device_extensions;
    // Features for `VkDeviceCreateInfo::pEnabledFeatures` or for the features of a
    // `VkPhysicalDeviceFeatures2`. None are needed so far.
    VkPhysicalDeviceFeatures features;
} GeosweepRequirements;

// A schedule together with a wavefront.
typedef struct GeosweepPasses {
    // Any schedule but `GEOSWEEP_SCHEDULE_BEST`.
    GeosweepSchedule schedule;
    // The wavefront.
    GeosweepWavefront wavefront;
} GeosweepPasses;

// Requirements of an image or a buffer.
typedef struct GeosweepMemoryRequest {
    // Size, alignment and memory types.
    VkMemoryRequirements requirements;
    // Properties that the memory type must have: device-local, or host-visible and host-coherent.
    VkMemoryPropertyFlags required;
    // Properties that the memory type should have too.
    VkMemoryPropertyFlags preferred;
    // Whether the memory is for a buffer. Otherwise it is for an image with optimal tiling.
    bool is_buffer;
    // Purpose of the memory, such as "edge lengths". The text is valid during the call alone.
    const char *name;
} GeosweepMemoryRequest;

// A block of device memory.
typedef struct GeosweepMemory {
    // The device memory that contains the block.
    VkDeviceMemory memory;
    // Offset of the block in `memory` in bytes; a multiple of the alignment.
    uint64_t offset;
    // Address at which the block is mapped until it is freed. It may be null if the block need not be
    // host-visible.
    void *mapped;
    // Your own handle of the block, for instance a `VmaAllocation`.
    void *handle;
} GeosweepMemory;

// Your own allocator for surfaces, contours, paths, regions, directions and log maps. Its functions are
// called by one thread at a time, in calls that create and destroy these objects. They must not call
// functions of geosweep.
typedef struct GeosweepAllocator {
    // Pointer that both functions receive.
    void *user;
    // Allocates memory and writes the block to `memory`, which is all zero before the call. Returns
    // `VK_SUCCESS` if it succeeds.
    VkResult (*allocate)(void *user,
                         const struct GeosweepMemoryRequest *request,
                         struct GeosweepMemory *memory);
    // Frees a block that `allocate` has returned.
    void (*free)(void *user, const struct GeosweepMemory *memory);
} GeosweepAllocator;

// Parameters of a solver. All handles remain yours and must outlive the solver.
typedef struct GeosweepSolverInfo {
    // `GEOSWEEP_HEADER_VERSION`.
    uint32_t header_version;
    // The loader's `vkGetInstanceProcAddr` or your replacement of it. All Vulkan functions are found through
    // it.
    PFN_vkGetInstanceProcAddr get_instance_proc_addr;
    // An instance created for Vulkan 1.1 or later.
    VkInstance instance;
    // A physical device that `geosweep_check_device` accepts.
    VkPhysicalDevice physical_device;
    // A device created on `physical_device`, with what `geosweep_requirements` returns.
    VkDevice device;
    // Schedules and wavefronts for which pipelines are created: those that plans will request. Compiling
    // them takes a while.
    const struct GeosweepPasses *passes;
    // Number of entries in `passes`.
    uint32_t pass_count;
    // Cache for creating pipelines, or null. You fill, save and destroy it. It must be alive whenever the
    // solver creates pipelines: now, with the first surface that has a slowness or a small grid, and with
    // the first contours, paths, regions (of each wavefront), directions and log map.
    // `geosweep_solver_set_pipeline_cache` replaces or removes it. Pipelines do not need it once they are
    // created. The solver uses it on one thread at a time. If you use it at the same time, the rules of
    // `vkCreateComputePipelines` apply.
    VkPipelineCache pipeline_cache;
    // `GEOSWEEP_SOLVER_CHECKS`, or 0.
    uint32_t flags;
    // Your own allocator, or null for the solver's own blocks. The struct is not needed after the call.
    const struct GeosweepAllocator *allocator;
} GeosweepSolverInfo;

// Your own image for the distances of a slot, in place of one that the surface allocates. A render graph may
// use its memory for other resources between frames. The image is 2D with `VK_FORMAT_R32_SFLOAT` and at
// least cols x rows texels and one array layer; its usage contains `VK_IMAGE_USAGE_STORAGE_BIT` and what its
// readers need. The old content of the image is discarded, whatever its layout. `GeosweepFrame::before`, or
// a barrier of yours, must wait for earlier uses of the memory. Slots may share an image, and so may
// surfaces that are recorded one after another. For directions and log maps, `geosweep_directions_create`
// and `geosweep_log_map_create` name the format and the usage.
typedef struct GeosweepHostImage {
    // The image.
    VkImage image;
    // A 2D view of the image's first mip level.
    VkImageView view;
} GeosweepHostImage;

// Points of a surface, one for each grid point, row by row. They are in your own buffer or image on the
// device, which recordings read when they measure edges, or in the program's memory, from which the call
// copies them. Exactly one of `buffer`, `view` and `data` is not null.
//
// On the device, a point is a hole if one of its floats is NaN, infinite or beyond 1e12, or if its slowness
// is negative. In the program's memory, NaN, an infinite slowness and the mask make holes; other invalid
// values are errors. Travel is free where the slowness is 0. On the device, a slowness below 1e-12 counts as
// 1e-12.
typedef struct GeosweepPoints {
    // Meaning of the first floats of a point.
    GeosweepPointKind kind;
    // Index, counted from 0, of that float of a point which is its slowness: time per length. Distances are
    // then travel times. An index of 0 stands for a slowness of 1 everywhere.
    uint32_t slowness;
    // Distance between columns, for heights.
    double dx;
    // Distance between rows, for heights.
    double dy;
    // A buffer with usage `VK_BUFFER_USAGE_STORAGE_BUFFER_BIT`.
    VkBuffer buffer;
    // A 2D view of an image with usage `VK_IMAGE_USAGE_SAMPLED_BIT`. Its texels are the points: x is the
    // column, and y is the row.
    VkImageView view;
    // Layout of that image whenever it is read.
    VkImageLayout layout;
    // Array in the program's memory, which is not needed after the call.
    const float *data;
    // Mask for `data`, or null: rows x cols bytes, 0 for a hole.
    const uint8_t *mask;
    // Offset of the first point in `buffer` or `data` in bytes; a multiple of 4.
    uint64_t offset;
    // Bytes from point to point in `buffer` or `data`; a multiple of 4.
    uint64_t stride;
} GeosweepPoints;

// A buffer of sources, each a `GeosweepSource`, that your shaders write. An entry is skipped if it is off
// the grid or in a hole, or if its time is NaN or not below 1e30. Write NaN for an unused entry.
typedef struct GeosweepSourceBuffer {
    // Buffer with usage `VK_BUFFER_USAGE_STORAGE_BUFFER_BIT`.
    VkBuffer buffer;
    // Offset of the first source in bytes; a multiple of 4.
    uint64_t offset;
    // Number of sources.
    uint32_t count;
} GeosweepSourceBuffer;

// Buffers for looking up distances: places are read, and distances are written. Both have usage
// `VK_BUFFER_USAGE_STORAGE_BUFFER_BIT`.
typedef struct GeosweepLookup {
    // Buffer with two floats per place: row and column, with fractions between grid points.
    VkBuffer places;
    // Offset of the first place in bytes; a multiple of 4.
    uint64_t places_offset;
    // Buffer with one float per place.
    VkBuffer distances;
    // Offset of the first distance in bytes; a multiple of 4.
    uint64_t distances_offset;
    // Number of places.
    uint32_t count;
} GeosweepLookup;

// Grid points along a line.
typedef struct GeosweepRun {
    // Row of the first point.
    uint32_t row;
    // Column of the first point.
    uint32_t col;
    // Rows from point to point: -1, 0 or 1.
    int32_t row_step;
    // Columns from point to point: -1, 0 or 1. It is not 0 if `row_step` is 0.
    int32_t col_step;
} GeosweepRun;

// Two runs of points that coincide pair by pair.
typedef struct GeosweepRunPair {
    // One run.
    struct GeosweepRun first;
    // The other run.
    struct GeosweepRun second;
    // Number of points of each run.
    uint32_t points;
} GeosweepRunPair;

// Parameters of a surface. The images and buffers remain yours, and they must be alive whenever a recording
// that uses them runs. The arrays are not needed after the call, and may be null where their count is 0.
typedef struct GeosweepSurfaceInfo {
    // Number of rows of grid points.
    uint32_t rows;
    // Number of columns of grid points.
    uint32_t cols;
    // Rule by which edges are measured.
    GeosweepEdgeRule edge_rule;
    // Number of images of distances, which recordings write in turn: the number of frames in flight, from 1
    // to 64.
    uint32_t slots;
    // Queue families that use the images of distances and the packed distances: the family of the queue to
    // which you submit recordings, and the families of the readers. If this lists different families, no
    // ownership transfers are needed. If it is empty, other families need ownership transfers.
    const uint32_t *queue_families;
    // Number of queue families.
    uint32_t queue_family_count;
    // Your own images for the distances, one per slot; null for images that the surface allocates.
    const struct GeosweepHostImage *results;
    // Number of entries in `results`: 0 or the number of slots.
    uint32_t result_count;
    // Points that recordings select by number, for instance one entry for each frame in flight.
    const struct GeosweepPoints *points;
    // Number of entries in `points`.
    uint32_t point_count;
    // Source buffers that recordings select by number.
    const struct GeosweepSourceBuffer *sources;
    // Number of entries in `sources`.
    uint32_t source_count;
    // Buffers for lookups, which recordings select by number.
    const struct GeosweepLookup *lookups;
    // Number of entries in `lookups`.
    uint32_t lookup_count;
    // Sides of the grid that coincide, so that distances pass from one to the other. Copies of a point take
    // the values of the first copy, and are holes if any copy is a hole. `GeosweepOutcome::seam_gap` says how
    // far copies lie apart. Plans for a glued surface need `GeosweepMethod::over_seams`.
    GeosweepGluing gluing;
    // Points that coincide, for `GEOSWEEP_GLUING_RUNS`.
    const struct GeosweepRunPair *runs;
    // Number of entries in `runs`.
    uint32_t run_count;
    // Whether cells may be so skewed that fronts arrive from points more than six rows or columns away. Updates then look
    // for points up to 16 away, which resolves axes of the metric with a ratio of 30 instead of 10.
    // `GeosweepOutcome::unresolved_distance` says whether it is enough. The sides of such a grid cannot be glued.
    bool has_skewed_cells;
    // Name of the surface in labels and names of objects, for debugging tools and the validation layers; null for
    // "surface" and a number. The text is UTF-8, and is not needed after the call.
    const char *name;
} GeosweepSurfaceInfo;

// An image of distances, directions or a log map. Unless it is your own, it belongs to the object that
// returns it and has the usages `SAMPLED` and `TRANSFER_SRC`, for distances `STORAGE` too.
typedef struct GeosweepImage {
    // The image.
    VkImage image;
    // A view of the whole image.
    VkImageView view;
    // `VK_FORMAT_R32_SFLOAT` for distances, with one texel for each grid point: x is the column, and y is
    // the row. Not all devices can filter it.
    VkFormat format;
    // Width and height in texels.
    VkExtent2D extent;
    // Layout of the image after the recording.
    VkImageLayout layout;
} GeosweepImage;

// Distances in the form in which the passes store them: 2 x 2 grid points per texel, with a border. They
// cannot be filtered. The point at row r and column c is component 2 (r mod 2) + c mod 2 of texel (c / 2 +
// border, r / 2 + border) in layer `layer`. A point that no front has reached has 1e30 or more.
typedef struct GeosweepPackedTimes {
    // Image with `VK_FORMAT_R32G32B32A32_SFLOAT`, always in the layout `VK_IMAGE_LAYOUT_GENERAL`. Its view
    // is an array.
    struct GeosweepImage image;
    // Layer of the view.
    uint32_t layer;
    // Width of the border around the grid in texels.
    uint32_t border;
} GeosweepPackedTimes;

// Outcome of a recording's iterations.
typedef struct GeosweepOutcome {
    // Largest relative change of a distance in the last iteration.
    double residual;
    // Number of iterations, or of rounds of tiles, since the start of the map.
    uint32_t iterations;
    // Number of visits since the start of the map, each by one workgroup: to a tile, or to the part of a block of
    // lines that a workgroup updates. A smaller radius takes fewer visits.
    uint32_t visits;
    // Number of grid points that are holes. A point is a hole if one of its values is not finite or too
    // large, if it lies outside an image that is too small, or if its slowness is negative. Compare this
    // with the holes that you made.
    uint32_t holes;
    // Number of edges without a length between points that are not holes. Their points are at the same
    // place, or so far apart that the length overflows single precision. Expect such edges at a pole or a
    // seam. More of them mean that vertices were zeroed or not written yet.
    uint32_t edges_without_length;
    // Number of the map's sources that reach no point: those off the grid, in holes, or with a time that is
    // NaN or not below 1e30. Unused entries of a buffer count too.
    uint32_t passed_over;
    // Largest gap between copies of a point of a glued surface, relative to the longest edge at these copies; 0 if
    // the surface is not glued. It is rounded down by up to a sixteenth. A gap above a twentieth usually means
    // that other sides are glued than those that coincide, or that one of them runs in the reverse order. With
    // `GEOSWEEP_SOLVER_CHECKS`, a gap above a tenth makes the call fail.
    float seam_gap;
    // Fraction of edges at whose ends the surface's normals differ by more than 30 degrees, among about a
    // thousand edges. It is 0 for a metric. Above a tenth, the grid does not resolve the surface, and the
    // map is that of some polyhedron.
    float sharp_edges;
    // Whether the surface turns at random from point to point, as noise does. On such surfaces planar fronts
    // have the smallest errors, and curved ones may arrive early by some hundredths of the distance.
    bool is_rough;
    // Row of the point whose cells are skewed most; see `unresolved_distance`.
    uint32_t unresolved_row;
    // Column of that point.
    uint32_t unresolved_col;
    // Distance in rows and columns of the points from which fronts arrive there, if that is too far away for updates, and
    // 0 if it is not. Fronts may then be late around that point. `GeosweepSurfaceInfo::has_skewed_cells` lets updates
    // look farther. If that is set already, the grid has to follow the direction in which lengths are short.
    uint32_t unresolved_distance;
    // Whether the map has converged, over edges that were measured. If not, `geosweep_record_resume`
    // continues it.
    bool converged;
    // Whether edges have been measured on the device. It is false if the recording that measures them has
    // never run.
    bool measured;
} GeosweepOutcome;

// Method by which a map is computed.
typedef struct GeosweepMethod {
    // Shape of the wavefront.
    GeosweepWavefront wavefront;
    // Order of updates.
    GeosweepSchedule schedule;
    // Relative tolerance. The map has converged after an iteration in which no distance fell by more than
    // this fraction. 1e-4 is below what a picture shows, and 1e-6 is the limit of single precision.
    double tolerance;
    // Largest number of iterations of a map, in all its recordings together; at least 1.
    uint32_t most_iterations;
    // Number of iterations in a recording, from 1 to 256. Iterations after convergence visit nothing. If
    // there are too few, `geosweep_record_resume` continues the map. With tiles, iterations are rounds, and
    // the grid's size limits their number in a recording: 10 at 48 x 48 points, 20 at 120 x 120, 36 at 256 x
    // 256, and never more than 128. `geosweep_plan_iterations` returns the number in the plan.
    uint32_t iterations;
    // 0 for surfaces without a gluing. Any other number is for surfaces with a `GeosweepSurfaceInfo::gluing`: fronts
    // then pass seams after each scan, or each round of tiles.
    uint32_t over_seams;
} GeosweepMethod;

// A source: a place at which the distance, or time, is given. `geosweep_source_at` returns a source with the
// usual values.
typedef struct GeosweepSource {
    // Row, from 0 to rows - 1. It has a fraction between grid points.
    float row;
    // Column, from 0 to cols - 1.
    float col;
    // Distance, or time, at the source; usually 0.
    float time;
    // Curvature of the front at the source, for the curved wavefront. It is 0 if the source is a point,
    // which sources between grid points always are. It is `GEOSWEEP_STRAIGHT` if the grid point is one of
    // many on a straight line. In a buffer, values that are negative, infinite or NaN stand for a point too.
    float curvature;
} GeosweepSource;

// Stages and accesses by which you use a shared resource: one side of a barrier. All zero means that there
// is nothing to wait for. An access without a stage is an error.
typedef struct GeosweepAccess {
    // Pipeline stages.
    VkPipelineStageFlags stages;
    // Kinds of access.
    VkAccessFlags access;
} GeosweepAccess;

// Sources of a recording: an array in the program's memory, which is copied into the command buffer, or, if
// that is null, a buffer.
typedef struct GeosweepSources {
    // Array of sources, or null.
    const struct GeosweepSource *sources;
    // Number of entries in the array, at most 1024. It is 0 if `sources` is null.
    uint32_t count;
    // Number of the surface's source buffer, if there is no array.
    uint32_t buffer;
    // Offset in bytes, added to the offset of the first source in that buffer
    // (`GeosweepSourceBuffer::offset`); a multiple of 4. With a ring buffer, each frame has another offset.
    uint64_t offset;
} GeosweepSources;

// Reader of an image of distances, for the reads in this frame and the earlier reads of the same image. If
// the access is all zero, the image is read on another queue, after a semaphore.
typedef struct GeosweepReader {
    // Stages and accesses of the reader.
    struct GeosweepAccess access;
    // Layout in which the recording leaves the image. It is not `VK_IMAGE_LAYOUT_UNDEFINED`.
    VkImageLayout layout;
} GeosweepReader;

// A grid point at which a map may end.
typedef struct GeosweepTarget {
    // Row, from 0 to rows - 1.
    uint32_t row;
    // Column, from 0 to cols - 1.
    uint32_t col;
} GeosweepTarget;

// Inputs of a frame.
typedef struct GeosweepFrame {
    // Access that has written points and sources since the previous frame, or has used the memory of your
    // own images of distances. The recording always waits for writes by compute shaders and copies. Writes
    // through mapped memory before the submission need no barrier.
    struct GeosweepAccess before;
    // Number of the surface's points that are measured, or `GEOSWEEP_POINTS_UNCHANGED`.
    uint32_t points;
    // Number of the image of distances that is written.
    uint32_t slot;
    // Offset in bytes, added to the offset of these points in their buffer (`GeosweepPoints::offset`); a
    // multiple of 4. With a ring buffer, each frame has another offset.
    uint64_t points_offset;
    // Sources at which fronts start.
    struct GeosweepSources sources;
    // Plan with the passes. The surface's solver must have created it for a grid of the surface's size.
    const struct GeosweepPlan *plan;
    // Reader of the image of distances.
    struct GeosweepReader reader;
    // Value in the image at points that no front reaches: `INFINITY` or a negative number. Filters turn
    // infinity to NaN beside such points. It must not be NaN, nor a number that may be a distance.
    float unreached;
    // Largest distance of the map, or 0 for no limit. Points that are farther are not reached. The work is
    // proportional to the area within the radius. Each frame may have another radius.
    float radius;
    // Number of nearest targets whose distances are needed, at most `target_count`, or 0 for all targets.
    uint32_t targets_needed;
    // Targets, or null. The map ends once no front can reach the needed targets earlier, and points farther
    // than these are not reached. With raster scans, targets do not reduce the work, since an iteration brings
    // early and late fronts in any order. Only a radius reduces it.
    const struct GeosweepTarget *targets;
    // Number of targets, at most 1024. It is 0 if `targets` is null.
    uint32_t target_count;
    // Profile that records the passes of this frame, or null. A profile records one frame at a time: its
    // previous frame must have run.
    const struct GeosweepProfile *profile;
} GeosweepFrame;

// Record of a curve. In the buffer it begins with a `VkDrawIndirectCommand`.
// `geosweep_curve_record_from_bytes` reads all of it.
typedef struct GeosweepCurveRecord {
    // State of the curve.
    enum GeosweepCurveStatus status;
    // Number of vertices that are drawn. Contours draw the vertices that there was room for; a path draws
    // all its vertices or none.
    uint32_t vertex_count;
    // Index of the curve's first vertex, counted from the first vertex of the first curve.
    uint32_t first_vertex;
    // Number of vertices. For contours, this is the number that all contours need; for a path, the number up
    // to where the path ends.
    uint32_t vertices;
    // Index of the source at which a path has arrived, in the order in which sources were given. It is
    // `GEOSWEEP_NO_SOURCE` if there is none.
    uint32_t source;
    // Distance at the start of a path.
    float distance;
    // Length of a path up to where it ends, measured in the same way as the map.
    float length;
} GeosweepCurveRecord;

// Buffer in which contours or paths are stored. Unless it is your own, it belongs to the contours or paths
// and has the usages `VERTEX_BUFFER`, `INDIRECT_BUFFER`, `STORAGE_BUFFER` and `TRANSFER_SRC`.
//
// `vkCmdDrawIndirect` draws curve k with an offset of k x `GEOSWEEP_CURVE_RECORD_BYTES`. Contours are a list
// of lines, and a path is a strip of lines. Bind the buffer as a vertex buffer with an offset of
// `vertices_offset`.
typedef struct GeosweepCurves {
    // The buffer: records from its first byte, then vertices.
    VkBuffer buffer;
    // Offset of the first vertex in bytes.
    uint64_t vertices_offset;
    // Number of curves, and thus of records. It is 1 for contours.
    uint32_t curves;
    // Largest number of vertices of each curve.
    uint32_t capacity;
} GeosweepCurves;

// Levels of the contours that a recording finds, and the commands that read them. The levels are a list or,
// if `levels` is null, the multiples of a step.
typedef struct GeosweepContourFrame {
    // Levels in ascending order, or null.
    const float *levels;
    // Number of levels, at most 1024. Levels beyond the map's largest distance cost next to nothing.
    uint32_t level_count;
    // Distance between levels if there is no list. It is positive, and it is the first level too.
    float step;
    // Smallest time of the map's sources, usually 0.
    float start;
    // Number of the surface's points to which contours are lifted.
    uint32_t points;
    // Offset in bytes, added to the offset of these points in the surface's buffer, as
    // `GeosweepFrame::points_offset`.
    uint64_t points_offset;
    // Stages and accesses that read the contours, in this frame and in the frame before. Usually these are
    // the stages `VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT` and `VK_PIPELINE_STAGE_VERTEX_INPUT_BIT` with
    // `VK_ACCESS_INDIRECT_COMMAND_READ_BIT` and `VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT`.
    struct GeosweepAccess reader;
} GeosweepContourFrame;

// Starts and ends of paths, and the commands that read the paths. The starts are an array in the program's
// memory, which is copied into the command buffer, or, if `starts` is null, in a buffer.
typedef struct GeosweepPathFrame {
    // Access that has written starts and sources.
    struct GeosweepAccess before;
    // Array with two floats per start, row and column; or null. A start that is off the grid or NaN has no
    // path.
    const float *starts;
    // Buffer of starts with usage `VK_BUFFER_USAGE_TRANSFER_SRC_BIT`, or null.
    VkBuffer start_buffer;
    // Offset of the first start in the buffer in bytes; a multiple of 4.
    uint64_t start_offset;
    // Number of starts. It is at most the number of paths that there is room for, and at most 8192 in an
    // array. The records of the remaining paths say that they have no start, and these paths draw nothing.
    uint32_t start_count;
    // Number of the surface's points to which paths are lifted.
    uint32_t points;
    // Offset in bytes, added to the offset of these points in the surface's buffer, as
    // `GeosweepFrame::points_offset`.
    uint64_t points_offset;
    // All sources of the map, including those that were added to the map.
    struct GeosweepSources sources;
    // Access that reads the paths, in this frame and in the previous one, as in `GeosweepContourFrame`.
    struct GeosweepAccess reader;
} GeosweepPathFrame;

// Buffer of labels. Unless it is your own, it has the usages `STORAGE_BUFFER`, `VERTEX_BUFFER` and
// `TRANSFER_SRC`. From its first byte it has an unsigned 32-bit number for each grid point, row by row.
typedef struct GeosweepLabels {
    // The buffer, which is longer than the labels. Unless it is your own, it belongs to the regions.
    VkBuffer buffer;
    // Bytes of all labels: 4 x rows x cols.
    uint64_t bytes;
} GeosweepLabels;

// Sources whose regions a recording finds, and the commands that read the labels.
typedef struct GeosweepRegionFrame {
    // Access that has written the sources.
    struct GeosweepAccess before;
    // All sources of the map, including those that were added to the map. A source's index in this list is
    // its label.
    struct GeosweepSources sources;
    // Access that reads the labels, in this frame and in the previous one.
    struct GeosweepAccess reader;
} GeosweepRegionFrame;

// Sources to which ways lead back, and the commands that read the image.
typedef struct GeosweepDirectionFrame {
    // Access that has written the sources.
    struct GeosweepAccess before;
    // All sources of the map, including those that were added to the map.
    struct GeosweepSources sources;
    // Access that reads the image, in this frame and in the previous one, and its layout.
    struct GeosweepReader reader;
} GeosweepDirectionFrame;

// Sources of the log map, and the commands that read the image.
typedef struct GeosweepLogMapFrame {
    // Access that has written the sources.
    struct GeosweepAccess before;
    // All sources of the map, including those that were added to the map.
    struct GeosweepSources sources;
    // Access that reads the image, in this frame and in the previous one, and its layout.
    struct GeosweepReader reader;
    // Largest distance of points that get coordinates; 0 for no limit. If sources start at different times,
    // the distance counts from the latest of these.
    float radius;
    // Value of u and v at points that are not reached or beyond the radius. It is no coordinate: infinite, NaN, or
    // with a size beyond the radius, beyond 1e6 if there is no limit. 0 is the place of the source.
    float unreached;
} GeosweepLogMapFrame;

// A map on the CPU: its surface, its sources, and the part of it that is needed.
typedef struct GeosweepMapInfo {
    // Number of rows of grid points.
    uint32_t rows;
    // Number of columns of grid points.
    uint32_t cols;
    // Points in the program's memory: `points.data` is not null.
    struct GeosweepPoints points;
    // Rule by which edges are measured.
    GeosweepEdgeRule edge_rule;
    // Shape of the wavefront.
    GeosweepWavefront wavefront;
    // Point sources. Their `curvature` is not used.
    const struct GeosweepSource *sources;
    // Number of sources; at least 1.
    uint32_t source_count;
    // Number of targets, or 0 for no targets.
    uint32_t target_count;
    // Targets, two numbers each: row and column of a grid point. The map ends when the nearest
    // `targets_needed` of them have their distances. Points that are farther than these targets are not
    // reached.
    const uint32_t *targets;
    // Number of targets whose distances are needed, or 0 for all of them.
    uint32_t targets_needed;
    // Largest distance of the map, or 0 for no limit. Points that are farther are not reached.
    double radius;
} GeosweepMapInfo;

// Arrays to which a map on the CPU is written, row by row. Each may be null.
typedef struct GeosweepMapOutputs {
    // Distances: a float for each point, `INFINITY` where no source reaches.
    float *distances;
    // The way back from each point: two floats, the changes of row and column of a step of length 1 in grid
    // steps. It is 0 at sources and NaN where no source reaches.
    float *back_directions;
    // The next grid point on the way back: 0 at sources, 1 to 8 for the neighbours clockwise from east, -1
    // where no source reaches.
    int8_t *back_links;
    // The index of the nearest source, or -1.
    int32_t *nearest;
    // The log map: two floats for each point, the direction in which its shortest path leaves the source
    // times the distance. The first is the component in the direction of increasing columns, the second the
    // component at a right angle to it, on the side of increasing rows. NaN where no source reaches. The
    // computation takes nine maps in double precision.
    float *log_map;
    // Distances that are negative where `inside` is not 0.
    float *signed_distances;
    // Points inside, for `signed_distances`: a byte for each point, 0 outside.
    const uint8_t *inside;
} GeosweepMapOutputs;

// A pass of a frame, or several passes that are timed together. Unknown members are `GEOSWEEP_UNKNOWN`.
typedef struct GeosweepPass {
    // Name of the pass in captures, such as "scan down". It is never freed.
    const char *name;
    // Iteration or round of tiles to which the pass belongs, from 0. It is `UINT32_MAX` outside iterations.
    uint32_t iteration;
    // Number of dispatches; 0 for copies and clears.
    uint32_t dispatches;
    // Time on the device in nanoseconds, from the end of the previous pass to the end of this one. It
    // includes the barrier between them.
    uint64_t nanoseconds;
    // Bytes that the pass had to read, each counted once.
    uint64_t bytes_read;
    // Bytes that the pass had to write.
    uint64_t bytes_written;
    // Number of texels of 2 x 2 points that the pass visited.
    uint64_t texels;
    // Whether the pass was dispatched and visited nothing, since the map had converged or nothing could
    // change where the pass works.
    bool is_idle;
} GeosweepPass;

// Vertex of a contour or path in the buffer. A pipeline has three attributes for it, with the formats
// `VK_FORMAT_R32G32B32_SFLOAT`, `VK_FORMAT_R32_SFLOAT` and `VK_FORMAT_R32G32_SFLOAT` at the offsets 0, 12
// and 16.
typedef struct GeosweepCurveVertex {
    // Coordinates x, y and z on the surface.
    float position[3];
    // Distance at the vertex. For a contour, this is its level.
    float time;
    // Row on the grid, with its fraction.
    float row;
    // Column on the grid, with its fraction.
    float col;
} GeosweepCurveVertex;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Returns why the last failed call on this thread failed: a sentence in UTF-8 of at most 2047 bytes. It is
// empty if no call has failed. The pointer is valid as long as the thread lives, and the text until the
// thread's next call that fails.
const char *geosweep_last_error(void);

// Returns the requirements for the instance and the device.
enum GeosweepStatus geosweep_requirements(struct GeosweepRequirements *requirements);

// Checks whether a physical device can be used, before a device is created on it. If not, the status is
// `GEOSWEEP_STATUS_UNSUPPORTED`, and the message lists all that is missing. An instance that was created for
// Vulkan 1.0 cannot be used either. Only a device shows the version for which its instance was created, so
// this call creates a device and destroys it.
enum GeosweepStatus geosweep_check_device(PFN_vkGetInstanceProcAddr get_instance_proc_addr,
                                          VkInstance instance,
                                          VkPhysicalDevice physical_device);

// Finds a queue family for compute. Prefers a family without graphics, which is the one for asynchronous
// compute on large GPUs. Any family with `VK_QUEUE_COMPUTE_BIT` can be used.
enum GeosweepStatus geosweep_compute_queue_family(PFN_vkGetInstanceProcAddr get_instance_proc_addr,
                                                  VkInstance instance,
                                                  VkPhysicalDevice physical_device,
                                                  uint32_t *family);

// Returns the schedule that `GEOSWEEP_SCHEDULE_BEST` stands for on a device, for grids of `rows` rows and
// `cols` columns. It tells which schedule to create a solver for.
enum GeosweepStatus geosweep_best_schedule(PFN_vkGetInstanceProcAddr get_instance_proc_addr,
                                           VkInstance instance,
                                           VkPhysicalDevice physical_device,
                                           uint32_t rows,
                                           uint32_t cols,
                                           GeosweepSchedule *schedule);

// Creates a solver. `geosweep_solver_destroy` destroys it.
enum GeosweepStatus geosweep_solver_create(const struct GeosweepSolverInfo *info,
                                           struct GeosweepSolver **solver);

// Sets the cache for creating pipelines from now on, or none if it is null. `GeosweepSolverInfo` documents
// how it is used.
enum GeosweepStatus geosweep_solver_set_pipeline_cache(const struct GeosweepSolver *solver,
                                                       VkPipelineCache cache);

// Returns the bytes of device memory that the solver holds for its surfaces, contours, paths, regions,
// directions and log maps. Since it allocates them in blocks, they are a little more than the sum of what
// `geosweep_surface_bytes` and the similar calls return.
enum GeosweepStatus geosweep_solver_bytes(const struct GeosweepSolver *solver,
                                          uint64_t *bytes);

// Destroys a solver. Its surfaces, plans, contours, paths, regions, directions, log maps and profiles must
// be destroyed first; otherwise the call fails. Null is allowed.
enum GeosweepStatus geosweep_solver_destroy(struct GeosweepSolver *solver);

// Computes the bytes of device memory that a surface will take, before it is created: 36 per grid point and
// 4 more for each slot; a buffer of 16 per point up to 4 MiB, or on larger grids of 6 per point up to 16
// MiB; and, for points in the program's memory, 12 per point (4 for heights), with a slowness 4 more.
enum GeosweepStatus geosweep_surface_bytes_for(const struct GeosweepSolver *solver,
                                               const struct GeosweepSurfaceInfo *info,
                                               uint64_t *bytes);

// Creates a surface. Allocates device memory. `geosweep_surface_destroy` destroys the surface.
enum GeosweepStatus geosweep_surface_create(const struct GeosweepSolver *solver,
                                            const struct GeosweepSurfaceInfo *info,
                                            struct GeosweepSurface **surface);

// Returns the bytes of device memory that a surface takes.
enum GeosweepStatus geosweep_surface_bytes(const struct GeosweepSurface *surface, uint64_t *bytes);

// Replaces points that were copied from the program's memory by others with the same offset and stride. No
// submitted work may still read the old points; a solver with checks verifies that. So create the surface
// with one entry of points for each frame in flight. Later recordings that measure these points read the new
// values.
enum GeosweepStatus geosweep_surface_write_points(struct GeosweepSurface *surface,
                                                  uint32_t number,
                                                  const float *data,
                                                  const uint8_t *mask);

// Replaces points in your own buffer or image by others, which later recordings read. The new points may
// have a slowness only if some points of the surface had a slowness when the surface was created. Frames in
// flight continue to read the points for which they were recorded, so keep these alive until the frames have
// run. It is an error if more frames are in flight than the surface has slots. Edges keep the lengths of the
// old points until they are measured. Contours and paths are lifted to the new points after
// `geosweep_contours_rebind` and `geosweep_paths_rebind`. Command buffers that are submitted repeatedly must
// be recorded anew.
enum GeosweepStatus geosweep_surface_set_points(struct GeosweepSurface *surface,
                                                uint32_t number,
                                                const struct GeosweepPoints *points);

// Replaces a buffer of sources, as `geosweep_surface_set_points` does for points. Paths, regions, directions
// and log maps then need `geosweep_paths_rebind`, `geosweep_regions_rebind`, `geosweep_directions_rebind`
// and `geosweep_log_map_rebind`.
enum GeosweepStatus geosweep_surface_set_sources(struct GeosweepSurface *surface,
                                                 uint32_t number,
                                                 const struct GeosweepSourceBuffer *sources);

// Replaces your own image for the distances of a slot. The surface must have been created with your images.
// Later recordings write the new image, and frames in flight continue to write the old one. Replace an
// image at most once for each recording of its slot.
enum GeosweepStatus geosweep_surface_set_result(struct GeosweepSurface *surface,
                                                uint32_t slot,
                                                const struct GeosweepHostImage *image);

// Returns the image of distances of a slot. `layout` is the layout of the reader for which the image was
// recorded last.
enum GeosweepStatus geosweep_surface_result(const struct GeosweepSurface *surface,
                                            uint32_t slot,
                                            VkImageLayout layout,
                                            struct GeosweepImage *result);

// Returns the packed distances that all slots share. Until the next recording, these are the distances of
// the last one. Read them after `geosweep_record_end`.
enum GeosweepStatus geosweep_surface_packed(const struct GeosweepSurface *surface,
                                            struct GeosweepPackedTimes *packed);

// Returns the outcome of the last recording for a slot, after the fence of its submission. If that recording
// has not run, the status is `GEOSWEEP_STATUS_NOT_READY`.
enum GeosweepStatus geosweep_surface_outcome(const struct GeosweepSurface *surface,
                                             uint32_t slot,
                                             struct GeosweepOutcome *outcome);

// Tells a solver with checks that the last recording for a slot was discarded and will never run.
enum GeosweepStatus geosweep_surface_discard(const struct GeosweepSurface *surface, uint32_t slot);

// Tells a solver with checks that the last recording for the surface into a command buffer was discarded and
// will never run, whatever its kind.
enum GeosweepStatus geosweep_surface_discard_commands(const struct GeosweepSurface *surface,
                                                      VkCommandBuffer commands);

// Destroys a surface with its images. No submitted work may still use it; a solver with checks verifies
// that. Null is allowed.
enum GeosweepStatus geosweep_surface_destroy(struct GeosweepSurface *surface);

// Creates a plan for surfaces of `rows` rows and `cols` columns. `geosweep_plan_destroy` destroys it.
enum GeosweepStatus geosweep_plan_create(const struct GeosweepSolver *solver,
                                         uint32_t rows,
                                         uint32_t cols,
                                         const struct GeosweepMethod *method,
                                         struct GeosweepPlan **plan);

// Returns the number of iterations, or rounds of tiles, in a recording of the plan. It is the number
// requested, but at most `GeosweepMethod::most_iterations`, and with tiles it may be smaller. Resume the map
// until it has converged.
enum GeosweepStatus geosweep_plan_iterations(const struct GeosweepPlan *plan,
                                             uint32_t *iterations);

// Returns the schedule of a plan, a `GeosweepSchedule`. For `GEOSWEEP_SCHEDULE_BEST`, it is the schedule
// that was chosen.
enum GeosweepStatus geosweep_plan_schedule(const struct GeosweepPlan *plan,
                                           GeosweepSchedule *schedule);

// Returns the wavefront of a plan's maps, a `GeosweepWavefront`. It may differ from the one requested.
enum GeosweepStatus geosweep_plan_wavefront(const struct GeosweepPlan *plan,
                                            GeosweepWavefront *wavefront);

// Destroys a plan. Recorded command buffers do not need it. Null is allowed.
enum GeosweepStatus geosweep_plan_destroy(struct GeosweepPlan *plan);

// Returns a source at a place, with distance 0.
struct GeosweepSource geosweep_source_at(float row, float col);

// Prepares a new surface. Record this once, before anything else of that surface.
enum GeosweepStatus geosweep_record_prepare(const struct GeosweepSurface *surface,
                                            VkCommandBuffer commands);

// Records all parts of a usual frame: `begin`, `measure` if there are new points, `solve`, `outcome` and
// `result`. Writes the image of distances to `result` unless that is null.
enum GeosweepStatus geosweep_record_frame(const struct GeosweepSurface *surface,
                                          VkCommandBuffer commands,
                                          const struct GeosweepFrame *frame,
                                          struct GeosweepImage *result);

// Records frames of several surfaces so that they run at the same time. Each is recorded as
// `geosweep_record_frame` does, and the passes of all frames share barriers. `count` surfaces of one size
// and plan thus need only the barriers of one surface. Frames that are recorded one after another also run
// one after another. `surfaces` and `frames` have `count` entries, at most 64. All surfaces belong to one
// solver, none is listed twice, and no frame has a profile. No two frames write the same image of yours.
// Writes the images of distances to `results`, which has room for `count`, unless that is null.
enum GeosweepStatus geosweep_record_frames(const struct GeosweepSurface *const *surfaces,
                                           const struct GeosweepFrame *frames,
                                           uint32_t count,
                                           VkCommandBuffer commands,
                                           struct GeosweepImage *results);

// Begins a frame that is recorded by several calls. Waits for what you have written, and for earlier
// recordings of this surface.
enum GeosweepStatus geosweep_record_begin(const struct GeosweepSurface *surface,
                                          VkCommandBuffer commands,
                                          struct GeosweepAccess before);

// Measures the surface's edges from the points with this number. Invalidates the map, so
// `geosweep_record_solve` comes next. `offset` is as `GeosweepFrame::points_offset`.
enum GeosweepStatus geosweep_record_measure(const struct GeosweepSurface *surface,
                                            VkCommandBuffer commands,
                                            uint32_t points,
                                            uint64_t offset);

// Computes a new map with the plan's number of iterations. Iterations after convergence are skipped.
enum GeosweepStatus geosweep_record_solve(const struct GeosweepSurface *surface,
                                          VkCommandBuffer commands,
                                          const struct GeosweepSources *sources,
                                          const struct GeosweepPlan *plan);

// Adds sources to the map. The map must have converged, with the same wavefront.
enum GeosweepStatus geosweep_record_add(const struct GeosweepSurface *surface,
                                        VkCommandBuffer commands,
                                        const struct GeosweepSources *sources,
                                        const struct GeosweepPlan *plan);

// Continues a map that may not have converged, by the plan's number of iterations. Record this in the same
// command buffer or, for long maps, in later ones, with `begin` before and `outcome` and `result` after it.
// The plan must be the one with which the map was started.
enum GeosweepStatus geosweep_record_resume(const struct GeosweepSurface *surface,
                                           VkCommandBuffer commands,
                                           const struct GeosweepPlan *plan);

// Copies the outcome of the iterations to the slot's record, for `geosweep_surface_outcome`.
enum GeosweepStatus geosweep_record_outcome(const struct GeosweepSurface *surface,
                                            VkCommandBuffer commands,
                                            uint32_t slot);

// Copies the outcome of the iterations to your own buffer with usage `VK_BUFFER_USAGE_TRANSFER_DST_BIT`. It
// copies `GEOSWEEP_OUTCOME_BYTES` bytes, which `geosweep_outcome_from_bytes` reads. Shaders find the number
// of iterations in the third 32-bit number. `after` is the access by which you read the bytes; `offset` is a
// multiple of 4.
enum GeosweepStatus geosweep_record_outcome_to(const struct GeosweepSurface *surface,
                                               VkCommandBuffer commands,
                                               VkBuffer buffer,
                                               uint64_t offset,
                                               struct GeosweepAccess after);

// Reads the record of `GEOSWEEP_OUTCOME_BYTES` bytes that `geosweep_record_outcome_to` has copied. It is an
// error if the bytes belong to another surface, or if the surface's preparation has not run.
enum GeosweepStatus geosweep_outcome_from_bytes(const struct GeosweepSurface *surface,
                                                const uint8_t *bytes,
                                                struct GeosweepOutcome *outcome);

// Writes the map to the slot's image of distances, for a reader. Waits for the reads by `reader` in earlier
// commands; the reads in later commands wait for this. Writes the image to `result` unless that is null.
enum GeosweepStatus geosweep_record_result(const struct GeosweepSurface *surface,
                                           VkCommandBuffer commands,
                                           uint32_t slot,
                                           struct GeosweepReader reader,
                                           float unreached,
                                           struct GeosweepImage *result);

// Looks up distances by the surface's lookup with this number. Between grid points, distances are
// interpolated bilinearly. Where no front arrives and off the grid, they are `unreached`. Waits for your
// writes by the access `before`; `after` is the access by which you read the distances.
enum GeosweepStatus geosweep_record_lookup(const struct GeosweepSurface *surface,
                                           VkCommandBuffer commands,
                                           uint32_t number,
                                           float unreached,
                                           struct GeosweepAccess before,
                                           struct GeosweepAccess after);

// Ends a frame, so that commands in the stages of `after` may read the packed distances, or overwrite points
// and sources.
enum GeosweepStatus geosweep_record_end(const struct GeosweepSurface *surface,
                                        VkCommandBuffer commands,
                                        struct GeosweepAccess after);

// Reads the record of a curve from `GEOSWEEP_CURVE_RECORD_BYTES` bytes that you have copied from the buffer.
enum GeosweepStatus geosweep_curve_record_from_bytes(const uint8_t *bytes,
                                                     struct GeosweepCurveRecord *record);

// Computes the bytes of device memory that contours will take, before they are created: 24 per vertex and
// 260 per row of the grid.
enum GeosweepStatus geosweep_contours_bytes_for(const struct GeosweepSolver *solver,
                                                uint32_t rows,
                                                uint32_t cols,
                                                uint32_t vertices,
                                                uint64_t *bytes);

// Creates contours of a surface with room for `vertices` vertices. Each piece of a contour between grid
// lines has two vertices. Allocates device memory and compiles passes. `geosweep_contours_destroy` destroys
// the contours.
enum GeosweepStatus geosweep_contours_create(const struct GeosweepSurface *surface,
                                             uint32_t vertices,
                                             struct GeosweepContours **contours);

// Computes the bytes that your own buffer for contours must have, if you provide one.
enum GeosweepStatus geosweep_contours_buffer_bytes(uint32_t vertices, uint64_t *bytes);

// Creates contours as `geosweep_contours_create` does, in your own buffer from its first byte. The buffer's
// usage contains `VK_BUFFER_USAGE_STORAGE_BUFFER_BIT` and what its readers need, device addresses included.
// The buffer remains yours. While no contours are in use, a render graph may use its memory for other
// resources.
enum GeosweepStatus geosweep_contours_create_into(const struct GeosweepSurface *surface,
                                                  uint32_t vertices,
                                                  VkBuffer buffer,
                                                  struct GeosweepContours **contours);

// Makes contours write to another buffer of yours in later recordings. The contours must have been created
// with your own buffer. Recordings in flight continue to use the previous buffer.
enum GeosweepStatus geosweep_contours_set_buffer(struct GeosweepContours *contours,
                                                 const struct GeosweepSurface *surface,
                                                 VkBuffer buffer);

// Returns the bytes of device memory that contours take.
enum GeosweepStatus geosweep_contours_bytes(const struct GeosweepContours *contours,
                                            uint64_t *bytes);

// Returns where contours are stored, also before any are recorded. They are one curve, drawn as a list of
// lines.
enum GeosweepStatus geosweep_contours_curves(const struct GeosweepContours *contours,
                                             struct GeosweepCurves *curves);

// Records the search for the contours of the map. Lifts them to the surface and stores them for you to draw.
// Equal maps give equal contours in equal order. Call this after the map was recorded, in the same command
// buffer or after `geosweep_record_begin`. If there is not enough room for all vertices, the southern
// contours are left out, and the record has the number of vertices that all contours need. Writes where
// contours are stored to `result` unless that is null.
enum GeosweepStatus geosweep_record_contours(const struct GeosweepSurface *surface,
                                             VkCommandBuffer commands,
                                             const struct GeosweepContours *contours,
                                             const struct GeosweepContourFrame *frame,
                                             struct GeosweepCurves *result);

// Makes contours read the surface's points that `geosweep_surface_set_points` has set since the contours
// were created. Recordings in flight continue to read the previous points.
enum GeosweepStatus geosweep_contours_rebind(struct GeosweepContours *contours,
                                             const struct GeosweepSurface *surface);

// Destroys contours, before or after their surface. No submitted work may still use them; a solver with
// checks verifies that. Null is allowed.
enum GeosweepStatus geosweep_contours_destroy(struct GeosweepContours *contours);

// Computes the bytes of device memory that paths will take, before they are created: 24 for each vertex of
// each path, and 104 per path.
enum GeosweepStatus geosweep_paths_bytes_for(const struct GeosweepSolver *solver,
                                             uint32_t path_count,
                                             uint32_t vertices,
                                             uint64_t *bytes);

// Creates paths on a surface: `path_count` paths at once, at most 65535, with room for `vertices` vertices
// each. A straight path has one vertex at each grid line that it crosses, so rows + cols + 8 vertices are
// enough on a surface without obstacles. Allocates device memory and compiles passes.
// `geosweep_paths_destroy` destroys the paths.
enum GeosweepStatus geosweep_paths_create(const struct GeosweepSurface *surface,
                                          uint32_t path_count,
                                          uint32_t vertices,
                                          struct GeosweepPaths **paths);

// Computes the bytes that your own buffer for paths must have, if you provide one.
enum GeosweepStatus geosweep_paths_buffer_bytes(uint32_t count, uint32_t vertices, uint64_t *bytes);

// Creates paths as `geosweep_paths_create` does, in your own buffer from its first byte. The buffer's usage
// contains `VK_BUFFER_USAGE_STORAGE_BUFFER_BIT`, `VK_BUFFER_USAGE_TRANSFER_DST_BIT` and what its readers
// need, device addresses included. The buffer remains yours. While no paths are in use, a render graph may
// use its memory for other resources.
enum GeosweepStatus geosweep_paths_create_into(const struct GeosweepSurface *surface,
                                               uint32_t count,
                                               uint32_t vertices,
                                               VkBuffer buffer,
                                               struct GeosweepPaths **paths);

// Makes paths write to another buffer of yours in later recordings. The paths must have been created with
// your own buffer. Recordings in flight continue to use the previous buffer.
enum GeosweepStatus geosweep_paths_set_buffer(struct GeosweepPaths *paths,
                                              const struct GeosweepSurface *surface,
                                              VkBuffer buffer);

// Returns the bytes of device memory that paths take.
enum GeosweepStatus geosweep_paths_bytes(const struct GeosweepPaths *paths, uint64_t *bytes);

// Returns where paths are stored, also before any are recorded. Each path is one curve, drawn as a strip of
// lines.
enum GeosweepStatus geosweep_paths_curves(const struct GeosweepPaths *paths,
                                          struct GeosweepCurves *curves);

// Records the tracing of paths from their starts back to the sources. Lifts them to the surface and stores
// them for you to draw. Call this after the map was recorded, in the same command buffer or after
// `geosweep_record_begin`. The record of a path that cannot be drawn gives the reason. Writes where paths
// are stored to `result` unless that is null.
enum GeosweepStatus geosweep_record_paths(const struct GeosweepSurface *surface,
                                          VkCommandBuffer commands,
                                          const struct GeosweepPaths *paths,
                                          const struct GeosweepPathFrame *frame,
                                          struct GeosweepCurves *result);

// Makes paths read the surface's points and sources that `geosweep_surface_set_points` and
// `geosweep_surface_set_sources` have set since the paths were created. Recordings in flight continue to
// read the previous inputs.
enum GeosweepStatus geosweep_paths_rebind(struct GeosweepPaths *paths,
                                          const struct GeosweepSurface *surface);

// Destroys paths, before or after their surface. No submitted work may still use them; a solver with checks
// verifies that. Null is allowed.
enum GeosweepStatus geosweep_paths_destroy(struct GeosweepPaths *paths);

// Computes the bytes of device memory that regions will take, before they are created: 24 per grid point.
enum GeosweepStatus geosweep_regions_bytes_for(const struct GeosweepSolver *solver,
                                               uint32_t rows,
                                               uint32_t cols,
                                               uint64_t *bytes);

// Creates regions of a surface's maps with one wavefront. Allocates device memory and compiles passes.
// `geosweep_regions_destroy` destroys the regions.
enum GeosweepStatus geosweep_regions_create(const struct GeosweepSurface *surface,
                                            GeosweepWavefront wavefront,
                                            struct GeosweepRegions **regions);

// Computes the bytes that your own buffer for regions must have, if you provide one.
enum GeosweepStatus geosweep_regions_buffer_bytes(uint32_t rows, uint32_t cols, uint64_t *bytes);

// Creates regions as `geosweep_regions_create` does, in your own buffer from its first byte. The buffer's
// usage contains `VK_BUFFER_USAGE_STORAGE_BUFFER_BIT`, `VK_BUFFER_USAGE_TRANSFER_DST_BIT` and what its
// readers need, device addresses included. The buffer remains yours. While no regions are in use, a render
// graph may use its memory for other resources.
enum GeosweepStatus geosweep_regions_create_into(const struct GeosweepSurface *surface,
                                                 GeosweepWavefront wavefront,
                                                 VkBuffer buffer,
                                                 struct GeosweepRegions **regions);

// Makes regions write to another buffer of yours in later recordings. The regions must have been created
// with your own buffer. Recordings in flight continue to use the previous buffer.
enum GeosweepStatus geosweep_regions_set_buffer(struct GeosweepRegions *regions,
                                                const struct GeosweepSurface *surface,
                                                VkBuffer buffer);

// Returns the bytes of device memory that regions take.
enum GeosweepStatus geosweep_regions_bytes(const struct GeosweepRegions *regions, uint64_t *bytes);

// Returns where labels are stored, also before any are recorded.
enum GeosweepStatus geosweep_regions_labels(const struct GeosweepRegions *regions,
                                            struct GeosweepLabels *labels);

// Finds the nearest source of each grid point and stores the labels for you to read. A label is the index of
// a source in the list, or `GEOSWEEP_NO_REGION`. Call this after the map was recorded, in the same command
// buffer or after `geosweep_record_begin`. Writes where labels are stored to `result` unless that is null.
enum GeosweepStatus geosweep_record_regions(const struct GeosweepSurface *surface,
                                            VkCommandBuffer commands,
                                            const struct GeosweepRegions *regions,
                                            const struct GeosweepRegionFrame *frame,
                                            struct GeosweepLabels *result);

// Makes regions read the surface's sources that `geosweep_surface_set_sources` has set since the regions
// were created. Recordings in flight continue to read the previous sources.
enum GeosweepStatus geosweep_regions_rebind(struct GeosweepRegions *regions,
                                            const struct GeosweepSurface *surface);

// Destroys regions, before or after their surface. No submitted work may still use them; a solver with
// checks verifies that. Null is allowed.
enum GeosweepStatus geosweep_regions_destroy(struct GeosweepRegions *regions);

// Computes the bytes of device memory that directions will take, before they are created: 12 (8 with an
// image of yours) per grid point.
enum GeosweepStatus geosweep_directions_bytes_for(const struct GeosweepSolver *solver,
                                                  uint32_t rows,
                                                  uint32_t cols,
                                                  uint64_t *bytes);

// Creates directions of a surface, for maps with any wavefront. Allocates device memory and compiles passes.
// Without an `image` of yours, an image is allocated too; it has the format `VK_FORMAT_R16G16_SFLOAT`. Your
// image has at least cols x rows texels of that format, and its usage contains
// `VK_IMAGE_USAGE_TRANSFER_DST_BIT`. `geosweep_directions_destroy` destroys the directions.
enum GeosweepStatus geosweep_directions_create(const struct GeosweepSurface *surface,
                                               const struct GeosweepHostImage *image,
                                               struct GeosweepDirections **directions);

// Makes directions write to another image of yours in later recordings. The directions must have been
// created with an image of yours. Recordings in flight continue to use the previous image.
enum GeosweepStatus geosweep_directions_set_image(struct GeosweepDirections *directions,
                                                  const struct GeosweepHostImage *image);

// Returns the bytes of device memory that directions take.
enum GeosweepStatus geosweep_directions_bytes(const struct GeosweepDirections *directions,
                                              uint64_t *bytes);

// Returns the image, also before any recording writes it. `layout` is the layout of the reader for which the
// image is recorded.
enum GeosweepStatus geosweep_directions_image(const struct GeosweepDirections *directions,
                                              VkImageLayout layout,
                                              struct GeosweepImage *image);

// Finds the direction in which the way back leaves each grid point. Call this after the map was recorded, in
// the same command buffer or after `geosweep_record_begin`. Writes the image to `result` unless that is
// null.
enum GeosweepStatus geosweep_record_directions(const struct GeosweepSurface *surface,
                                               VkCommandBuffer commands,
                                               const struct GeosweepDirections *directions,
                                               const struct GeosweepDirectionFrame *frame,
                                               struct GeosweepImage *result);

// Makes directions read the surface's sources that `geosweep_surface_set_sources` has set since the
// directions were created. Recordings in flight continue to read the previous sources.
enum GeosweepStatus geosweep_directions_rebind(struct GeosweepDirections *directions,
                                               const struct GeosweepSurface *surface);

// Destroys directions, before or after the surface. No submitted work may still use the directions; a solver
// with checks verifies that. Null is allowed.
enum GeosweepStatus geosweep_directions_destroy(struct GeosweepDirections *directions);

// Computes the bytes of device memory that a log map will take, before it is created: 40 (32 with an image
// of yours) per grid point.
enum GeosweepStatus geosweep_log_map_bytes_for(const struct GeosweepSolver *solver,
                                               uint32_t rows,
                                               uint32_t cols,
                                               uint64_t *bytes);

// Creates a log map of a surface, for maps with any wavefront. Allocates device memory and compiles passes.
// Without an `image` of yours, an image is allocated too; it has the format `VK_FORMAT_R32G32_SFLOAT`. Your
// image has at least cols x rows texels of that format, and its usage contains
// `VK_IMAGE_USAGE_TRANSFER_DST_BIT`. `geosweep_log_map_destroy` destroys the log map.
enum GeosweepStatus geosweep_log_map_create(const struct GeosweepSurface *surface,
                                            const struct GeosweepHostImage *image,
                                            struct GeosweepLogMap **log_map);

// Makes a log map write to another image of yours in later recordings. The log map must have been created
// with an image of yours. Recordings in flight continue to use the previous image.
enum GeosweepStatus geosweep_log_map_set_image(struct GeosweepLogMap *log_map,
                                               const struct GeosweepHostImage *image);

// Returns the bytes of device memory that a log map takes.
enum GeosweepStatus geosweep_log_map_bytes(const struct GeosweepLogMap *log_map, uint64_t *bytes);

// Returns the image, also before any recording writes it. `layout` is the layout of the reader for which the
// image is recorded.
enum GeosweepStatus geosweep_log_map_image(const struct GeosweepLogMap *log_map,
                                           VkImageLayout layout,
                                           struct GeosweepImage *image);

// Computes the log map of the sources of the map. Call this after the map was recorded, in the same command
// buffer or after `geosweep_record_begin`. Writes the image to `result` unless that is null.
enum GeosweepStatus geosweep_record_log_map(const struct GeosweepSurface *surface,
                                            VkCommandBuffer commands,
                                            const struct GeosweepLogMap *log_map,
                                            const struct GeosweepLogMapFrame *frame,
                                            struct GeosweepImage *result);

// Makes a log map read the surface's sources that `geosweep_surface_set_sources` has set since the log map
// was created. Recordings in flight continue to read the previous sources.
enum GeosweepStatus geosweep_log_map_rebind(struct GeosweepLogMap *log_map,
                                            const struct GeosweepSurface *surface);

// Destroys a log map, before or after the surface. No submitted work may still use the log map; a solver
// with checks verifies that. Null is allowed.
enum GeosweepStatus geosweep_log_map_destroy(struct GeosweepLogMap *log_map);

// Computes a map on the CPU, without a solver and a device, and writes what is asked for. The call lasts until
// the map is finished. With a radius or targets, only the part of the map that is reached takes time. If the
// targets cannot be reached, the map is whole.
enum GeosweepStatus geosweep_cpu_map(const struct GeosweepMapInfo *info,
                                     const struct GeosweepMapOutputs *outputs);

// Creates a profile for frames of a surface with this plan on a queue of this family.
// `geosweep_profile_destroy` destroys it. If the family's queues cannot write timestamps, the status is
// `GEOSWEEP_STATUS_UNSUPPORTED`.
enum GeosweepStatus geosweep_profile_create(const struct GeosweepSurface *surface,
                                            const struct GeosweepPlan *plan,
                                            GeosweepGrain grain,
                                            uint32_t queue_family,
                                            struct GeosweepProfile **profile);

// Reads the times of the passes of the last frame that was recorded with this profile, after its fence.
// Writes the number of passes to `count`, and at most `capacity` passes to `passes`. If that frame has not
// run, the status is `GEOSWEEP_STATUS_NOT_READY`.
enum GeosweepStatus geosweep_profile_passes(const struct GeosweepProfile *profile,
                                            struct GeosweepPass *passes,
                                            uint32_t capacity,
                                            uint32_t *count);

// Destroys a profile. No submitted work may still use it; a solver with checks verifies that. Null is
// allowed.
enum GeosweepStatus geosweep_profile_destroy(struct GeosweepProfile *profile);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* GEOSWEEP_H */
