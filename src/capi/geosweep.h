/*
 * geosweep: geodesic distance maps on parametric surfaces, recorded into your own Vulkan command
 * buffers. How to build and link the library, and how to use it well: docs/c.md and docs/embedding.md.
 *
 * Once:        geosweep_solver_create, geosweep_surface_create, geosweep_plan_create, and
 *              geosweep_record_prepare into a command buffer.
 * Every frame: geosweep_record_frame, between your passes that write and read. The distances are
 *              then in an image on the device.
 * At the end:  geosweep_surface_destroy, geosweep_plan_destroy, geosweep_solver_destroy, before
 *              your device and instance go.
 *
 * Contours, shortest paths and regions for the same frame, if wanted: geosweep_contours_create and the
 * like once a surface, geosweep_record_contours and the like after the map. What each pass of a frame takes
 * is for a GeosweepProfile to say; names and labels of passes for tools are there wherever you have enabled
 * VK_EXT_debug_utils.
 *
 * Errors. Calls return a GeosweepStatus, and geosweep_last_error says in words what was wrong.
 * A call that fails has made and recorded nothing. What only the device can know stands in the
 * GeosweepOutcome of a frame. While you develop, make the solver with GEOSWEEP_SOLVER_CHECKS.
 *
 * Ownership. Your Vulkan objects stay yours and must outlive what was made from them. Arrays and
 * structs are not needed after the call that takes them. Device memory is taken when surfaces,
 * contours, paths and regions are created, never else, from the solver's own blocks, or from a
 * GeosweepAllocator of yours; geosweep_surface_bytes_for and the like say beforehand how much. No call submits, waits
 * or maps your memory, and recording allocates nothing.
 *
 * Threads. Calls that take a pointer to a const object may run at once on one object: several
 * threads may record, each with a command pool and a surface of its own. The others have the object
 * for themselves.
 *
 * Units. Distances are in the unit of the points. Rows and columns are counted from 0, and arrays
 * are row by row. Start from structs that are all zero: that is the usual choice of every enum, no
 * array, no barrier.
 *
 * This file is generated from src/capi. Do not edit it.
 */


#ifndef GEOSWEEP_H
#define GEOSWEEP_H

#include <stdbool.h>
#include <stdint.h>

// Vulkan's types. With volk, which wants Vulkan's headers without prototypes, include volk.h before this header, or
// define GEOSWEEP_VULKAN_HEADER as <volk.h>; so with any other header that declares them.
#ifdef GEOSWEEP_VULKAN_HEADER
#include GEOSWEEP_VULKAN_HEADER
#else
#include <vulkan/vulkan_core.h>
#endif


// The version of this header, which `geosweep_solver_create` compares with the library's: it
// grows with each change that makes programs compile or run differently.
#define GEOSWEEP_HEADER_VERSION 7

// For `GeosweepSolverInfo::flags`, while you develop: what costs a little is checked as well. With several slots,
// one that is recorded while its last recording has not run is an error, and so is destroying what a recording
// uses, whatever was recorded, or writing points that it reads; objects are told from those destroyed before, of
// which a few bytes are kept. Recordings get a fill and two barriers more for it.
#define GEOSWEEP_SOLVER_CHECKS 1

// For `GeosweepFrame::points`: the points have not changed since the last frame.
#define GEOSWEEP_POINTS_UNCHANGED 4294967295

// For `GeosweepSource::curvature`: the source is one of many grid points on a straight line.
#define GEOSWEEP_STRAIGHT 1e-30

// Bytes of the record that `geosweep_record_outcome_to` copies.
#define GEOSWEEP_OUTCOME_BYTES 68

// Bytes of a curve's record in a `GeosweepCurves`: from draw to draw, and what
// `geosweep_curve_record_from_bytes` reads.
#define GEOSWEEP_CURVE_RECORD_BYTES 36

// For `GeosweepCurveRecord::source`: the path has not arrived at a source.
#define GEOSWEEP_NO_SOURCE 4294967295

// For a label: no source is the nearest, since the point is a hole or no front arrives there.
#define GEOSWEEP_NO_REGION 4294967295

// For a number of a `GeosweepPass`: it is not known.
#define GEOSWEEP_UNKNOWN UINT64_MAX

// What a call has come to. `geosweep_last_error` says the rest in words.
typedef enum GeosweepStatus {
    // Done.
    GEOSWEEP_STATUS_SUCCESS = 0,
    // An argument cannot be used: the message says which one, and why. Nothing was made or
    // recorded.
    GEOSWEEP_STATUS_INVALID_ARGUMENT = 1,
    // The device lacks something that is needed: the message names all of it.
    GEOSWEEP_STATUS_UNSUPPORTED = 2,
    // The grid is too large for the device's images or its memory.
    GEOSWEEP_STATUS_TOO_LARGE = 3,
    // Memory has run out, on the device or in the program.
    GEOSWEEP_STATUS_OUT_OF_MEMORY = 4,
    // The driver has given the device up.
    GEOSWEEP_STATUS_DEVICE_LOST = 5,
    // Another Vulkan call failed: the message names it and what it returned.
    GEOSWEEP_STATUS_VULKAN_ERROR = 6,
    // A defect of geosweep's, which was kept from crossing into your program. What the call was
    // about is in an unknown state: destroy it.
    GEOSWEEP_STATUS_INTERNAL_ERROR = 7,
    // What was asked for is not there yet: ask again after the fence of its submission.
    GEOSWEEP_STATUS_NOT_READY = 8,
} GeosweepStatus;

// What has become of a curve.
typedef enum GeosweepCurveStatus {
    // All of it is there: a path has arrived at a source.
    GEOSWEEP_CURVE_STATUS_COMPLETE = 0,
    // There are more vertices than there is room for.
    GEOSWEEP_CURVE_STATUS_OUT_OF_ROOM = 1,
    // A path starts where no front arrives: in a hole, or cut off from the sources.
    GEOSWEEP_CURVE_STATUS_UNREACHED = 2,
    // A path starts off the grid, at what is not a number, or there is no start for it.
    GEOSWEEP_CURVE_STATUS_OUTSIDE = 3,
    // A path ends where the map does not lead on to a source, since it has not converged, belongs
    // to other sources, or has a pit there.
    GEOSWEEP_CURVE_STATUS_LOST = 4,
} GeosweepCurveStatus;

// How the edges between grid points are measured.
typedef enum GeosweepEdgeRule {
    // Along a cubic through the neighbouring points, where the surface is smooth.
    GEOSWEEP_EDGE_RULE_ARC = 0,
    // The straight line: the surface is a polyhedron.
    GEOSWEEP_EDGE_RULE_CHORD = 1,
} GeosweepEdgeRule;

