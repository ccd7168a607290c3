//! Differences between devices with one and with two queue families, tested on devices with one.

use std::cell::{Cell, RefCell};
use std::mem::{take, transmute};

use geosweep::ash::vk::{self, Handle};

use crate::embed::frames::{Renderer, Way};
use crate::host::Host;
use crate::host::queues::{Place, choose, counts};

/// Lists of queue families of real devices.
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

/// Two families for a device that does not check them.
const FAMILIES: [u32; 2] = [0, 1];

thread_local! {
    static CREATE_IMAGE: Cell<Option<vk::PFN_vkCreateImage>> = const { Cell::new(None) };
    /// Formats of the images that were created, and the families that share them.
    static IMAGES: RefCell<Vec<(vk::Format, Vec<u32>)>> = const { RefCell::new(Vec::new()) };
    static HANDED: RefCell<Handed> = const { RefCell::new(Handed::new()) };
}

/// Resources that barriers transfer: a handle, both families, and both layouts.
type Things = Vec<(u64, [u32; 2], [vk::ImageLayout; 2])>;

#[derive(Debug, Default)]
struct Handed {
    given: Things,
    taken: Things,
}

impl Handed {
    const fn new() -> Self {
        Self { given: Vec::new(), taken: Vec::new() }
    }
}

unsafe extern "system" fn keep_image(
    device: vk::Device,
    info: *const vk::ImageCreateInfo<'_>,
    callbacks: *const vk::AllocationCallbacks<'_>,
    image: *mut vk::Image,
) -> vk::Result {
    let made = unsafe { &*info };
    let shared = made.sharing_mode == vk::SharingMode::CONCURRENT;
    let count = if shared { made.queue_family_index_count as usize } else { 0 };
    let families = (0..count).map(|k| unsafe { *made.p_queue_family_indices.add(k) }).collect();
    IMAGES.with_borrow_mut(|images| images.push((made.format, families)));
    unsafe { CREATE_IMAGE.get().unwrap()(device, info, callbacks, image) }
}

unsafe extern "system" fn keep_barriers(
    _: vk::CommandBuffer,
    before: vk::PipelineStageFlags,
    after: vk::PipelineStageFlags,
    _: vk::DependencyFlags,
    _: u32,
    _: *const vk::MemoryBarrier<'_>,
    buffers: u32,
    buffer: *const vk::BufferMemoryBarrier<'_>,
    images: u32,
    image: *const vk::ImageMemoryBarrier<'_>,
) {
    let none = vk::AccessFlags::NONE;
    let keep = |thing: u64, families: [u32; 2], layouts, [written, read]: [vk::AccessFlags; 2]| {
        if families[0] == families[1] {
            return;
        }
        let gives = read == none && after == vk::PipelineStageFlags::BOTTOM_OF_PIPE;
        assert_ne!(gives, written == none && before == after, "a side of a handover");
        HANDED.with_borrow_mut(|Handed { given, taken }| {
            if gives { given } else { taken }.push((thing, families, layouts));
        });
    };
    for k in 0..buffers as usize {
        let b = unsafe { *buffer.add(k) };
        assert_eq!((b.offset, b.size), (0, vk::WHOLE_SIZE));
        let families = [b.src_queue_family_index, b.dst_queue_family_index];
        let layouts = [vk::ImageLayout::UNDEFINED; 2];
        keep(b.buffer.as_raw(), families, layouts, [b.src_access_mask, b.dst_access_mask]);
    }
    for k in 0..images as usize {
        let i = unsafe { *image.add(k) };
        let families = [i.src_queue_family_index, i.dst_queue_family_index];
        let layouts = [i.old_layout, i.new_layout];
        keep(i.image.as_raw(), families, layouts, [i.src_access_mask, i.dst_access_mask]);
    }
}

/// Returns a function in the form that [`Host::device_with`] requires. It is called with its real arguments.
fn replacement(function: *const ()) -> extern "system" fn() -> vk::Result {
    unsafe { transmute::<*const (), extern "system" fn() -> vk::Result>(function) }
}

/// Each queue acquires what the other releases, with the same barriers except for stages and accesses. Images
/// that readers sample are created for both families or for one, and all other images for one.
#[test]
fn one_family_acquires_what_the_other_releases() {
    // These are the packed texels, and an image of distances for each frame.
    let (packed, distances) = (vk::Format::R32G32B32A32_SFLOAT, vk::Format::R32_SFLOAT);
    for (way, formats, from_main, from_other) in
        [(Way::Shared, &[packed, distances, distances][..], 0, 1), (Way::HandedOver, &[], 1, 3)]
    {
        let mut host = Host::without_validation();
        CREATE_IMAGE.set(Some(host.device.fp_v1_0().create_image));
        host.device = host.device_with(|name| match name.to_bytes() {
            b"vkCreateImage" => Some(replacement(keep_image as *const ())),
            b"vkCmdPipelineBarrier" => Some(replacement(keep_barriers as *const ())),
            _ => None,
        });
        let renderer = Renderer::new(host, way, FAMILIES);
        let images = IMAGES.take();
        let shared = images.iter().filter(|(_, families)| families == &FAMILIES);
        let shared: Vec<_> = shared.map(|(format, _)| *format).collect();
        assert_eq!(shared, formats, "{way:?}");
        let owned = images.iter().filter(|(_, families)| families.is_empty()).count();
        assert!(owned > 0 && owned + shared.len() == images.len());
        let commands = renderer.host.commands();
        renderer.host.begin(commands);
        renderer.deform(commands, 0);
        let moving = HANDED.with_borrow_mut(take);
        renderer.map(commands, 0, 0);
        renderer.contour(commands, 0);
        let mapping = HANDED.with_borrow_mut(take);
        renderer.draw(commands, 0);
        let drawing = HANDED.with_borrow_mut(take);
        renderer.host.end(commands);
        assert_eq!((moving.given.len(), mapping.given.len()), (from_main, from_other), "{way:?}");
        assert_eq!(moving.given, mapping.taken);
        assert_eq!(mapping.given, drawing.taken);
        assert_eq!((moving.taken.len(), drawing.given.len()), (0, 0));
        renderer.end();
    }
}
