// A frame graph: passes declare how they use resources, and the barriers between them follow from that.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include <vulkan/vulkan.h>

struct Use {
    VkPipelineStageFlags stages = 0;
    VkAccessFlags access = 0;
};

// A resource is identified by its name. Memory barriers apply to all resources.
using Uses = std::map<std::string, Use>;

struct Pass {
    std::string name;
    Uses reads, writes;
    std::function<void(VkCommandBuffer)> record;
    // The pass handles its own barriers: what it waits for, and what waits for it.
    bool has_own_barriers = false;
};

class Graph {
public:
    void add(Pass pass) { passes_.push_back(std::move(pass)); }

    // Returns the union of a resource's uses by the earlier passes, for which this pass waits.
    Use before(const std::string &pass, const std::string &resource) const {
        Use use;
        for (const Pass &other : passes_) {
            if (other.name == pass) break;
            for (const Uses *uses : {&other.reads, &other.writes}) merge(use, *uses, resource);
        }
        return use;
    }

    void record(VkCommandBuffer commands) const {
        Uses written, read;
        for (const Pass &pass : passes_) {
            Use from, to;
            for (const auto &[resource, use] : pass.reads) {
                if (written.count(resource)) add_barrier(from, written[resource], to, use);
            }
            for (const auto &[resource, use] : pass.writes) {
                if (written.count(resource)) add_barrier(from, written[resource], to, use);
                if (read.count(resource)) add_barrier(from, read[resource], to, use);
            }
            if (from.stages != 0 && !pass.has_own_barriers) {
                VkMemoryBarrier barrier = {VK_STRUCTURE_TYPE_MEMORY_BARRIER, nullptr, from.access, to.access};
                vkCmdPipelineBarrier(commands, from.stages, to.stages, 0, 1, &barrier, 0, nullptr, 0, nullptr);
            }
            pass.record(commands);
            for (const auto &[resource, use] : pass.reads) read[resource] = use;
            for (const auto &[resource, use] : pass.writes) {
                read.erase(resource);
                // Later readers need no barrier: a pass with its own barriers has been told of them.
                if (pass.has_own_barriers) written.erase(resource);
                else written[resource] = use;
            }
        }
    }

private:
    static void merge(Use &into, const Uses &uses, const std::string &resource) {
        auto found = uses.find(resource);
        if (found == uses.end()) return;
        into.stages |= found->second.stages;
        into.access |= found->second.access;
    }

    static void add_barrier(Use &from, const Use &before, Use &to, const Use &after) {
        from.stages |= before.stages;
        from.access |= before.access;
        to.stages |= after.stages;
        to.access |= after.access;
    }

    std::vector<Pass> passes_;
};