// What is timed by itself. Timestamps take time: the finer the grain, the longer the frame.
typedef enum GeosweepGrain {
    // Scans and rounds of tiles, and the passes around them.
    GEOSWEEP_GRAIN_SCANS = 0,
    // The blocks of lines of each scan.
    GEOSWEEP_GRAIN_BLOCKS = 1,
    // Iterations, and the passes around them.
    GEOSWEEP_GRAIN_ITERATIONS = 2,
    // All of a map from its sources to how it went, and the passes before and after.
    GEOSWEEP_GRAIN_PORTIONS = 3,
} GeosweepGrain;

// What the floats of a grid point are.
typedef enum GeosweepPointKind {
    // Three coordinates, x, y and z.
    GEOSWEEP_POINT_KIND_POSITIONS = 0,
    // A height. The point at row r and column c is (c dx, r dy, height).
    GEOSWEEP_POINT_KIND_HEIGHTS = 1,
    // A metric in index coordinates: rr, rc and cc, such that a step of dr rows and dc columns has
    // the squared length rr dr^2 + 2 rc dr dc + cc dc^2. Positive definite, entries up to 1e12.
    GEOSWEEP_POINT_KIND_METRIC = 2,
} GeosweepPointKind;

// The order of updates. All lead to the same map.
typedef enum GeosweepSchedule {
    // The best on the device for the grid, as far as it is known, of those that the solver was made
    // for. For plans only.
    GEOSWEEP_SCHEDULE_BEST = 0,
    // Four scans over the whole grid, one after another; an iteration is all four.
    GEOSWEEP_SCHEDULE_RASTER = 1,
    // All points at once: for tiny grids.
    GEOSWEEP_SCHEDULE_ALL_POINTS = 2,
    // Scans inside tiles, where something has changed; an iteration is a round of tiles.
    GEOSWEEP_SCHEDULE_TILES = 3,
} GeosweepSchedule;

// The shape of the front that is assumed inside a triangle.
typedef enum GeosweepWavefront {
    // Straight: first-order accurate, the cheapest.
    GEOSWEEP_WAVEFRONT_PLANAR = 0,
    // Circular around a virtual point source: exact on the plane, for point sources.
    GEOSWEEP_WAVEFRONT_POINT_SOURCE = 1,
    // Carries its curvature beside the distance: second-order on curved surfaces and around holes.
    GEOSWEEP_WAVEFRONT_CURVED = 2,
    // Knows the corner or source that it comes from on a straight line: exact over planes with holes that
    // are known to be such. Surfaces on a device are not: there it is curved.
    GEOSWEEP_WAVEFRONT_ANCHORED = 3,
} GeosweepWavefront;

// Room for the contours of a surface, and the passes that find them. Frames in flight on one queue
// share it; with readers on another queue make one for each.
typedef struct GeosweepContours GeosweepContours;

// Room for paths on a surface, and the passes that trace them. Frames in flight on one queue share
// it; with readers on another queue make one for each.
typedef struct GeosweepPaths GeosweepPaths;

// The passes of a recording, for any surface of one size. It may be used by many recordings at
// once, on any thread.
typedef struct GeosweepPlan GeosweepPlan;

// Room for the passes of a frame, with queries and a buffer of its own: one for each frame in flight that is
// profiled.
typedef struct GeosweepProfile GeosweepProfile;

// Room for the regions of a surface's maps, and the passes that find them. Frames in flight on one queue share
// it; with readers on another queue make one for each.
typedef struct GeosweepRegions GeosweepRegions;

// The pipelines of a device, shared by all its surfaces. Any number of threads may use it at once.
typedef struct GeosweepSolver GeosweepSolver;

// A grid on the device: edge lengths and fronts, which all recordings share, and an image of
// distances for each slot.
typedef struct GeosweepSurface GeosweepSurface;

// What instance and device must be created with, for a program to merge with its own wishes.
typedef struct GeosweepRequirements {
    // For `VkApplicationInfo::apiVersion`, which may be higher.
    uint32_t api_version;
    // For `VkDeviceCreateInfo::enabledExtensionCount`. None are needed so far.
    uint32_t device_extension_count;
    // For `VkDeviceCreateInfo::ppEnabledExtensionNames`: as many names, which are never freed. Null
    // if there are none.
    const char *const *device_extensions;
    // For `VkDeviceCreateInfo::pEnabledFeatures`, or for the features of a
    // `VkPhysicalDeviceFeatures2`. None are needed so far.
    VkPhysicalDeviceFeatures features;
} GeosweepRequirements;

// A schedule with a wavefront.
typedef struct GeosweepPasses {
    // Any but `GEOSWEEP_SCHEDULE_BEST`.
    GeosweepSchedule schedule;
    // The wavefront.
    GeosweepWavefront wavefront;
} GeosweepPasses;

// What an image or a buffer needs.
typedef struct GeosweepMemoryRequest {
    // Size, alignment and types of memory.
    VkMemoryRequirements requirements;
    // What the type has to have: device-local, or host-visible and host-coherent.
    VkMemoryPropertyFlags required;
    // What it should have beside these.
    VkMemoryPropertyFlags preferred;
    // Whether it is for a buffer; else it is for an image with optimal tiling.
    bool is_buffer;
    // What it is for, such as "edge lengths"; not needed after the call.
    const char *name;
} GeosweepMemoryRequest;

// A block of device memory.
typedef struct GeosweepMemory {
    // The memory.
    VkDeviceMemory memory;
    // Where the block begins in it, a multiple of the alignment.
    uint64_t offset;
    // Where the block is mapped, and stays so until it is freed, if it has to be host-visible; else it may be
    // null.
    void *mapped;
    // By what you know it: a `VmaAllocation`, say.
    void *handle;
} GeosweepMemory;

// An allocator of yours, for surfaces, contours, paths and regions. Its functions are called by one thread at a
// time, in calls that create and destroy these, and call nothing of geosweep's.
typedef struct GeosweepAllocator {
    // Given to both functions.
    void *user;
    // Finds memory and says where it is; what `memory` points to is all zero before. `VK_SUCCESS` if it has.
    VkResult (*allocate)(void *user,
                         const struct GeosweepMemoryRequest *request,
                         struct GeosweepMemory *memory);
    // Takes a block back, as `allocate` has given it.
    void (*free)(void *user, const struct GeosweepMemory *memory);
} GeosweepAllocator;

// What a solver is made of. All handles stay yours, and must outlive the solver.
typedef struct GeosweepSolverInfo {
    // `GEOSWEEP_HEADER_VERSION`.
    uint32_t header_version;
    // The loader's `vkGetInstanceProcAddr`, or your replacement of it. All functions that are
    // called are found through it.
    PFN_vkGetInstanceProcAddr get_instance_proc_addr;
    // Created for Vulkan 1.1 or later.
    VkInstance instance;
    // One that `geosweep_check_device` is content with.
    VkPhysicalDevice physical_device;
    // Created on it, with what `geosweep_requirements` says.
    VkDevice device;
    // The schedules and wavefronts to make pipelines for: those that plans will ask for. Compiling
    // them takes a while.
    const struct GeosweepPasses *passes;
    // How many.
    uint32_t pass_count;
    // A cache to make pipelines with; null for none. It stays yours to fill, to save and to destroy, and
    // must be alive whenever the solver makes pipelines: now, with the first surface that has a slowness,
    // and when the first contours and paths are made. `geosweep_solver_set_pipeline_cache` takes it back. Pipelines, once made, do not need
    // it. One thread at a time uses it in the solver; if you use it meanwhile, the rules of
    // `vkCreateComputePipelines` hold.
    VkPipelineCache pipeline_cache;
    // `GEOSWEEP_SOLVER_CHECKS`, or 0.
    uint32_t flags;
    // An allocator of yours; null for blocks of the solver's own. The struct is not needed after the call.
    const struct GeosweepAllocator *allocator;
} GeosweepSolverInfo;

