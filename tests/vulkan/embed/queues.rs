//! Maps from a queue for compute beside the main queue, which moves vertices and draws maps. Semaphores order the work
//! of the queues. The queue families share the resources of both queues, or transfer their ownership.
//!
//! On a device with a single family, the tests use two queues of that family, or a single queue. Semaphores are needed
//! between two queues there too, and barriers between equal families transfer nothing.

use geosweep::ash::vk;
use geosweep::vulkan::embed::Access;

use crate::embed::frames::{IN_FLIGHT, Renderer, Way, draw_frames, read};
use crate::host::{self, Host};

#[test]
fn maps_of_another_queue_are_drawn_when_families_share_images() {
    draw_frames(Way::Shared, 12);
}

#[test]
fn maps_of_another_queue_are_drawn_when_images_are_handed_over() {
    draw_frames(Way::HandedOver, 12);
}

/// Returns the messages for two frames in one command buffer, since older layers do not check across
/// submissions. Barriers replace the semaphores: the stages that wait for a semaphore wait for all earlier commands.
/// Unless `waits` is set, the wait before drawing is left out. Contours are then left out too, since their own barriers
/// would suffice.
fn messages_of_one_queue(way: Way, waits: bool) -> Vec<String> {
    let host = Host::new();
    let main = host::family(&host.instance, host.physical_device);
    let renderer = Renderer::new(host, way, [main; 2]);
    let all = vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE;
    let done = Access::new(vk::PipelineStageFlags::ALL_COMMANDS, vk::AccessFlags::MEMORY_WRITE);
    renderer.host.run(|commands| {
        let semaphore = |stages| renderer.host.barrier(commands, done, Access::new(stages, all));
        for slot in 0..IN_FLIGHT {
            renderer.deform(commands, slot);
            semaphore(vk::PipelineStageFlags::COMPUTE_SHADER);
            renderer.map(commands, slot, slot);
            if waits {
                renderer.contour(commands, slot);
                semaphore(read().stages);
            }
            renderer.draw(commands, slot);
        }
    });
    renderer.end()
}

#[test]
fn the_stages_that_wait_for_semaphores_are_enough() {
    for way in [Way::Shared, Way::HandedOver] {
        assert_eq!(messages_of_one_queue(way, true), Vec::<String>::new(), "{way:?}");
    }
}

/// A hazard must be reported, or a clean log would prove nothing.
#[test]
fn a_semaphore_left_out_is_reported() {
    let messages = messages_of_one_queue(Way::Shared, false);
    assert!(messages.iter().any(|m| m.contains("SYNC-HAZARD-READ-AFTER-WRITE")), "{messages:?}");
}

#[test]
fn the_guide_shows_the_code_that_runs() {
    let guide = include_str!("../../../docs/async-compute.md");
    let copy = include_str!("handover.rs");
    assert!(guide.contains(copy), "copy tests/vulkan/embed/handover.rs into docs/async-compute.md");
}
