//! What differs where a device has two queue families, on devices that have one.

use geosweep::ash::vk;

use crate::host::queues::{Place, choose, counts};

/// Devices that there are, as they list their queue families.
#[test]
fn the_other_queue_is_of_a_family_without_graphics_if_there_is_one() {
    let (graphics, compute) = (vk::QueueFlags::GRAPHICS, vk::QueueFlags::COMPUTE);
    let (transfer, video) = (vk::QueueFlags::TRANSFER, vk::QueueFlags::VIDEO_DECODE_KHR);
    let all = graphics | compute | transfer;
    let at = |family, index| Place { family, index };
    for (name, families, expected, created) in [
        ("lavapipe", &[(all, 1)][..], [at(0, 0), at(0, 0)], &[(0, 1)][..]),
        ("Intel", &[(all, 2)], [at(0, 0), at(0, 1)], &[(0, 2)]),
        ("AMD", &[(all, 1), (compute | transfer, 4)], [at(0, 0), at(1, 0)], &[(0, 1), (1, 1)]),
        (
            "NVIDIA",
            &[(all, 16), (transfer, 2), (compute | transfer, 8), (transfer | video, 1)],
            [at(0, 0), at(2, 0)],
            &[(0, 1), (2, 1)],
        ),
        ("two alike", &[(all, 1), (all, 1)], [at(0, 0), at(1, 0)], &[(0, 1), (1, 1)]),
        (
            "alike and without",
            &[(transfer, 1), (all, 4), (all, 1), (compute, 1)],
            [at(1, 0), at(3, 0)],
            &[(1, 1), (3, 1)],
        ),
        ("drawing apart", &[(graphics, 1), (all, 1)], [at(1, 0), at(1, 0)], &[(1, 1)]),
    ] {
        let families: Vec<_> = families
            .iter()
            .map(|&(queue_flags, queue_count)| vk::QueueFamilyProperties {
                queue_flags,
                queue_count,
                ..Default::default()
            })
            .collect();
        let places = choose(&families).unwrap();
        assert_eq!(places, expected, "{name}");
        assert_eq!(counts(places).collect::<Vec<_>>(), created, "{name}");
    }
    assert_eq!(choose(&[]), None);
}