// An image of yours for the distances of a slot, in place of one that the surface makes, so that a render graph may give
// its memory to others meanwhile. `VK_FORMAT_R32_SFLOAT`, 2D, of cols x rows texels or more, with usage
// `VK_IMAGE_USAGE_STORAGE_BIT` and that of its readers. What is there is thrown away, whatever its layout is; who has
// used the memory before is waited for by `GeosweepFrame::before`, or by a barrier of yours.
typedef struct GeosweepHostImage {
    // The image.
    VkImage image;
    // A view of it.
    VkImageView view;
} GeosweepHostImage;

// The points of a surface, one a grid point, row by row: in a buffer or an image of yours on the
// device, read whenever a recording measures them, or in the program's memory, copied at once.
// Exactly one of `buffer`, `view` and `data` is not null.
//
// A point on the device with a float that is NaN, infinite or beyond 1e12, or with a negative slowness,
// is a hole. In the program's memory NaN, an infinite slowness and the mask make holes, and the rest is
// an error. Travel is free where the slowness is 0: on the device one below 1e-12 counts as 1e-12.
typedef struct GeosweepPoints {
    // What the first floats of a point are.
    GeosweepPointKind kind;
    // Which float of a point, counted from 0, is its slowness (time per length; distances are then
    // travel times); 0 for 1 everywhere.
    uint32_t slowness;
    // For heights: the distance between columns.
    double dx;
    // For heights: the distance between rows.
    double dy;
    // A buffer with usage `VK_BUFFER_USAGE_STORAGE_BUFFER_BIT`.
    VkBuffer buffer;
    // A 2D view of an image with usage `VK_IMAGE_USAGE_SAMPLED_BIT`, whose texels are the points:
    // columns to the right, rows down.
    VkImageView view;
    // The layout of that image whenever it is read.
    VkImageLayout layout;
    // An array of the program's, which is not needed after the call.
    const float *data;
    // With `data`, if not null: rows x cols bytes, 0 for a hole.
    const uint8_t *mask;
    // Bytes before the first point, in `buffer` or `data`; a multiple of 4.
    uint64_t offset;
    // Bytes from point to point, in `buffer` or `data`; a multiple of 4.
    uint64_t stride;
} GeosweepPoints;

// A buffer of sources, each a `GeosweepSource`, that your shaders write. An entry that is not on
// the grid, in a hole, or has a time that is NaN or not below 1e30 is passed over: write NaN where
// there is none.
typedef struct GeosweepSourceBuffer {
    // With usage `VK_BUFFER_USAGE_STORAGE_BUFFER_BIT`.
    VkBuffer buffer;
    // Bytes before the first; a multiple of 4.
    uint64_t offset;
    // How many.
    uint32_t count;
} GeosweepSourceBuffer;

// Buffers for looking distances up: places in, distances out. Both with usage
// `VK_BUFFER_USAGE_STORAGE_BUFFER_BIT`.
typedef struct GeosweepLookup {
    // Two floats a place, row and column, fractional between grid points.
    VkBuffer places;
    // Bytes before the first; a multiple of 4.
    uint64_t places_offset;
    // One float a place.
    VkBuffer distances;
    // Bytes before the first; a multiple of 4.
    uint64_t distances_offset;
    // How many.
    uint32_t count;
} GeosweepLookup;

// What a surface is made for. Images and buffers stay yours: they must be alive whenever
// a recording that reads them runs. The arrays are not needed after the call, and may be null
// where their count is 0.
typedef struct GeosweepSurfaceInfo {
    // Rows of grid points.
    uint32_t rows;
    // Columns of grid points.
    uint32_t cols;
    // How edges are measured.
    GeosweepEdgeRule edge_rule;
    // How many images of distances there are, to be written in turn: as many as frames in flight,
    // from 1 to 64.
    uint32_t slots;
    // The queue families that use the images of distances and the packed distances: ours and the
    // readers'. If they differ, no ownership needs to be transferred. None: one family at a time
    // uses them.
    const uint32_t *queue_families;
    // How many.
    uint32_t queue_family_count;
    // Images of yours for the distances, one a slot; null for images that the surface makes.
    const struct GeosweepHostImage *results;
    // How many: 0 or as many as slots.
    uint32_t result_count;
    // Where points may come from, by number: one for each frame in flight, say.
    const struct GeosweepPoints *points;
    // How many.
    uint32_t point_count;
    // Buffers that sources may come from, by number.
    const struct GeosweepSourceBuffer *sources;
    // How many.
    uint32_t source_count;
    // Buffers for lookups, by number.
    const struct GeosweepLookup *lookups;
    // How many.
    uint32_t lookup_count;
} GeosweepSurfaceInfo;

// An image, with usage `SAMPLED`, `STORAGE` and `TRANSFER_SRC`, that belongs to its surface.
typedef struct GeosweepImage {
    // The image.
    VkImage image;
    // A view of all of it.
    VkImageView view;
    // `VK_FORMAT_R32_SFLOAT` for distances, a texel a grid point: column to the right, row down.
    // Not all devices filter it.
    VkFormat format;
    // Width and height in texels.
    VkExtent2D extent;
    // The layout that it has after the recording.
    VkImageLayout layout;
} GeosweepImage;

// Distances as the passes keep them: 2 x 2 grid points a texel, in a border. Not for filtering.
// The point at row r and column c is component 2 (r mod 2) + c mod 2 of texel
// (c / 2 + border, r / 2 + border), in layer `layer`. What is not reached is 1e30 or more.
typedef struct GeosweepPackedTimes {
    // `VK_FORMAT_R32G32B32A32_SFLOAT`, always in the layout `VK_IMAGE_LAYOUT_GENERAL`; the view is
    // an array.
    struct GeosweepImage image;
    // Of the view.
    uint32_t layer;
    // Texels around the grid's.
    uint32_t border;
} GeosweepPackedTimes;

