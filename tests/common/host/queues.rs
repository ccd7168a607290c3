//! The two queues of the renderer, and their families and indices on a device.

use geosweep::ash::{self, vk};

/// Queue, by its family and its index in the family.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    pub family: u32,
    pub index: u32,
}

/// A queue with a pool for its command buffers.
pub struct HostQueue {
    pub handle: vk::Queue,
    pub family: u32,
    pub pool: vk::CommandPool,
}

impl HostQueue {
    pub fn new(device: &ash::Device, Place { family, index }: Place) -> Self {
        let info = vk::CommandPoolCreateInfo::default()
            .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER)
            .queue_family_index(family);
        unsafe {
            let pool = device.create_command_pool(&info, None).unwrap();
            Self { handle: device.get_device_queue(family, index), family, pool }
        }
    }
}

/// Returns the family and the index of the main queue and of the second queue.
pub fn of(instance: &ash::Instance, physical_device: vk::PhysicalDevice) -> [Place; 2] {
    let families = unsafe { instance.get_physical_device_queue_family_properties(physical_device) };
    choose(&families).expect("the tests need a queue for compute and graphics")
}

/// Chooses a main queue for compute and graphics, and a second one for compute. The second one is of a family
/// without graphics if possible, or of any other family, or the main family's second queue, or the main queue
/// itself.
pub fn choose(families: &[vk::QueueFamilyProperties]) -> Option<[Place; 2]> {
    let (compute, graphics) = (vk::QueueFlags::COMPUTE, vk::QueueFlags::GRAPHICS);
    let main = families.iter().position(|f| f.queue_flags.contains(compute | graphics))?;
    let others = || {
        let all = families.iter().enumerate();
        all.filter(|&(number, family)| number != main && family.queue_flags.contains(compute))
    };
    let beside = others()
        .find(|(_, family)| !family.queue_flags.contains(graphics))
        .or_else(|| others().next())
        .map(|(number, _)| Place { family: number as u32, index: 0 });
    let second = u32::from(families[main].queue_count > 1);
    let main = Place { family: main as u32, index: 0 };
    Some([main, beside.unwrap_or(Place { index: second, ..main })])
}

/// Returns the number of queues of each family with which a device is created.
pub fn counts([main, beside]: [Place; 2]) -> impl Iterator<Item = (u32, usize)> {
    let apart = main.family != beside.family;
    let of_main = if apart { 1 } else { beside.index as usize + 1 };
    let other = apart.then_some((beside.family, beside.index as usize + 1));
    std::iter::once((main.family, of_main)).chain(other)
}
