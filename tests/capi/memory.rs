//! Device memory from an allocator of the program.

use std::collections::BTreeMap;
use std::ffi::{CStr, c_void};
use std::ptr::null_mut;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};

use geosweep::ash::{
    self,
    vk::{self, Handle},
};
use geosweep_capi::*;

use crate::host::Host;
use crate::session::{
    Session, all_wrong, frame, height_points, last_error, method, ok, refused, solver_info,
    surface_info, wrong,
};

/// Simple allocator of a program. It calls `vkAllocateMemory` for each block. A block begins at [`OFFSET`] in its
/// memory.
struct Plain {
    device: ash::Device,
    types: vk::PhysicalDeviceMemoryProperties,
    /// The purpose of each block, and whether it is for a buffer, by its memory handle.
    blocks: Mutex<BTreeMap<u64, (String, bool)>>,
    calls: Mutex<Calls>,
    /// A pause of the next call of `allocate`: the call tells the first channel's receiver, and waits for the second.
    pause: Mutex<Option<(Sender<()>, Receiver<()>)>>,
}

#[derive(Default)]
struct Calls {
    allocated: u32,
    /// Number of the call that fails, and its fault.
    fault: Option<(u32, Fault)>,
}

#[derive(Clone, Copy)]
enum Fault {
    Returns(vk::Result),
    GivesNothing,
    DoesNotMap,
    IsMisplaced,
}

const OFFSET: u64 = 1 << 16;

impl Plain {
    fn new(host: &Host) -> Box<Self> {
        let types =
            unsafe { host.instance.get_physical_device_memory_properties(host.physical_device) };
        let (blocks, calls) = (Mutex::default(), Mutex::default());
        let pause = Mutex::new(None);
        Box::new(Self { device: host.device.clone(), types, blocks, calls, pause })
    }

    fn interface(&self) -> GeosweepAllocator {
        let user = std::ptr::from_ref(self).cast_mut().cast();
        GeosweepAllocator { user, allocate: Some(allocate), free: Some(free) }
    }

    fn solver(&self, host: &Host) -> *mut GeosweepSolver {
        let allocator = self.interface();
        let info = GeosweepSolverInfo { allocator: &allocator, ..solver_info(host) };
        let mut solver = null_mut();
        ok(unsafe { geosweep_solver_create(&info, &mut solver) });
        solver
    }
}

unsafe extern "C" fn allocate(
    user: *mut c_void,
    request: *const GeosweepMemoryRequest,
    memory: *mut GeosweepMemory,
) -> vk::Result {
    let (plain, request, memory) = unsafe { (&*user.cast::<Plain>(), &*request, &mut *memory) };
    assert!(memory.memory.is_null() && memory.mapped.is_null() && memory.offset == 0);
    if let Some((is_here, goes_on)) = plain.pause.lock().unwrap().take() {
        is_here.send(()).unwrap();
        goes_on.recv().unwrap();
    }
    let mut calls = plain.calls.lock().unwrap();
    calls.allocated += 1;
    let fault =
        calls.fault.and_then(|(number, fault)| (number == calls.allocated).then_some(fault));
    match fault {
        Some(Fault::Returns(result)) => return result,
        Some(Fault::GivesNothing) => return vk::Result::SUCCESS,
        _ => {}
    }
    let fits = |wanted: vk::MemoryPropertyFlags| {
        plain.types.memory_types_as_slice().iter().enumerate().position(|(number, kind)| {
            request.requirements.memory_type_bits & (1 << number) != 0
                && kind.property_flags.contains(wanted)
        })
    };
    let kind = fits(request.required | request.preferred).or_else(|| fits(request.required));
    let kind = kind.expect("the device has such memory") as u32;
    let info = vk::MemoryAllocateInfo::default()
        .allocation_size(request.requirements.size + OFFSET)
        .memory_type_index(kind);
    memory.memory = unsafe { plain.device.allocate_memory(&info, None) }.unwrap();
    memory.offset = OFFSET;
    if request.required.contains(vk::MemoryPropertyFlags::HOST_VISIBLE) {
        let (flags, size) = (vk::MemoryMapFlags::empty(), request.requirements.size);
        let mapped = unsafe { plain.device.map_memory(memory.memory, OFFSET, size, flags) };
        memory.mapped = mapped.unwrap();
    }
    memory.handle = memory.memory.as_raw() as *mut c_void;
    match fault {
        Some(Fault::DoesNotMap) => memory.mapped = null_mut(),
        Some(Fault::IsMisplaced) => memory.offset = 1,
        _ => {}
    }
    let name = unsafe { CStr::from_ptr(request.name) }.to_str().unwrap().to_owned();
    plain.blocks.lock().unwrap().insert(memory.memory.as_raw(), (name, request.is_buffer));
    vk::Result::SUCCESS
}