// How the iterations of a recording went.
typedef struct GeosweepOutcome {
    // Largest relative change of a distance in the last of them.
    double residual;
    // Iterations since the start of the map, or rounds of tiles.
    uint32_t iterations;
    // How many grid points are holes: those with something that is not finite or too large, beyond an image
    // that is too small, or a slowness that is negative. Compare it with those you have made.
    uint32_t holes;
    // Number of edges without a length between usable points: points at one place, or so far apart that single
    // precision has no such length. A pole or a seam has its own, of which you know; more of them are vertices that were zeroed, or
    // not written yet.
    uint32_t edges_without_length;
    // How many of the map's sources reach no point: off the grid, in holes, or with a time that is no number
    // below 1e30. Unused entries of a buffer count.
    uint32_t passed_over;
    // The share of edges at whose ends the surface's normals differ by more than 30 degrees, of some thousand edges
    // looked at; 0 of a metric. Where it is above a tenth, the grid does not resolve the surface, and the map
    // is that of some polyhedron.
    float sharp_edges;
    // Whether the surface turns at random from point to point, as noise does: planar fronts err least there, and
    // curved ones may be early by some hundredths.
    bool is_rough;
    // Whether the map has converged, over edges that were measured. If not, `geosweep_record_resume` goes on.
    bool converged;
    // Whether edges have been measured on the device: not if the recording that measures them never ran.
    bool measured;
} GeosweepOutcome;

// How a map is computed.
typedef struct GeosweepMethod {
    // The shape of fronts.
    GeosweepWavefront wavefront;
    // The order of updates.
    GeosweepSchedule schedule;
    // The map has converged after an iteration in which no distance fell by more than this
    // fraction; 1e-4 is below what a picture shows, 1e-6 as low as single precision goes.
    double tolerance;
    // Iterations of a map, at most, all its recordings together; at least 1.
    uint32_t most_iterations;
    // Iterations in a recording: from 1 to 256. Those after convergence visit nothing; if they
    // are too few, `geosweep_record_resume` goes on. Tiles count in rounds, of which a recording holds no
    // more than the grid's size says: 8 at 48 x 48 points, 16 at 120 x 120, 32 at 256 x 256, 128 at most.
    // `geosweep_plan_iterations` says how many it holds.
    uint32_t iterations;
} GeosweepMethod;

// A source: a place where the distance, or time, is known. `geosweep_source_at` makes the usual one.
typedef struct GeosweepSource {
    // From 0 to rows - 1, fractional between grid points.
    float row;
    // From 0 to cols - 1.
    float col;
    // The distance, or time, at the source; usually 0.
    float time;
    // Of the front there, for the curved wavefront: 0 where the source is a point, as sources between grid
    // points are in any case; `GEOSWEEP_STRAIGHT` where the grid point is one of many on a straight line. In a
    // buffer, what is negative, infinite or no number stands for a point as well.
    float curvature;
} GeosweepSource;

// How you use what you share with us, as one side of a barrier. All zero: nothing to wait for. An access without a
// stage is an error.
typedef struct GeosweepAccess {
    // In which stages.
    VkPipelineStageFlags stages;
    // Of which kinds.
    VkAccessFlags access;
} GeosweepAccess;

// The sources of a recording: an array of the program's, which is copied into the command buffer,
// or, if that is null, a buffer.
typedef struct GeosweepSources {
    // The array, or null.
    const struct GeosweepSource *sources;
    // Its length, at most 1024; 0 with null.
    uint32_t count;
    // The number of the surface's source buffer, if there is no array.
    uint32_t buffer;
    // Bytes beyond the first source that the surface has in that buffer, as in a ring of which each frame has
    // another part; a multiple of 4.
    uint64_t offset;
} GeosweepSources;

// How you read an image of distances, this frame and whenever you read that image before. With an
// access of all zero you read it on another queue, after a semaphore.
typedef struct GeosweepReader {
    // In which stages, and how.
    struct GeosweepAccess access;
    // The layout in which the image is left.
    VkImageLayout layout;
} GeosweepReader;

// What a frame takes.
typedef struct GeosweepFrame {
    // How you have written points and sources since the frame before: compute shaders and copies
    // are waited for in any case, and what you write through mapped memory before you submit needs
    // nothing.
    struct GeosweepAccess before;
    // Which of the surface's points are measured, or `GEOSWEEP_POINTS_UNCHANGED`.
    uint32_t points;
    // Which image of distances is written.
    uint32_t slot;
    // Bytes beyond where the surface has these points in their buffer, as in a ring of which each frame has another
    // part; a multiple of 4.
    uint64_t points_offset;
    // Where the fronts start.
    struct GeosweepSources sources;
    // The passes, made by the surface's solver for a grid of the surface's size.
    const struct GeosweepPlan *plan;
    // Who reads the image of distances.
    struct GeosweepReader reader;
    // What stands in it where nothing was reached: `INFINITY`, which filters turn to NaN beside
    // such points, or a negative number. Neither 0, which is the distance of sources, nor NaN.
    float unreached;
    // Where the passes of this frame are taken down, or null. One frame at a time: that of the same profile before
    // has run.
    const struct GeosweepProfile *profile;
} GeosweepFrame;

// What is known of a curve. In the buffer it starts with a `VkDrawIndirectCommand`;
// `geosweep_curve_record_from_bytes` reads all of it.
typedef struct GeosweepCurveRecord {
    // What has become of it.
    enum GeosweepCurveStatus status;
    // How many vertices are drawn: of contours those that there was room for, of a path all of them
    // or none.
    uint32_t vertex_count;
    // Its first vertex, counted from that of the first curve.
    uint32_t first_vertex;
    // Of contours how many vertices there would be with room for all; of a path how many there are,
    // as far as it has come.
    uint32_t vertices;
    // Of a path that has arrived: at which source, in the order given; or `GEOSWEEP_NO_SOURCE`.
    uint32_t source;
    // Of a path: the distance at its start.
    float distance;
    // Of a path: its length, measured as the map measures, as far as it has come.
    float length;
} GeosweepCurveRecord;

// Where contours or paths are: a buffer with the usages `VERTEX_BUFFER`, `INDIRECT_BUFFER`,
// `STORAGE_BUFFER` and `TRANSFER_SRC`, which belongs to them.
//
// Curve k is drawn by `vkCmdDrawIndirect` with an offset of k x `GEOSWEEP_CURVE_RECORD_BYTES`,
// contours as a list of lines, a path as a strip of lines, from the buffer bound as a vertex buffer
// with an offset of `vertices_offset`.
typedef struct GeosweepCurves {
    // The buffer: records from its first byte, then vertices.
    VkBuffer buffer;
    // Bytes before the first vertex.
    uint64_t vertices_offset;
    // How many curves, and so records, there are: 1 of contours.
    uint32_t curves;
    // Room for vertices of each curve.
    uint32_t capacity;
} GeosweepCurves;

// Which contours are wanted, and who draws them. Levels are a list, or, if that is null, multiples of
// a step.
typedef struct GeosweepContourFrame {
    // The list, ascending, or null.
    const float *levels;
    // How many levels: at most 1024. Those beyond the map's largest distance cost next to nothing.
    uint32_t level_count;
    // From level to level, without a list; positive, and the first level.
    float step;
    // The smallest time of the map's sources, 0 as a rule.
    float start;
    // The number of the surface's points to which contours are lifted.
    uint32_t points;
    // Bytes beyond where the surface has these points, as `GeosweepFrame::points_offset`.
    uint64_t points_offset;
    // How you read the contours, this frame and the frame before: the stages
    // `VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT` and `VK_PIPELINE_STAGE_VERTEX_INPUT_BIT` with
    // `VK_ACCESS_INDIRECT_COMMAND_READ_BIT` and `VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT` as a rule.
    struct GeosweepAccess reader;
} GeosweepContourFrame;

