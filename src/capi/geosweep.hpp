/*
 * geosweep.h for C++11 and later: objects that destroy themselves, and exceptions for statuses.
 * What the functions do is told in geosweep.h; docs/embedding.md has the rest.
 *
 * Each object keeps its solver alive, so that they may go in any order; all of them go before your
 * device. No submitted work may still use what goes. What a solver with GEOSWEEP_SOLVER_CHECKS refuses to destroy,
 * a surface with a recording that was never submitted say, stays and is told by GEOSWEEP_NOT_DESTROYED, which you
 * may define first: a destructor cannot throw.
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

/* A call that has failed: what() is geosweep_last_error. */
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
 * An access of VkPipelineStageFlags2 and VkAccessFlags2, as the flags of 32 bits say it: copies, resolves, blits and
 * clears are transfers, the parts of vertex input are that, and sampled and stored shader accesses are shader
 * accesses. What has no such name throws std::invalid_argument.
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

/* An access, as one side of a barrier: of flags of 32 bits, or of 64 as synchronization2 has them. */
template <class Stages, class Accesses>
GeosweepAccess access(Stages stages, Accesses accesses) {
    return access_from(static_cast<uint64_t>(stages), static_cast<uint64_t>(accesses));
}

/* Sampled in these stages. */
template <class Stages>
GeosweepReader sampled(Stages stages) {
    GeosweepReader made = {access(stages, VK_ACCESS_SHADER_READ_BIT), VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    return made;
}

/*
 * Structs of geosweep.h by names, in C++11 too: each starts from the usual choices, and the calls that change one give it
 * back. geosweep::Method(GEOSWEEP_WAVEFRONT_CURVED).tolerated(1e-5).in_a_recording(8)
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
};

struct Points : GeosweepPoints {
    /* Positions in a buffer, so many bytes apart. */
    Points(VkBuffer of, uint64_t apart) : GeosweepPoints() { buffer = of, stride = apart; }
    /* Positions in an image, in the layout in which it is whenever it is read. */
    Points(VkImageView of, VkImageLayout in) : GeosweepPoints() { view = of, layout = in; }
    Points &from(uint64_t bytes) { return offset = bytes, *this; }
    Points &heights(double columns_apart, double rows_apart) {
        return kind = GEOSWEEP_POINT_KIND_HEIGHTS, dx = columns_apart, dy = rows_apart, *this;
    }
    Points &metric() { return kind = GEOSWEEP_POINT_KIND_METRIC, *this; }
    Points &slowed_by(uint32_t which_float) { return slowness = which_float, *this; }
};

/* The arrays are the program's, and are not needed once the surface is made. */
struct SurfaceInfo : GeosweepSurfaceInfo {
    SurfaceInfo(uint32_t of_rows, uint32_t of_cols) : GeosweepSurfaceInfo() {
        rows = of_rows, cols = of_cols, slots = 1;
    }
    SurfaceInfo &in_flight(uint32_t frames) { return slots = frames, *this; }
    SurfaceInfo &measured_by(GeosweepEdgeRule rule) { return edge_rule = rule, *this; }
    SurfaceInfo &with(const GeosweepPoints *of, std::size_t count) {
        return points = of, point_count = static_cast<uint32_t>(count), *this;
    }
    /* Images of yours for the distances, one a slot. */
    SurfaceInfo &into(const GeosweepHostImage *of, std::size_t count) {
        return results = of, result_count = static_cast<uint32_t>(count), *this;
    }
    SurfaceInfo &with(const GeosweepSourceBuffer *of, std::size_t count) {
        return sources = of, source_count = static_cast<uint32_t>(count), *this;
    }
    SurfaceInfo &with(const GeosweepLookup *of, std::size_t count) {
        return lookups = of, lookup_count = static_cast<uint32_t>(count), *this;
    }
    SurfaceInfo &shared_by(const std::vector<uint32_t> &families) {
        return queue_families = families.data(), queue_family_count = static_cast<uint32_t>(families.size()), *this;
    }
};

/* A solver's info with the header's version in it, and nothing else. */
inline GeosweepSolverInfo solver_info() {
    GeosweepSolverInfo info = GeosweepSolverInfo();
    info.header_version = GEOSWEEP_HEADER_VERSION;
    return info;
}

/*
 * Gives images of distances and buffers from a queue family to another: recorded last on the queue that gives, with how
 * they were written, and first on the other, with how they are read. The pointer is your vkCmdPipelineBarrier.
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
    /* The other queue's semaphore names the stages in which they are read. */
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

    /* Of device memory, for surfaces and the like. */
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

/* Something of a solver's, which is destroyed before it. */
template <class T, GeosweepStatus (*destroy)(T *)>
class Owned {
public:
    T *get() const { return object_.get(); }
    const Solver &solver() const { return solver_; }

    Owned(Owned &&) = default;
    /* What was here goes before its solver does, which refuses to go first. */
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

    /* What GEOSWEEP_SCHEDULE_BEST has come to. */
    GeosweepSchedule schedule() const {
        GeosweepSchedule schedule = GEOSWEEP_SCHEDULE_BEST;
        check(geosweep_plan_schedule(get(), &schedule));
        return schedule;
    }