unsafe extern "C" fn free(user: *mut c_void, memory: *const GeosweepMemory) {
    let (plain, memory) = unsafe { (&*user.cast::<Plain>(), &*memory) };
    assert_eq!(memory.handle as u64, memory.memory.as_raw());
    assert!(plain.blocks.lock().unwrap().remove(&memory.memory.as_raw()).is_some());
    unsafe { plain.device.free_memory(memory.memory, None) };
}

/// All device memory comes from the program's allocator, also for points in the program's memory. Maps are
/// the same as with the solver's own blocks, and all memory is freed.
#[test]
fn the_programs_allocator_provides_all_memory() {
    let heights: Vec<f32> = (0..40 * 48).map(|point| (0.3 * point as f32).sin()).collect();
    let points = [height_points(&heights)];
    let mut maps = Vec::new();
    let mut host = Host::new();
    let plain = Plain::new(&host);
    for own in [true, false] {
        let mut session = match own {
            true => Session::new(host),
            false => Session { solver: plain.solver(&host), host },
        };
        let surface = session.surface(&surface_info(40, 48, &points));
        let (mut contours, mut paths, mut regions) = (null_mut(), null_mut(), null_mut());
        ok(unsafe { geosweep_contours_create(surface, 1000, &mut contours) });
        ok(unsafe { geosweep_paths_create(surface, 1, 100, &mut paths) });
        let curved = GeosweepWavefront::Curved as i32;
        ok(unsafe { geosweep_regions_create(surface, curved, &mut regions) });
        let plan = session.plan(40, 48, &method(GeosweepWavefront::Curved, 50));
        let sources = [geosweep_source_at(4.25, 30.5)];
        maps.push(session.map(surface, &frame(plan, &sources)));
        assert!(session.outcome(surface).converged);
        let blocks = plain.blocks.lock().unwrap().clone();
        let mut bytes = 0;
        ok(unsafe { geosweep_solver_bytes(session.solver, &mut bytes) });
        if own {
            assert!(blocks.is_empty());
        } else {
            assert!(blocks.len() >= 8, "{blocks:?}");
            assert!(blocks.values().any(|(name, buffer)| name == "edge lengths" && !buffer));
            assert!(blocks.values().any(|(_, buffer)| *buffer));
            let mut of_surface = 0;
            ok(unsafe { geosweep_surface_bytes(surface, &mut of_surface) });
            assert!(of_surface > 0 && bytes > of_surface, "{bytes}, {of_surface}");
        }
        unsafe {
            ok(geosweep_contours_destroy(contours));
            ok(geosweep_paths_destroy(paths));
            ok(geosweep_regions_destroy(regions));
            ok(geosweep_surface_destroy(surface));
            ok(geosweep_plan_destroy(plan));
            ok(geosweep_solver_bytes(session.solver, &mut bytes));
            assert!(own || bytes == 0, "{bytes}");
            ok(geosweep_solver_destroy(session.solver));
        }
        assert!(plain.blocks.lock().unwrap().is_empty());
        host = session.host;
    }
    assert!(maps[0] == maps[1], "the maps differ");
    assert_eq!((host.messages(), host.allocations()), (Vec::new(), 0));
}

/// Whatever fault the program's allocator has, the call returns an error that names the fault, and all memory
/// is freed.
#[test]
fn faults_of_the_programs_allocator_are_errors() {
    let host = Host::new();
    let plain = Plain::new(&host);
    let solver = plain.solver(&host);
    let data = [0.0f32; 9 * 12];
    let points = [height_points(&data)];
    let info = surface_info(9, 12, &points);
    let create = || {
        plain.calls.lock().unwrap().allocated = 0;
        let mut surface = null_mut();
        let status = unsafe { geosweep_surface_create(solver, &info, &mut surface) };
        (status, surface)
    };
    let (status, surface) = create();
    ok(status);
    ok(unsafe { geosweep_surface_destroy(surface) });
    let count = plain.calls.lock().unwrap().allocated;
    assert!(count >= 5, "{count}");
    use GeosweepStatus as Status;
    let out_of_memory = vk::Result::ERROR_OUT_OF_DEVICE_MEMORY;
    let mut refused_unmapped = 0;
    for number in 1..=count {
        for (fault, expected, words) in [
            (Fault::Returns(out_of_memory), Status::OutOfMemory, "cannot allocate"),
            (
                Fault::Returns(vk::Result::ERROR_UNKNOWN),
                Status::VulkanError,
                "your allocator has returned",
            ),
            (Fault::GivesNothing, Status::VulkanError, "has given no memory"),
            (Fault::IsMisplaced, Status::VulkanError, "no multiple of the alignment"),
            (Fault::DoesNotMap, Status::VulkanError, "that is not mapped"),
        ] {
            plain.calls.lock().unwrap().fault = Some((number, fault));
            let (status, surface) = create();
            if matches!(fault, Fault::DoesNotMap) && status == Status::Success {
                // Only memory that the program reads or writes must be mapped.
                ok(unsafe { geosweep_surface_destroy(surface) });
            } else {
                refused(status, expected, words);
                refused_unmapped += u32::from(matches!(fault, Fault::DoesNotMap));
            }
            assert!(plain.blocks.lock().unwrap().is_empty());
        }
    }
    assert!(refused_unmapped > 0 && refused_unmapped < count, "{refused_unmapped} of {count}");
    ok(unsafe { geosweep_solver_destroy(solver) });

    let interface = plain.interface();
    let with = |allocator: GeosweepAllocator| {
        let info = GeosweepSolverInfo { allocator: &allocator, ..solver_info(&host) };
        let mut solver = null_mut();
        unsafe { geosweep_solver_create(&info, &mut solver) }
    };
    all_wrong! {
        with(GeosweepAllocator { allocate: None, ..interface }) => "info->allocator->allocate is null",
        with(GeosweepAllocator { free: None, ..interface }) => "info->allocator->free is null",
    }
    assert_eq!((host.messages(), host.allocations()), (Vec::new(), 0));
}