// Where paths start, where they end, and who draws them. Starts are an array of the program's, which
// is copied into the command buffer, or, if that is null, in a buffer.
typedef struct GeosweepPathFrame {
    // How you have written starts and sources.
    struct GeosweepAccess before;
    // Two floats a start, row and column; or null. One that is off the grid or not a number has no
    // path.
    const float *starts;
    // With usage `VK_BUFFER_USAGE_TRANSFER_SRC_BIT`, or null.
    VkBuffer start_buffer;
    // Bytes before the first in the buffer; a multiple of 4.
    uint64_t start_offset;
    // How many: no more than there is room for, and at most 8192 in an array. Other paths have a
    // record that says so, and draw nothing.
    uint32_t start_count;
    // The number of the surface's points to which paths are lifted.
    uint32_t points;
    // Bytes beyond where the surface has these points, as `GeosweepFrame::points_offset`.
    uint64_t points_offset;
    // All sources of the map, those added to it too.
    struct GeosweepSources sources;
    // How you read the paths, this frame and the frame before, as of `GeosweepContourFrame`.
    struct GeosweepAccess reader;
} GeosweepPathFrame;

// Where labels are: a buffer with the usages `STORAGE_BUFFER`, `VERTEX_BUFFER` and `TRANSFER_SRC`, from its first
// byte: an unsigned 32-bit number for each grid point, row by row.
typedef struct GeosweepLabels {
    // The buffer, which is longer, and belongs to the regions.
    VkBuffer buffer;
    // Bytes of all labels: 4 x rows x cols.
    uint64_t bytes;
} GeosweepLabels;

// Of which sources regions are wanted, and who reads them.
typedef struct GeosweepRegionFrame {
    // How you have written the sources.
    struct GeosweepAccess before;
    // All sources of the map, those added to it too. Their places in this list are the labels.
    struct GeosweepSources sources;
    // How you read the labels, this frame and the frame before.
    struct GeosweepAccess reader;
} GeosweepRegionFrame;

// A pass of a frame, or several that are timed together. What is not known is `GEOSWEEP_UNKNOWN`.
typedef struct GeosweepPass {
    // What it does, as captures name it: "scan down". It is never freed.
    const char *name;
    // The iteration that it belongs to, or the round of tiles, from 0; `UINT32_MAX` outside of iterations.
    uint32_t iteration;
    // Dispatches; none for copies and clears.
    uint32_t dispatches;
    // On the device, from the end of the pass before to the end of this one: the barrier between them counts to
    // this one.
    uint64_t nanoseconds;
    // Bytes that it had to read, each once.
    uint64_t bytes_read;
    // Bytes that it had to write.
    uint64_t bytes_written;
    // Texels of 2 x 2 points that it has visited.
    uint64_t texels;
    // Whether it was dispatched and visited nothing, since the map had converged or nothing could change there.
    bool is_idle;
} GeosweepPass;

// A vertex of a contour or path in the buffer: three attributes of a pipeline, with the formats
// `VK_FORMAT_R32G32B32_SFLOAT`, `VK_FORMAT_R32_SFLOAT` and `VK_FORMAT_R32G32_SFLOAT` at the
// offsets 0, 12 and 16.
typedef struct GeosweepCurveVertex {
    // x, y and z, on the surface.
    float position[3];
    // The distance there, a contour's level.
    float time;
    // Fractional.
    float row;
    // Fractional.
    float col;
} GeosweepCurveVertex;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Why the last call on this thread that failed did so: a sentence in UTF-8 of at most 2047 bytes,
// or an empty one if none has. The pointer stays good as long as the thread, and the text until
// the thread's next call that fails.
const char *geosweep_last_error(void);

// Says what instance and device must be created with.
enum GeosweepStatus geosweep_requirements(struct GeosweepRequirements *requirements);

// Asks whether a physical device will do, before a device is created on it. If not, the status is
// `GEOSWEEP_STATUS_UNSUPPORTED`, and the message names all that is missing. An instance for Vulkan 1.0 will not do
// either, of which devices alone tell: one is created and destroyed.
enum GeosweepStatus geosweep_check_device(PFN_vkGetInstanceProcAddr get_instance_proc_addr,
                                          VkInstance instance,
                                          VkPhysicalDevice physical_device);

// Finds a queue family for compute, one without graphics if there is one: on large GPUs that is
// the asynchronous one. Any family with `VK_QUEUE_COMPUTE_BIT` will do.
enum GeosweepStatus geosweep_compute_queue_family(PFN_vkGetInstanceProcAddr get_instance_proc_addr,
                                                  VkInstance instance,
                                                  VkPhysicalDevice physical_device,
                                                  uint32_t *family);

// Says which schedule `GEOSWEEP_SCHEDULE_BEST` stands for, for grids of so many rows and columns on a device: what
// a solver should be made for, before it is.
enum GeosweepStatus geosweep_best_schedule(PFN_vkGetInstanceProcAddr get_instance_proc_addr,
                                           VkInstance instance,
                                           VkPhysicalDevice physical_device,
                                           uint32_t rows,
                                           uint32_t cols,
                                           GeosweepSchedule *schedule);

// Makes a solver; `geosweep_solver_destroy` destroys it.
enum GeosweepStatus geosweep_solver_create(const struct GeosweepSolverInfo *info,
                                           struct GeosweepSolver **solver);

// Has pipelines be made with this cache from now on, in place of the one before; with none if it is
// null. What `GeosweepSolverInfo` says of it holds.
enum GeosweepStatus geosweep_solver_set_pipeline_cache(const struct GeosweepSolver *solver,
                                                       VkPipelineCache cache);

// Says how many bytes of device memory the solver holds for its surfaces, contours and paths, in
// blocks: a little more than what `geosweep_surface_bytes` and the like say of each.
enum GeosweepStatus geosweep_solver_bytes(const struct GeosweepSolver *solver, uint64_t *bytes);

// Destroys a solver, after its surfaces, plans, contours and paths: while there are any, it is
// refused. Null is fine.
enum GeosweepStatus geosweep_solver_destroy(struct GeosweepSolver *solver);

// Says how many bytes of device memory a surface will take, before it is made: 36 a grid point and
// 4 for each slot, a buffer of 16 a point up to 4 MiB, of 6 a point up to 16 MiB on larger grids, and
// 16 a point (8 for heights) for points in the program's memory.
enum GeosweepStatus geosweep_surface_bytes_for(const struct GeosweepSolver *solver,
                                               const struct GeosweepSurfaceInfo *info,
                                               uint64_t *bytes);

