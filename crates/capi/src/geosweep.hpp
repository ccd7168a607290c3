/*
 * geosweep.h for C++11 and later: objects that destroy themselves, and exceptions in place of statuses.
 * geosweep.h documents the functions; docs/embedding.md has the rest.
 *
 * Each object keeps its solver alive, so that objects may be destroyed in any order. Destroy all of them
 * before your device. No submitted work may still use an object that is destroyed. A solver with
 * GEOSWEEP_SOLVER_CHECKS may refuse to destroy an object, for instance a surface with a recording that was
 * never submitted. Destructors cannot throw, so that the object is then kept, and the macro
 * GEOSWEEP_NOT_DESTROYED reports it. You may define this macro before you include this header.
 */
#ifndef GEOSWEEP_HPP
#define GEOSWEEP_HPP

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "geosweep.h"

#ifndef GEOSWEEP_NOT_DESTROYED
#define GEOSWEEP_NOT_DESTROYED(why) std::fprintf(stderr, "geosweep: not destroyed: %s\n", why)
#endif

namespace geosweep {

/* A call that failed: what() returns the text of geosweep_last_error. */
class Error : public std::runtime_error {
public:
    explicit Error(GeosweepStatus of) : std::runtime_error(geosweep_last_error()), status(of) {}

    const GeosweepStatus status;
};

inline void check(GeosweepStatus status) {
    if (status != GEOSWEEP_STATUS_SUCCESS) throw Error(status);
}

inline void check_destroyed(GeosweepStatus status) {
    if (status != GEOSWEEP_STATUS_SUCCESS) GEOSWEEP_NOT_DESTROYED(geosweep_last_error());
}

/*
 * Returns the 32-bit flags for VkPipelineStageFlags2 and VkAccessFlags2. Copies, resolves, blits and
 * clears become transfers, the parts of vertex input become vertex input, and sampled and storage accesses
 * become shader accesses. Flags without a counterpart throw std::invalid_argument.
 */
inline GeosweepAccess access_from(uint64_t stages, uint64_t accesses) {
    struct Name {
        uint64_t bits;
        uint32_t is;
    };
    const uint64_t one = 1;
    const Name of_stages[] = {
        {one << 32 | one << 33 | one << 34 | one << 35, VK_PIPELINE_STAGE_TRANSFER_BIT},
        {one << 36 | one << 37, VK_PIPELINE_STAGE_VERTEX_INPUT_BIT},
        {one << 38, VK_PIPELINE_STAGE_ALL_GRAPHICS_BIT},
    };
    const Name of_accesses[] = {
        {one << 32 | one << 33, VK_ACCESS_SHADER_READ_BIT},
        {one << 34, VK_ACCESS_SHADER_WRITE_BIT},
    };
    const uint64_t low = 0xffffffff;
    uint32_t in = static_cast<uint32_t>(stages & low), how = static_cast<uint32_t>(accesses & low);
    for (const Name &name : of_stages) {
        if (stages & name.bits) in |= name.is;
        stages &= ~name.bits;
    }
    for (const Name &name : of_accesses) {
        if (accesses & name.bits) how |= name.is;
        accesses &= ~name.bits;
    }
    if ((stages | accesses) & ~low) throw std::invalid_argument("stages or accesses that have no name of 32 bits");
    GeosweepAccess made = {in, how};
    return made;
}

/* Returns an access, as one side of a barrier, from 32-bit flags or from the 64-bit flags of
   synchronization2. */
template <class Stages, class Accesses>
GeosweepAccess access(Stages stages, Accesses accesses) {
    return access_from(static_cast<uint64_t>(stages), static_cast<uint64_t>(accesses));
}

/* Returns the access of shaders that sample an image in these stages. */
template <class Stages>
GeosweepReader sampled(Stages stages) {
    GeosweepReader made = {access(stages, VK_ACCESS_SHADER_READ_BIT), VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    return made;
}

/*
 * Structs of geosweep.h with named members, in C++11 too. Each starts with the usual values, and each call
 * that changes a member returns the struct:
 * geosweep::Method(GEOSWEEP_WAVEFRONT_CURVED).tolerated(1e-5).in_a_recording(8)
 */
struct Method : GeosweepMethod {
    explicit Method(GeosweepWavefront of) : GeosweepMethod() {
        wavefront = of;
        tolerance = 1e-4;
        most_iterations = 100;
        iterations = 8;
    }
    Method &by(GeosweepSchedule of) { return schedule = of, *this; }
    Method &tolerated(double most) { return tolerance = most, *this; }
    Method &in_all(uint32_t most) { return most_iterations = most, *this; }
    Method &in_a_recording(uint32_t count) { return iterations = count, *this; }
    /* For glued surfaces. */
    Method &passing_seams() { return over_seams = 1, *this; }
};

struct Points : GeosweepPoints {
    /* Positions in a buffer, `apart` bytes from point to point. */
    Points(VkBuffer of, uint64_t apart) : GeosweepPoints() { buffer = of, stride = apart; }
    /* Positions in an image, which has the layout `in` whenever it is read. */
    Points(VkImageView of, VkImageLayout in) : GeosweepPoints() { view = of, layout = in; }
    Points &from(uint64_t bytes) { return offset = bytes, *this; }
    Points &heights(double columns_apart, double rows_apart) {
        return kind = GEOSWEEP_POINT_KIND_HEIGHTS, dx = columns_apart, dy = rows_apart, *this;
    }
    Points &metric() { return kind = GEOSWEEP_POINT_KIND_METRIC, *this; }
    Points &slowed_by(uint32_t which_float) { return slowness = which_float, *this; }
};

/* The arrays belong to the program and are not needed after the surface is created. */
struct SurfaceInfo : GeosweepSurfaceInfo {
    SurfaceInfo(uint32_t of_rows, uint32_t of_cols) : GeosweepSurfaceInfo() {
        rows = of_rows, cols = of_cols, slots = 1;
    }
    SurfaceInfo &in_flight(uint32_t frames) { return slots = frames, *this; }
    SurfaceInfo &measured_by(GeosweepEdgeRule rule) { return edge_rule = rule, *this; }
    SurfaceInfo &with(const GeosweepPoints *of, std::size_t count) {
        return points = of, point_count = static_cast<uint32_t>(count), *this;
    }
    /* Your own images for the distances, one per slot. */
    SurfaceInfo &into(const GeosweepHostImage *of, std::size_t count) {
        return results = of, result_count = static_cast<uint32_t>(count), *this;
    }
    SurfaceInfo &with(const GeosweepSourceBuffer *of, std::size_t count) {
        return sources = of, source_count = static_cast<uint32_t>(count), *this;
    }
    SurfaceInfo &with(const GeosweepLookup *of, std::size_t count) {
        return lookups = of, lookup_count = static_cast<uint32_t>(count), *this;
    }
    /* Lets updates look farther, for cells that are sheared or stretched by much. */
    SurfaceInfo &with_skewed_cells() { return has_skewed_cells = true, *this; }
    /* Glues sides that coincide. Plans for a glued surface must be made with passing_seams(). */
    SurfaceInfo &glued(GeosweepGluing sides) { return gluing = sides, *this; }
    SurfaceInfo &glued(const GeosweepRunPair *of, std::size_t count) {
        return gluing = GEOSWEEP_GLUING_RUNS, runs = of, run_count = static_cast<uint32_t>(count), *this;
    }
    SurfaceInfo &shared_by(const std::vector<uint32_t> &families) {
        return queue_families = families.data(), queue_family_count = static_cast<uint32_t>(families.size()), *this;
    }
};

/* Returns a solver's info that has the header's version and is otherwise empty. */
inline GeosweepSolverInfo solver_info() {
    GeosweepSolverInfo info = GeosweepSolverInfo();
    info.header_version = GEOSWEEP_HEADER_VERSION;
    return info;
}

/*
 * Transfers buffers and images of distances from one queue family to another. Record this last on the
 * queue that releases them, with the access that wrote them, and first on the other queue, with the access
 * that reads them. `barrier` is your vkCmdPipelineBarrier.
 */
inline void hand_over(PFN_vkCmdPipelineBarrier barrier, VkCommandBuffer commands, bool gives, GeosweepAccess whose,
                      uint32_t from, uint32_t to, const std::vector<GeosweepImage> &images,
                      const std::vector<VkBuffer> &buffers) {
    std::vector<VkImageMemoryBarrier> of_images;
    for (const GeosweepImage &image : images) {
        VkImageMemoryBarrier made = VkImageMemoryBarrier();
        made.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER;
        (gives ? made.srcAccessMask : made.dstAccessMask) = whose.access;
        made.oldLayout = made.newLayout = image.layout;
        made.srcQueueFamilyIndex = from;
        made.dstQueueFamilyIndex = to;
        made.image = image.image;
        made.subresourceRange.aspectMask = VK_IMAGE_ASPECT_COLOR_BIT;
        made.subresourceRange.levelCount = made.subresourceRange.layerCount = 1;
        of_images.push_back(made);
    }
    std::vector<VkBufferMemoryBarrier> of_buffers;
    for (VkBuffer buffer : buffers) {
        VkBufferMemoryBarrier made = VkBufferMemoryBarrier();
        made.sType = VK_STRUCTURE_TYPE_BUFFER_MEMORY_BARRIER;
        (gives ? made.srcAccessMask : made.dstAccessMask) = whose.access;
        made.srcQueueFamilyIndex = from;
        made.dstQueueFamilyIndex = to;
        made.buffer = buffer;
        made.size = VK_WHOLE_SIZE;
        of_buffers.push_back(made);
    }
    /* The stages that read on the other queue are those of its wait for the semaphore. */
    VkPipelineStageFlags after = whose.stages;
    if (gives) after = VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT;
    barrier(commands, whose.stages, after, 0, 0, nullptr, static_cast<uint32_t>(of_buffers.size()), of_buffers.data(),
            static_cast<uint32_t>(of_images.size()), of_images.data());
}

class Solver {
public:
    explicit Solver(const GeosweepSolverInfo &info) {
        GeosweepSolver *solver = nullptr;
        check(geosweep_solver_create(&info, &solver));
        solver_.reset(solver, [](GeosweepSolver *made) { check_destroyed(geosweep_solver_destroy(made)); });
    }

    GeosweepSolver *get() const { return solver_.get(); }

    /* Returns the bytes of device memory that surfaces and the other objects of the solver hold. */
    uint64_t bytes() const {
        uint64_t bytes = 0;
        check(geosweep_solver_bytes(get(), &bytes));
        return bytes;
    }

    void set_pipeline_cache(VkPipelineCache cache) const {
        check(geosweep_solver_set_pipeline_cache(get(), cache));
    }

private:
    std::shared_ptr<GeosweepSolver> solver_;
};

/* Base of the objects that a solver creates. They are destroyed before their solver. */
template <class T, GeosweepStatus (*destroy)(T *)>
class Owned {
public:
    T *get() const { return object_.get(); }
    const Solver &solver() const { return solver_; }

    Owned(Owned &&) = default;
    /* Destroys the old object before its solver, since a solver refuses to be destroyed first. */
    Owned &operator=(Owned &&other) noexcept {
        object_ = std::move(other.object_);
        solver_ = std::move(other.solver_);
        return *this;
    }

protected:
    explicit Owned(const Solver &solver) : solver_(solver) {}

    void own(T *object) { object_.reset(object); }

private:
    struct Destroy {
        void operator()(T *object) const { check_destroyed(destroy(object)); }
    };
    Solver solver_;
    std::unique_ptr<T, Destroy> object_;
};

class Plan : public Owned<GeosweepPlan, geosweep_plan_destroy> {
public:
    Plan(const Solver &solver, uint32_t rows, uint32_t cols, const GeosweepMethod &method) : Owned(solver) {
        GeosweepPlan *plan = nullptr;
        check(geosweep_plan_create(solver.get(), rows, cols, &method, &plan));
        own(plan);
    }

    /* Returns the schedule that was chosen for GEOSWEEP_SCHEDULE_BEST. */
    GeosweepSchedule schedule() const {
        GeosweepSchedule schedule = GEOSWEEP_SCHEDULE_BEST;
        check(geosweep_plan_schedule(get(), &schedule));
        return schedule;
    }

    /* Returns the number of iterations in a recording. With tiles it may be smaller than requested. */
    uint32_t iterations() const {
        uint32_t iterations = 0;
        check(geosweep_plan_iterations(get(), &iterations));
        return iterations;
    }
};

class Surface : public Owned<GeosweepSurface, geosweep_surface_destroy> {
public:
    Surface(const Solver &solver, const GeosweepSurfaceInfo &info) : Owned(solver) {
        GeosweepSurface *surface = nullptr;
        check(geosweep_surface_create(solver.get(), &info, &surface));
        own(surface);
    }

    /* Returns the image of a slot, also before anything is recorded, so that descriptor sets can be
       written. */
    GeosweepImage image(uint32_t slot, VkImageLayout layout) const {
        GeosweepImage image = GeosweepImage();
        check(geosweep_surface_result(get(), slot, layout, &image));
        return image;
    }

    void write_points(uint32_t number, const float *data, const uint8_t *mask = nullptr) {
        check(geosweep_surface_write_points(get(), number, data, mask));
    }

    /* Replaces buffers or images with which the surface was created. Frames in flight keep the old ones. */
    void set_points(uint32_t number, const GeosweepPoints &points) {
        check(geosweep_surface_set_points(get(), number, &points));
    }

    void set_sources(uint32_t number, const GeosweepSourceBuffer &sources) {
        check(geosweep_surface_set_sources(get(), number, &sources));
    }

    /* Replaces your own image for a slot. The surface must have been created with your images. */
    void set_result(uint32_t slot, const GeosweepHostImage &image) {
        check(geosweep_surface_set_result(get(), slot, &image));
    }

    void prepare(VkCommandBuffer commands) const { check(geosweep_record_prepare(get(), commands)); }

    GeosweepImage frame(VkCommandBuffer commands, const GeosweepFrame &frame) const {
        GeosweepImage image = GeosweepImage();
        check(geosweep_record_frame(get(), commands, &frame, &image));
        return image;
    }

    void begin(VkCommandBuffer commands, GeosweepAccess before) const {
        check(geosweep_record_begin(get(), commands, before));
    }

    void measure(VkCommandBuffer commands, uint32_t points, uint64_t offset = 0) const {
        check(geosweep_record_measure(get(), commands, points, offset));
    }

    void solve(VkCommandBuffer commands, const GeosweepSources &sources, const Plan &plan) const {
        check(geosweep_record_solve(get(), commands, &sources, plan.get()));
    }

    void add(VkCommandBuffer commands, const GeosweepSources &sources, const Plan &plan) const {
        check(geosweep_record_add(get(), commands, &sources, plan.get()));
    }

    void resume(VkCommandBuffer commands, const Plan &plan) const {
        check(geosweep_record_resume(get(), commands, plan.get()));
    }

    void record_outcome(VkCommandBuffer commands, uint32_t slot) const {
        check(geosweep_record_outcome(get(), commands, slot));
    }

    GeosweepImage result(VkCommandBuffer commands, uint32_t slot, GeosweepReader reader, float unreached) const {
        GeosweepImage image = GeosweepImage();
        check(geosweep_record_result(get(), commands, slot, reader, unreached, &image));
        return image;
    }

    void lookup(VkCommandBuffer commands, uint32_t number, float unreached, GeosweepAccess before,
                GeosweepAccess after) const {
        check(geosweep_record_lookup(get(), commands, number, unreached, before, after));
    }

    void end(VkCommandBuffer commands, GeosweepAccess after) const {
        check(geosweep_record_end(get(), commands, after));
    }

    /* Declares that the slot's last recording will never be submitted. */
    void discard(uint32_t slot) const { check(geosweep_surface_discard(get(), slot)); }

    /* Declares that the last recording into a command buffer will never be submitted, whether it has a
       slot or not. */
    void discard_commands(VkCommandBuffer commands) const {
        check(geosweep_surface_discard_commands(get(), commands));
    }

    /* Reads an outcome from the bytes that geosweep_record_outcome_to has copied. */
    GeosweepOutcome outcome_from(const uint8_t *bytes) const {
        GeosweepOutcome how = GeosweepOutcome();
        check(geosweep_outcome_from_bytes(get(), bytes, &how));
        return how;
    }

    /* Returns whether the slot's last recording has run. If so, writes its outcome to `how`. */
    bool outcome(uint32_t slot, GeosweepOutcome &how) const {
        GeosweepStatus status = geosweep_surface_outcome(get(), slot, &how);
        if (status == GEOSWEEP_STATUS_NOT_READY) return false;
        check(status);
        return true;
    }
};

/*
 * Records frames of several surfaces so that they run at the same time, with the barriers of one frame.
 * Surface::image returns their images.
 */
template <std::size_t count>
void frames(VkCommandBuffer commands, const Surface *const (&surfaces)[count], const GeosweepFrame (&frames)[count]) {
    const GeosweepSurface *handles[count];
    for (std::size_t number = 0; number < count; number++) handles[number] = surfaces[number]->get();
    check(geosweep_record_frames(handles, frames, static_cast<uint32_t>(count), commands, nullptr));
}

/* A frame of a plan with named members. Unless set otherwise, it measures the points 0 and writes slot 0. */
struct Frame : GeosweepFrame {
    Frame(const Plan &of, const GeosweepReader &by) : GeosweepFrame() {
        plan = of.get(), reader = by, unreached = -1.0f;
    }
    Frame &after(const GeosweepAccess &writes) { return before = writes, *this; }
    Frame &from(uint32_t which_points, uint64_t offset = 0) {
        return points = which_points, points_offset = offset, *this;
    }
    Frame &unchanged() { return points = GEOSWEEP_POINTS_UNCHANGED, *this; }
    Frame &to(uint32_t which_slot) { return slot = which_slot, *this; }
    /* Sets the value of points that no front reaches. */
    Frame &else_is(float value) { return unreached = value, *this; }
    /* Sets the sources to an array, which must exist until the frame is recorded. */
    Frame &around(const GeosweepSource *of, std::size_t count) {
        sources = GeosweepSources();
        return sources.sources = of, sources.count = static_cast<uint32_t>(count), *this;
    }
    Frame &around_buffer(uint32_t number, uint64_t offset = 0) {
        sources = GeosweepSources();
        return sources.buffer = number, sources.offset = offset, *this;
    }
    /* Sets the largest distance of the map; 0 means no limit. */
    Frame &within(float distance) { return radius = distance, *this; }
    /* Sets the targets of the map to an array, which must exist until the frame is recorded. */
    Frame &toward(const GeosweepTarget *of, std::size_t count, uint32_t needed = 0) {
        targets = of, target_count = static_cast<uint32_t>(count);
        return targets_needed = needed, *this;
    }
    Frame &timed_by(const GeosweepProfile *taking_down) { return profile = taking_down, *this; }
};

/* Times of the passes of a frame. Set GeosweepFrame::profile to the pointer that get() returns. */
class Profile : public Owned<GeosweepProfile, geosweep_profile_destroy> {
public:
    Profile(const Surface &surface, const Plan &plan, GeosweepGrain grain, uint32_t queue_family)
        : Owned(surface.solver()) {
        GeosweepProfile *profile = nullptr;
        check(geosweep_profile_create(surface.get(), plan.get(), grain, queue_family, &profile));
        own(profile);
    }

    /* Returns the passes of the last frame. The list is empty if that frame has not run. */
    std::vector<GeosweepPass> passes() const {
        std::vector<GeosweepPass> passes;
        uint32_t count = 0;
        GeosweepStatus status = geosweep_profile_passes(get(), nullptr, 0, &count);
        if (status == GEOSWEEP_STATUS_NOT_READY) return passes;
        check(status);
        passes.resize(count);
        check(geosweep_profile_passes(get(), passes.data(), count, &count));
        return passes;
    }
};

class Contours : public Owned<GeosweepContours, geosweep_contours_destroy> {
public:
    Contours(const Surface &surface, uint32_t vertices) : Owned(surface.solver()) {
        GeosweepContours *contours = nullptr;
        check(geosweep_contours_create(surface.get(), vertices, &contours));
        own(contours);
    }

    /* Returns where contours are stored, also before any are recorded. */
    GeosweepCurves curves() const {
        GeosweepCurves curves = GeosweepCurves();
        check(geosweep_contours_curves(get(), &curves));
        return curves;
    }

    /* Creates contours in your own buffer of buffer_bytes bytes, which may be another one in each frame. */
    Contours(const Surface &surface, uint32_t vertices, VkBuffer buffer) : Owned(surface.solver()) {
        GeosweepContours *into = nullptr;
        check(geosweep_contours_create_into(surface.get(), vertices, buffer, &into));
        own(into);
    }

    static uint64_t buffer_bytes(uint32_t vertices) {
        uint64_t bytes = 0;
        check(geosweep_contours_buffer_bytes(vertices, &bytes));
        return bytes;
    }

    void set_buffer(const Surface &surface, VkBuffer buffer) {
        check(geosweep_contours_set_buffer(get(), surface.get(), buffer));
    }

    /* Makes contours read the surface's inputs again, after these were replaced. */
    void rebind(const Surface &surface) { check(geosweep_contours_rebind(get(), surface.get())); }

    GeosweepCurves record(const Surface &surface, VkCommandBuffer commands, const GeosweepContourFrame &frame) const {
        GeosweepCurves curves = GeosweepCurves();
        check(geosweep_record_contours(surface.get(), commands, get(), &frame, &curves));
        return curves;
    }
};

class Paths : public Owned<GeosweepPaths, geosweep_paths_destroy> {
public:
    Paths(const Surface &surface, uint32_t paths, uint32_t vertices) : Owned(surface.solver()) {
        GeosweepPaths *made = nullptr;
        check(geosweep_paths_create(surface.get(), paths, vertices, &made));
        own(made);
    }

    /* Returns where paths are stored, also before any are recorded. */
    GeosweepCurves curves() const {
        GeosweepCurves curves = GeosweepCurves();
        check(geosweep_paths_curves(get(), &curves));
        return curves;
    }

    /* Creates paths in your own buffer of buffer_bytes bytes, which may be another one in each frame. */
    Paths(const Surface &surface, uint32_t paths, uint32_t vertices, VkBuffer buffer) : Owned(surface.solver()) {
        GeosweepPaths *into = nullptr;
        check(geosweep_paths_create_into(surface.get(), paths, vertices, buffer, &into));
        own(into);
    }

    static uint64_t buffer_bytes(uint32_t paths, uint32_t vertices) {
        uint64_t bytes = 0;
        check(geosweep_paths_buffer_bytes(paths, vertices, &bytes));
        return bytes;
    }

    void set_buffer(const Surface &surface, VkBuffer buffer) {
        check(geosweep_paths_set_buffer(get(), surface.get(), buffer));
    }

    /* Makes paths read the surface's inputs again, after these were replaced. */
    void rebind(const Surface &surface) { check(geosweep_paths_rebind(get(), surface.get())); }

    GeosweepCurves record(const Surface &surface, VkCommandBuffer commands, const GeosweepPathFrame &frame) const {
        GeosweepCurves curves = GeosweepCurves();
        check(geosweep_record_paths(surface.get(), commands, get(), &frame, &curves));
        return curves;
    }
};

class Regions : public Owned<GeosweepRegions, geosweep_regions_destroy> {
public:
    Regions(const Surface &surface, GeosweepWavefront wavefront) : Owned(surface.solver()) {
        GeosweepRegions *regions = nullptr;
        check(geosweep_regions_create(surface.get(), wavefront, &regions));
        own(regions);
    }

    /* Returns where labels are stored, also before any are recorded. */
    GeosweepLabels labels() const {
        GeosweepLabels labels = GeosweepLabels();
        check(geosweep_regions_labels(get(), &labels));
        return labels;
    }

    /* Creates regions in your own buffer of buffer_bytes bytes, which may be another one in each frame. */
    Regions(const Surface &surface, GeosweepWavefront wavefront, VkBuffer buffer) : Owned(surface.solver()) {
        GeosweepRegions *into = nullptr;
        check(geosweep_regions_create_into(surface.get(), wavefront, buffer, &into));
        own(into);
    }

    static uint64_t buffer_bytes(uint32_t rows, uint32_t cols) {
        uint64_t bytes = 0;
        check(geosweep_regions_buffer_bytes(rows, cols, &bytes));
        return bytes;
    }

    void set_buffer(const Surface &surface, VkBuffer buffer) {
        check(geosweep_regions_set_buffer(get(), surface.get(), buffer));
    }

    /* Makes regions read the surface's inputs again, after these were replaced. */
    void rebind(const Surface &surface) { check(geosweep_regions_rebind(get(), surface.get())); }

    GeosweepLabels record(const Surface &surface, VkCommandBuffer commands, const GeosweepRegionFrame &frame) const {
        GeosweepLabels labels = GeosweepLabels();
        check(geosweep_record_regions(surface.get(), commands, get(), &frame, &labels));
        return labels;
    }
};

class Directions : public Owned<GeosweepDirections, geosweep_directions_destroy> {
public:
    /* Creates directions. They are in an image of your own unless `image` is null. */
    explicit Directions(const Surface &surface, const GeosweepHostImage *image = nullptr) : Owned(surface.solver()) {
        GeosweepDirections *made = nullptr;
        check(geosweep_directions_create(surface.get(), image, &made));
        own(made);
    }

    /* Returns the image, also before it is recorded. */
    GeosweepImage image(VkImageLayout layout) const {
        GeosweepImage image = GeosweepImage();
        check(geosweep_directions_image(get(), layout, &image));
        return image;
    }

    /* Makes later recordings write another image of yours. */
    void set_image(const GeosweepHostImage &image) { check(geosweep_directions_set_image(get(), &image)); }

    /* Makes directions read the surface's sources again, after these were replaced. */
    void rebind(const Surface &surface) { check(geosweep_directions_rebind(get(), surface.get())); }

    GeosweepImage record(const Surface &surface, VkCommandBuffer commands, const GeosweepDirectionFrame &frame) const {
        GeosweepImage image = GeosweepImage();
        check(geosweep_record_directions(surface.get(), commands, get(), &frame, &image));
        return image;
    }
};

class LogMap : public Owned<GeosweepLogMap, geosweep_log_map_destroy> {
public:
    /* Creates a log map. It is in an image of your own unless `image` is null. */
    explicit LogMap(const Surface &surface, const GeosweepHostImage *image = nullptr) : Owned(surface.solver()) {
        GeosweepLogMap *made = nullptr;
        check(geosweep_log_map_create(surface.get(), image, &made));
        own(made);
    }

    /* Returns the image, also before it is recorded. */
    GeosweepImage image(VkImageLayout layout) const {
        GeosweepImage image = GeosweepImage();
        check(geosweep_log_map_image(get(), layout, &image));
        return image;
    }

    /* Makes later recordings write another image of yours. */
    void set_image(const GeosweepHostImage &image) { check(geosweep_log_map_set_image(get(), &image)); }

    /* Makes a log map read the surface's sources again, after these were replaced. */
    void rebind(const Surface &surface) { check(geosweep_log_map_rebind(get(), surface.get())); }

    GeosweepImage record(const Surface &surface, VkCommandBuffer commands, const GeosweepLogMapFrame &frame) const {
        GeosweepImage image = GeosweepImage();
        check(geosweep_record_log_map(surface.get(), commands, get(), &frame, &image));
        return image;
    }
};

/* Computes a map on the CPU, without a device, and writes what is asked for. */
inline void cpu_map(const GeosweepMapInfo &info, const GeosweepMapOutputs &outputs) {
    check(geosweep_cpu_map(&info, &outputs));
}

}  // namespace geosweep

#endif  /* GEOSWEEP_HPP */