/// While a call of another thread uses an object, the object cannot be destroyed or changed. Nor can it be used while a
/// call changes it.
#[test]
fn objects_that_another_thread_uses_are_kept() {
    let host = Host::new();
    let plain = Plain::new(&host);
    let solver = plain.solver(&host);
    let data = [0.0f32; 9 * 12];
    let points = [height_points(&data)];
    let mut surface = null_mut();
    ok(unsafe { geosweep_surface_create(solver, &surface_info(9, 12, &points), &mut surface) });
    // Pointers as numbers, which threads may share.
    let (of_surface, of_solver) = (surface as usize, solver as usize);
    let during = |uses: &(dyn Fn() + Sync), meanwhile: &dyn Fn()| {
        let ((is_here, here), (go_on, goes_on)) = (channel(), channel());
        *plain.pause.lock().unwrap() = Some((is_here, goes_on));
        std::thread::scope(|threads| {
            threads.spawn(uses);
            here.recv().unwrap();
            meanwhile();
            go_on.send(()).unwrap();
        });
    };
    let made = AtomicUsize::new(0);
    let makes = || {
        let mut contours = null_mut();
        let surface = of_surface as *const GeosweepSurface;
        ok(unsafe { geosweep_contours_create(surface, 100, &mut contours) });
        made.store(contours as usize, Ordering::SeqCst);
    };
    during(&makes, &|| unsafe {
        all_wrong! {
            geosweep_surface_destroy(surface) => "surface is used by a call on another thread",
            geosweep_surface_write_points(surface, 0, data.as_ptr(), std::ptr::null()) => "surface is used by",
        }
        // Other calls that only use the object succeed.
        ok(geosweep_surface_bytes(surface, &mut 0));
    });
    let contours = made.load(Ordering::SeqCst) as *mut GeosweepContours;
    ok(unsafe { geosweep_contours_destroy(contours) });
    let makes = || {
        let mut other = null_mut();
        let (data, solver) = ([0.0f32; 9 * 12], of_solver as *const GeosweepSolver);
        let points = [height_points(&data)];
        ok(unsafe { geosweep_surface_create(solver, &surface_info(9, 12, &points), &mut other) });
        ok(unsafe { geosweep_surface_destroy(other) });
    };
    during(&makes, &|| {
        wrong(
            unsafe { geosweep_solver_destroy(solver) },
            "solver is used by a call on another thread",
        );
    });
    ok(unsafe { geosweep_surface_destroy(surface) });
    ok(unsafe { geosweep_solver_destroy(solver) });
    assert_eq!((host.messages(), host.allocations()), (Vec::new(), 0));
}

/// A thread may record while another destroys the surface: with checks, each call succeeds or is refused.
#[test]
fn recording_and_destroying_at_the_same_time_is_refused_or_succeeds() {
    let session = Session::with_checks(Host::new());
    let data = [0.0f32; 9 * 12];
    let points = [height_points(&data)];
    for _ in 0..20 {
        let surface = session.surface(&surface_info(9, 12, &points)) as usize;
        std::thread::scope(|threads| {
            let reads = || {
                let surface = surface as *const GeosweepSurface;
                loop {
                    match unsafe { geosweep_surface_bytes(surface, &mut 0) } {
                        GeosweepStatus::Success => {}
                        status => break (status, last_error()),
                    }
                }
            };
            let readers = [threads.spawn(reads), threads.spawn(reads)];
            let destroyed = || unsafe { geosweep_surface_destroy(surface as *mut GeosweepSurface) };
            while destroyed() != GeosweepStatus::Success {
                let message = last_error();
                assert!(message.contains("is used by a call on another thread"), "{message}");
            }
            for reader in readers {
                let (status, message) = reader.join().unwrap();
                assert_eq!(status, GeosweepStatus::InvalidArgument);
                let words = ["was destroyed before", "is being changed or destroyed"];
                assert!(words.iter().any(|words| message.contains(words)), "{message}");
            }
        });
    }
    session.end([]);
}