// Makes a surface; `geosweep_surface_destroy` destroys it. Takes device memory.
enum GeosweepStatus geosweep_surface_create(const struct GeosweepSolver *solver,
                                            const struct GeosweepSurfaceInfo *info,
                                            struct GeosweepSurface **surface);

// Says how many bytes of device memory a surface takes.
enum GeosweepStatus geosweep_surface_bytes(const struct GeosweepSurface *surface, uint64_t *bytes);

// Replaces points that were given in the program's memory, by others with the same offset and
// stride. No submitted work may still read them, which a solver with checks looks at: keep as many as there are
// frames in flight. Recordings that measure them find the new ones.
enum GeosweepStatus geosweep_surface_write_points(struct GeosweepSurface *surface,
                                                  uint32_t number,
                                                  const float *data,
                                                  const uint8_t *mask);

// Replaces points in a buffer or an image of yours by others: recordings from now on read these. With a slowness only
// if some points of the surface have had one from the start. Frames in flight go on with the points that they were
// recorded for, which stay alive until these have run. It is an error if more is in flight than the surface has slots.
// Edges are those of the old points until they are measured, and contours and paths are lifted to the new ones
// after `geosweep_contours_rebind` and `geosweep_paths_rebind`. Command buffers that are submitted again and again are
// recorded anew.
enum GeosweepStatus geosweep_surface_set_points(struct GeosweepSurface *surface,
                                                uint32_t number,
                                                const struct GeosweepPoints *points);

// Replaces a buffer that sources may come from, as `geosweep_surface_set_points` does points; paths and regions need
// `geosweep_paths_rebind` and `geosweep_regions_rebind`.
enum GeosweepStatus geosweep_surface_set_sources(struct GeosweepSurface *surface,
                                                 uint32_t number,
                                                 const struct GeosweepSourceBuffer *sources);

// Replaces your image for the distances of a slot, of a surface that was made with images of yours: recordings from now on
// write this one, and frames in flight go on with the one that they were recorded for.
enum GeosweepStatus geosweep_surface_set_result(struct GeosweepSurface *surface,
                                                uint32_t slot,
                                                const struct GeosweepHostImage *image);

// Gives the image of distances of a slot. `layout` is that of the reader for which it was recorded
// last.
enum GeosweepStatus geosweep_surface_result(const struct GeosweepSurface *surface,
                                            uint32_t slot,
                                            VkImageLayout layout,
                                            struct GeosweepImage *result);

// Gives the packed distances that all slots share: those of the last recording until the next. Read
// them after `geosweep_record_end`.
enum GeosweepStatus geosweep_surface_packed(const struct GeosweepSurface *surface,
                                            struct GeosweepPackedTimes *packed);

// Says how the iterations of the last recording for a slot went, after the fence of its submission. If that
// recording has not run, the status is `GEOSWEEP_STATUS_NOT_READY`.
enum GeosweepStatus geosweep_surface_outcome(const struct GeosweepSurface *surface,
                                             uint32_t slot,
                                             struct GeosweepOutcome *outcome);

// Says that the last recording for a slot was thrown away and will never run, to a solver with checks.
enum GeosweepStatus geosweep_surface_discard(const struct GeosweepSurface *surface,
                                             uint32_t slot);

// Says that what was recorded last for the surface into a command buffer was thrown away and will never run, whatever
// it was, to a solver with checks.
enum GeosweepStatus geosweep_surface_discard_commands(const struct GeosweepSurface *surface,
                                                      VkCommandBuffer commands);

// Destroys a surface with its images. No submitted work may still use it, which a solver with checks looks
// at. Null is fine.
enum GeosweepStatus geosweep_surface_destroy(struct GeosweepSurface *surface);

// Makes a plan for surfaces of so many rows and columns; `geosweep_plan_destroy` destroys it.
enum GeosweepStatus geosweep_plan_create(const struct GeosweepSolver *solver,
                                         uint32_t rows,
                                         uint32_t cols,
                                         const struct GeosweepMethod *method,
                                         struct GeosweepPlan **plan);

// Says how many iterations, or rounds of tiles, a recording of the plan holds: as many as were asked for, or
// with tiles fewer. Resume as often as it takes.
enum GeosweepStatus geosweep_plan_iterations(const struct GeosweepPlan *plan,
                                             uint32_t *iterations);

// Says in which schedule the maps of a plan are computed: a `GeosweepSchedule`, what `GEOSWEEP_SCHEDULE_BEST` has
// come to.
enum GeosweepStatus geosweep_plan_schedule(const struct GeosweepPlan *plan,
                                           GeosweepSchedule *schedule);

// Says which wavefront the maps of a plan have: a `GeosweepWavefront`, and not always the one asked for.
enum GeosweepStatus geosweep_plan_wavefront(const struct GeosweepPlan *plan,
                                            GeosweepWavefront *wavefront);

// Destroys a plan. Recorded command buffers do not need it. Null is fine.
enum GeosweepStatus geosweep_plan_destroy(struct GeosweepPlan *plan);

// A source at a place, with distance 0.
struct GeosweepSource geosweep_source_at(float row, float col);

// Prepares a new surface: to be recorded once, before anything else of that surface.
enum GeosweepStatus geosweep_record_prepare(const struct GeosweepSurface *surface,
                                            VkCommandBuffer commands);

// Records all of a usual frame: `begin`, `measure` if there are new points, `solve`, `outcome` and
// `result`. Gives the image of distances to `result` unless that is null.
enum GeosweepStatus geosweep_record_frame(const struct GeosweepSurface *surface,
                                          VkCommandBuffer commands,
                                          const struct GeosweepFrame *frame,
                                          struct GeosweepImage *result);

// Records frames of several surfaces so that they run beside one another: each as `geosweep_record_frame` does, with the
// passes of all between the same barriers. `count` surfaces of one size and plan have the barriers of one: recorded one
// after another they would run one after another. `surfaces` and `frames` have `count` entries, at most 64, and no
// surface is there twice; all are of one solver, and no frame has a profile. Gives the images of distances to
// `results`, which has room for as many, unless that is null.
enum GeosweepStatus geosweep_record_frames(const struct GeosweepSurface *const *surfaces,
                                           const struct GeosweepFrame *frames,
                                           uint32_t count,
                                           VkCommandBuffer commands,
                                           struct GeosweepImage *results);

// Records the start of a frame, one call after another: waits for what you have written, and for
// recordings of this surface before.
enum GeosweepStatus geosweep_record_begin(const struct GeosweepSurface *surface,
                                          VkCommandBuffer commands,
                                          struct GeosweepAccess before);

// Measures the surface's edges from its points with this number. The map is lost: `solve` comes
// next. `offset` is as `GeosweepFrame::points_offset`.
enum GeosweepStatus geosweep_record_measure(const struct GeosweepSurface *surface,
                                            VkCommandBuffer commands,
                                            uint32_t points,
                                            uint64_t offset);