    /* That a recording holds: with tiles it may be fewer than were asked for. */
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

    /* Of a slot, also before anything is recorded: for descriptor sets. */
    GeosweepImage image(uint32_t slot, VkImageLayout layout) const {
        GeosweepImage image = GeosweepImage();
        check(geosweep_surface_result(get(), slot, layout, &image));
        return image;
    }

    void write_points(uint32_t number, const float *data, const uint8_t *mask = nullptr) {
        check(geosweep_surface_write_points(get(), number, data, mask));
    }

    /* Other buffers and images in place of those the surface was made with; frames in flight keep theirs. */
    void set_points(uint32_t number, const GeosweepPoints &points) {
        check(geosweep_surface_set_points(get(), number, &points));
    }

    void set_sources(uint32_t number, const GeosweepSourceBuffer &sources) {
        check(geosweep_surface_set_sources(get(), number, &sources));
    }

    /* Another image of yours for a slot, of a surface that was made with such. */
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

    /* There will be no submission of the slot's last recording. */
    void discard(uint32_t slot) const { check(geosweep_surface_discard(get(), slot)); }

    /* There will be none of what was recorded last into a command buffer, for a slot or not. */
    void discard_commands(VkCommandBuffer commands) const {
        check(geosweep_surface_discard_commands(get(), commands));
    }

    /* From what geosweep_record_outcome_to has copied. */
    GeosweepOutcome outcome_from(const uint8_t *bytes) const {
        GeosweepOutcome how = GeosweepOutcome();
        check(geosweep_outcome_from_bytes(get(), bytes, &how));
        return how;
    }

    /* Whether the slot's last recording has run, and if so how it went. */
    bool outcome(uint32_t slot, GeosweepOutcome &how) const {
        GeosweepStatus status = geosweep_surface_outcome(get(), slot, &how);
        if (status == GEOSWEEP_STATUS_NOT_READY) return false;
        check(status);
        return true;
    }
};

/*
 * Records frames of several surfaces so that they run beside one another, with the barriers of one. Their images are
 * those of Surface::image.
 */
template <std::size_t count>
void frames(VkCommandBuffer commands, const Surface *const (&surfaces)[count], const GeosweepFrame (&frames)[count]) {
    const GeosweepSurface *handles[count];
    for (std::size_t number = 0; number < count; number++) handles[number] = surfaces[number]->get();
    check(geosweep_record_frames(handles, frames, static_cast<uint32_t>(count), commands, nullptr));
}

/* A frame of a plan, by names: of points 0 for slot 0, unless it is told otherwise. */
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
    /* Where nothing arrives. */
    Frame &else_is(float value) { return unreached = value, *this; }
    /* An array that is there until the frame is recorded. */
    Frame &around(const GeosweepSource *of, std::size_t count) {
        sources = GeosweepSources();
        return sources.sources = of, sources.count = static_cast<uint32_t>(count), *this;
    }
    Frame &around_buffer(uint32_t number, uint64_t offset = 0) {
        sources = GeosweepSources();
        return sources.buffer = number, sources.offset = offset, *this;
    }
    Frame &timed_by(const GeosweepProfile *taking_down) { return profile = taking_down, *this; }
};

/* What each pass of a frame takes: GeosweepFrame::profile is its get(). */
class Profile : public Owned<GeosweepProfile, geosweep_profile_destroy> {
public:
    Profile(const Surface &surface, const Plan &plan, GeosweepGrain grain, uint32_t queue_family)
        : Owned(surface.solver()) {
        GeosweepProfile *profile = nullptr;
        check(geosweep_profile_create(surface.get(), plan.get(), grain, queue_family, &profile));
        own(profile);
    }

    /* Of the last frame; none if it has not run. */
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

    /* Where they are, also before any are recorded. */
    GeosweepCurves curves() const {
        GeosweepCurves curves = GeosweepCurves();
        check(geosweep_contours_curves(get(), &curves));
        return curves;
    }

    /* To a buffer of yours of buffer_bytes, which may be another in each frame. */
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

    /* After the surface's inputs were set anew. */
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

    /* Where they are, also before any are recorded. */
    GeosweepCurves curves() const {
        GeosweepCurves curves = GeosweepCurves();
        check(geosweep_paths_curves(get(), &curves));
        return curves;
    }

    /* To a buffer of yours of buffer_bytes, which may be another in each frame. */
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

    /* After the surface's inputs were set anew. */
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

    /* Where they are, also before any are recorded. */
    GeosweepLabels labels() const {
        GeosweepLabels labels = GeosweepLabels();
        check(geosweep_regions_labels(get(), &labels));
        return labels;
    }

    /* To a buffer of yours of buffer_bytes, which may be another in each frame. */
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

    /* After the surface's inputs were set anew. */
    void rebind(const Surface &surface) { check(geosweep_regions_rebind(get(), surface.get())); }

    GeosweepLabels record(const Surface &surface, VkCommandBuffer commands, const GeosweepRegionFrame &frame) const {
        GeosweepLabels labels = GeosweepLabels();
        check(geosweep_record_regions(surface.get(), commands, get(), &frame, &labels));
        return labels;
    }
};

}  // namespace geosweep

#endif  /* GEOSWEEP_HPP */