// Computes a new map, with as many iterations as the plan holds, less those after convergence.
enum GeosweepStatus geosweep_record_solve(const struct GeosweepSurface *surface,
                                          VkCommandBuffer commands,
                                          const struct GeosweepSources *sources,
                                          const struct GeosweepPlan *plan);

// Adds sources to the map, which has converged with the same wavefront.
enum GeosweepStatus geosweep_record_add(const struct GeosweepSurface *surface,
                                        VkCommandBuffer commands,
                                        const struct GeosweepSources *sources,
                                        const struct GeosweepPlan *plan);

// Goes on with a map that may not have converged, by as many iterations again: in the same command
// buffer or, for long maps, in later ones, with `begin` before and `outcome` and `result` after it.
// With the plan that the map was started with.
enum GeosweepStatus geosweep_record_resume(const struct GeosweepSurface *surface,
                                           VkCommandBuffer commands,
                                           const struct GeosweepPlan *plan);

// Copies how the iterations have gone to the slot's record, for `geosweep_surface_outcome`.
enum GeosweepStatus geosweep_record_outcome(const struct GeosweepSurface *surface,
                                            VkCommandBuffer commands,
                                            uint32_t slot);

// Copies how the iterations have gone, `GEOSWEEP_OUTCOME_BYTES` bytes for
// `geosweep_outcome_from_bytes`, to a buffer of yours with usage
// `VK_BUFFER_USAGE_TRANSFER_DST_BIT`. Shaders find the number of iterations in the third 32-bit
// number. `after` is how you read them; `offset` is a multiple of 4.
enum GeosweepStatus geosweep_record_outcome_to(const struct GeosweepSurface *surface,
                                               VkCommandBuffer commands,
                                               VkBuffer buffer,
                                               uint64_t offset,
                                               struct GeosweepAccess after);

// Reads the record that `geosweep_record_outcome_to` has copied: `GEOSWEEP_OUTCOME_BYTES` bytes. It is an error
// if they are of another surface, or if the surface's preparation has not run before.
enum GeosweepStatus geosweep_outcome_from_bytes(const struct GeosweepSurface *surface,
                                                const uint8_t *bytes,
                                                struct GeosweepOutcome *outcome);

// Writes the map to the slot's image of distances, for a reader. Waits for the reader of commands
// before; the reader in commands after waits for this. Gives the image to `result` unless that is
// null.
enum GeosweepStatus geosweep_record_result(const struct GeosweepSurface *surface,
                                           VkCommandBuffer commands,
                                           uint32_t slot,
                                           struct GeosweepReader reader,
                                           float unreached,
                                           struct GeosweepImage *result);

// Looks distances up, with the surface's lookup of this number: bilinear between grid points,
// `unreached` where nothing was reached or there is no grid. Waits for what you have written in
// `before`; `after` is how you read the distances.
enum GeosweepStatus geosweep_record_lookup(const struct GeosweepSurface *surface,
                                           VkCommandBuffer commands,
                                           uint32_t number,
                                           float unreached,
                                           struct GeosweepAccess before,
                                           struct GeosweepAccess after);

// Lets you read the packed distances, or overwrite points and sources, in the stages of `after`.
enum GeosweepStatus geosweep_record_end(const struct GeosweepSurface *surface,
                                        VkCommandBuffer commands,
                                        struct GeosweepAccess after);

// Reads the record of a curve that you have copied from the buffer: `GEOSWEEP_CURVE_RECORD_BYTES`
// bytes.
enum GeosweepStatus geosweep_curve_record_from_bytes(const uint8_t *bytes,
                                                     struct GeosweepCurveRecord *record);

// Says how many bytes of device memory contours will take, before they are made: 24 a vertex, and
// 260 a row of the grid.
enum GeosweepStatus geosweep_contours_bytes_for(const struct GeosweepSolver *solver,
                                                uint32_t rows,
                                                uint32_t cols,
                                                uint32_t vertices,
                                                uint64_t *bytes);

// Makes room for contours of a surface, of so many vertices, two for each piece between grid lines;
// `geosweep_contours_destroy` destroys it. Takes device memory and compiles passes.
enum GeosweepStatus geosweep_contours_create(const struct GeosweepSurface *surface,
                                             uint32_t vertices,
                                             struct GeosweepContours **contours);

// Says how many bytes a buffer of yours has for contours, in place of one of their own.
enum GeosweepStatus geosweep_contours_buffer_bytes(uint32_t vertices, uint64_t *bytes);

// Makes contours as `geosweep_contours_create` does, which go to a buffer of yours, from its first byte: with usage
// `VK_BUFFER_USAGE_STORAGE_BUFFER_BIT` and what
// its readers ask for, device addresses too. It stays yours, and a render graph may give its memory to others meanwhile.
enum GeosweepStatus geosweep_contours_create_into(const struct GeosweepSurface *surface,
                                                  uint32_t vertices,
                                                  VkBuffer buffer,
                                                  struct GeosweepContours **contours);

// Has contours from now on go to another buffer of yours, if they were made with one. Recordings in flight go on with the
// one before.
enum GeosweepStatus geosweep_contours_set_buffer(struct GeosweepContours *contours,
                                                 const struct GeosweepSurface *surface,
                                                 VkBuffer buffer);

// Says how many bytes of device memory contours take.
enum GeosweepStatus geosweep_contours_bytes(const struct GeosweepContours *contours,
                                            uint64_t *bytes);

// Says where contours are, also before any are recorded: one curve, drawn as a list of lines.
enum GeosweepStatus geosweep_contours_curves(const struct GeosweepContours *contours,
                                             struct GeosweepCurves *curves);

// Finds the contours of the map, lifts them to the surface and leaves them for you to draw, the same
// in the same order whenever the map is the same. To be recorded after the map, in the same command
// buffer or after `geosweep_record_begin`. If there are more than there is room for, the southern
// ones are left out, and their record says how many vertices there are. Gives where they are to
// `result` unless that is null.
enum GeosweepStatus geosweep_record_contours(const struct GeosweepSurface *surface,
                                             VkCommandBuffer commands,
                                             const struct GeosweepContours *contours,
                                             const struct GeosweepContourFrame *frame,
                                             struct GeosweepCurves *result);

// Has contours read the surface's points that were replaced since they were made, by
// `geosweep_surface_set_points`. Recordings in flight go on with those before.
enum GeosweepStatus geosweep_contours_rebind(struct GeosweepContours *contours,
                                             const struct GeosweepSurface *surface);

// Destroys contours, before or after their surface. No submitted work may still use them, which a
// solver with checks looks at. Null is
// fine.
enum GeosweepStatus geosweep_contours_destroy(struct GeosweepContours *contours);

// Says how many bytes of device memory paths will take, before they are made: 24 a vertex of each,
// and 104 a path.
enum GeosweepStatus geosweep_paths_bytes_for(const struct GeosweepSolver *solver,
                                             uint32_t path_count,
                                             uint32_t vertices,
                                             uint64_t *bytes);

// Makes room for paths on a surface: so many at once, at most 65535, of so many vertices each. A
// straight way has one at each grid line that it crosses, so that rows + cols + 8 are enough where
// nothing is in the way. `geosweep_paths_destroy` destroys it. Takes device memory and compiles
// passes.
enum GeosweepStatus geosweep_paths_create(const struct GeosweepSurface *surface,
                                          uint32_t path_count,
                                          uint32_t vertices,
                                          struct GeosweepPaths **paths);

// Says how many bytes a buffer of yours has for paths, in place of one of their own.
enum GeosweepStatus geosweep_paths_buffer_bytes(uint32_t count, uint32_t vertices, uint64_t *bytes);

// Makes paths as `geosweep_paths_create` does, which go to a buffer of yours, from its first byte: with usage
// `VK_BUFFER_USAGE_STORAGE_BUFFER_BIT` and `VK_BUFFER_USAGE_TRANSFER_DST_BIT` and what
// its readers ask for, device addresses too. It stays yours, and a render graph may give its memory to others meanwhile.
enum GeosweepStatus geosweep_paths_create_into(const struct GeosweepSurface *surface,
                                               uint32_t count,
                                               uint32_t vertices,
                                               VkBuffer buffer,
                                               struct GeosweepPaths **paths);

// Has paths from now on go to another buffer of yours, if they were made with one. Recordings in flight go on with the
// one before.
enum GeosweepStatus geosweep_paths_set_buffer(struct GeosweepPaths *paths,
                                              const struct GeosweepSurface *surface,
                                              VkBuffer buffer);

// Says how many bytes of device memory paths take.
enum GeosweepStatus geosweep_paths_bytes(const struct GeosweepPaths *paths, uint64_t *bytes);

// Says where paths are, also before any are recorded: a curve each, drawn as a strip of lines.
enum GeosweepStatus geosweep_paths_curves(const struct GeosweepPaths *paths,
                                          struct GeosweepCurves *curves);

// Traces the paths from some places back to the source, lifts them to the surface and leaves them
// for you to draw. To be recorded after the map, in the same command buffer or after
// `geosweep_record_begin`. If there is none to draw, its record says why. Gives where they are to
// `result` unless that is null.
enum GeosweepStatus geosweep_record_paths(const struct GeosweepSurface *surface,
                                          VkCommandBuffer commands,
                                          const struct GeosweepPaths *paths,
                                          const struct GeosweepPathFrame *frame,
                                          struct GeosweepCurves *result);

// Has paths read the surface's points and sources that were replaced since they were made, by
// `geosweep_surface_set_points` and `geosweep_surface_set_sources`. Recordings in flight go on with those before.
enum GeosweepStatus geosweep_paths_rebind(struct GeosweepPaths *paths,
                                          const struct GeosweepSurface *surface);

// Destroys paths, before or after their surface. No submitted work may still use them, which a
// solver with checks looks at. Null is fine.
enum GeosweepStatus geosweep_paths_destroy(struct GeosweepPaths *paths);

// Says how many bytes of device memory regions will take, before they are made: 24 a grid point.
enum GeosweepStatus geosweep_regions_bytes_for(const struct GeosweepSolver *solver,
                                               uint32_t rows,
                                               uint32_t cols,
                                               uint64_t *bytes);

// Makes room for the regions of a surface's maps with one wavefront; `geosweep_regions_destroy` destroys it.
// Takes device memory and compiles passes.
enum GeosweepStatus geosweep_regions_create(const struct GeosweepSurface *surface,
                                            GeosweepWavefront wavefront,
                                            struct GeosweepRegions **regions);

// Says how many bytes a buffer of yours has for regions, in place of one of their own.
enum GeosweepStatus geosweep_regions_buffer_bytes(uint32_t rows, uint32_t cols, uint64_t *bytes);

// Makes regions as `geosweep_regions_create` does, which go to a buffer of yours, from its first byte: with usage
// `VK_BUFFER_USAGE_STORAGE_BUFFER_BIT` and `VK_BUFFER_USAGE_TRANSFER_DST_BIT` and what
// its readers ask for, device addresses too. It stays yours, and a render graph may give its memory to others meanwhile.
enum GeosweepStatus geosweep_regions_create_into(const struct GeosweepSurface *surface,
                                                 GeosweepWavefront wavefront,
                                                 VkBuffer buffer,
                                                 struct GeosweepRegions **regions);

// Has regions from now on go to another buffer of yours, if they were made with one. Recordings in flight go on with the
// one before.
enum GeosweepStatus geosweep_regions_set_buffer(struct GeosweepRegions *regions,
                                                const struct GeosweepSurface *surface,
                                                VkBuffer buffer);

// Says how many bytes of device memory regions take.
enum GeosweepStatus geosweep_regions_bytes(const struct GeosweepRegions *regions, uint64_t *bytes);

// Says where labels are, also before any are recorded.
enum GeosweepStatus geosweep_regions_labels(const struct GeosweepRegions *regions,
                                            struct GeosweepLabels *labels);

// Finds which source is the nearest to each grid point and leaves the labels for you to read: a source's place in
// the list, or `GEOSWEEP_NO_REGION`. To be recorded after the map, in the same command buffer or after
// `geosweep_record_begin`. Gives where they are to `result` unless that is null.
enum GeosweepStatus geosweep_record_regions(const struct GeosweepSurface *surface,
                                            VkCommandBuffer commands,
                                            const struct GeosweepRegions *regions,
                                            const struct GeosweepRegionFrame *frame,
                                            struct GeosweepLabels *result);

// Has regions read the surface's sources that were replaced since they were made, by
// `geosweep_surface_set_sources`. Recordings in flight go on with those before.
enum GeosweepStatus geosweep_regions_rebind(struct GeosweepRegions *regions,
                                            const struct GeosweepSurface *surface);

// Destroys regions, before or after their surface. No submitted work may still use them, which a solver
// with checks looks at. Null is fine.
enum GeosweepStatus geosweep_regions_destroy(struct GeosweepRegions *regions);

// Makes room for the passes of frames of a surface with this plan, which go to a queue of this family;
// `geosweep_profile_destroy` destroys it. The family's queues must write timestamps, else the status is
// `GEOSWEEP_STATUS_UNSUPPORTED`.
enum GeosweepStatus geosweep_profile_create(const struct GeosweepSurface *surface,
                                            const struct GeosweepPlan *plan,
                                            GeosweepGrain grain,
                                            uint32_t queue_family,
                                            struct GeosweepProfile **profile);

// Reads back what the passes of the last frame that was recorded with this profile have taken, after its fence:
// `count` says how many there are, of which as many as `capacity` are written to `passes`. If that frame has
// not run, the status is `GEOSWEEP_STATUS_NOT_READY`.
enum GeosweepStatus geosweep_profile_passes(const struct GeosweepProfile *profile,
                                            struct GeosweepPass *passes,
                                            uint32_t capacity,
                                            uint32_t *count);

// Destroys a profile. No submitted work may still use it. Null is fine.
enum GeosweepStatus geosweep_profile_destroy(struct GeosweepProfile *profile);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* GEOSWEEP_H */
