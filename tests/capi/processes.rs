//! Mistakes that renderers make. Each runs in its own process with checks, with and without the validation
//! layers. The process continues, and a call's status or an outcome reports the mistake.

use std::process::Command;
use std::ptr::null_mut;

use geosweep::ash::vk;
use geosweep::capi::*;

use crate::host::{Host, HostBuffer};
use crate::session::{
    RASTER, Session, entry, frame, get_instance_proc_addr, last_error, method, ok, solver_info,
    surface_info, zero,
};

const ROWS: u32 = 90;
const COLS: u32 = 110;
const POINTS: usize = (ROWS * COLS) as usize;
const NAME: &str = "GEOSWEEP_TEST_MISTAKE";

/// A surface with checks, two slots, points 0 in a ring of two parts, and points 1 in the program's memory.
struct Scene {
    session: Session,
    surface: *mut GeosweepSurface,
    plan: *mut GeosweepPlan,
    sources: [GeosweepSource; 1],
    ring: HostBuffer,
    heights: Vec<f32>,
}

impl Scene {
    /// Creates the scene. If `is_ready` is set, prepares and measures the surface.
    fn new(layers: bool, is_ready: bool) -> Self {
        let mut host = if layers {
            Host::with_synchronization_validation()
        } else {
            Host::without_validation()
        };
        let heights: Vec<f32> = (0..POINTS).map(|index| (0.1 * index as f32).sin()).collect();
        let ring = host.buffer_of(&[&heights[..], &[0.0; POINTS]].concat());
        let flags = GEOSWEEP_SOLVER_CHECKS;
        let (passes, pass_count) = (RASTER[2..].as_ptr(), 1);
        let info = GeosweepSolverInfo { flags, passes, pass_count, ..solver_info(&host) };
        let mut solver = null_mut();
        ok(unsafe { geosweep_solver_create(&info, &mut solver) });
        let session = Session { host, solver };
        let kind = GeosweepPointKind::Heights as i32;
        let points = GeosweepPoints { kind, dx: 1.0, dy: 1.0, stride: 4, ..zero() };
        let points = [
            GeosweepPoints { buffer: ring.handle, ..points },
            GeosweepPoints { data: heights.as_ptr(), ..points },
        ];
        let info = GeosweepSurfaceInfo { slots: 2, ..surface_info(ROWS, COLS, &points) };
        let mut surface = null_mut();
        ok(unsafe { geosweep_surface_create(solver, &info, &mut surface) });
        let plan = session.plan(ROWS, COLS, &method(GeosweepWavefront::Curved, 12));
        let sources = [geosweep_source_at(3.0, 4.0)];
        let scene = Self { session, surface, plan, sources, ring, heights };
        if is_ready {
            scene.session.host.run(|commands| unsafe {
                ok(geosweep_record_prepare(surface, commands));
                ok(geosweep_record_frame(surface, commands, &scene.frame(), null_mut()));
            });
        }
        scene
    }

    fn frame(&self) -> GeosweepFrame {
        frame(self.plan, &self.sources)
    }

    /// Records and, if `submits` is set, submits. Waits for nothing.
    fn record(&self, submits: bool, record: impl FnOnce(vk::CommandBuffer)) {
        let host = &self.session.host;
        let commands = host.commands();
        host.begin(commands);
        record(commands);
        host.end(commands);
        if submits {
            host.submit(commands, vk::Fence::null());
        }
    }

    fn wait(&self) {
        unsafe { self.session.host.device.device_wait_idle() }.unwrap();
    }

    /// Destroys what remains.
    fn end(self) {
        self.wait();
        ok(unsafe { geosweep_surface_destroy(self.surface) });
        ok(unsafe { geosweep_plan_destroy(self.plan) });
        ok(unsafe { geosweep_solver_destroy(self.session.solver) });
        let Self { session: Session { mut host, .. }, ring, .. } = self;
        host.free(ring);
        assert_eq!(host.allocations(), 0);
    }
}

/// A mistake and how it is reported.
struct Mistake {
    name: &'static str,
    make: fn(layers: bool) -> String,
    /// Words of the report.
    told: &'static str,
}

/// Returns the message of a call that must be refused.
fn said(status: GeosweepStatus) -> String {
    assert_ne!(status, GeosweepStatus::Success);
    last_error()
}

/// Destroys an object while the frame and a recording that uses it are in flight, which must be refused.
/// Destroys it again afterwards, which must succeed. Returns the message of the refusal.
fn destroyed<T>(
    scene: &Scene,
    made: *mut T,
    record: impl Fn(vk::CommandBuffer) -> GeosweepStatus,
    destroy: impl Fn(*mut T) -> GeosweepStatus,
) -> String {
    scene.record(true, |commands| unsafe {
        ok(geosweep_record_begin(scene.surface, commands, zero()));
        let plan = scene.plan;
        ok(geosweep_record_solve(scene.surface, commands, &scene.frame().sources, plan));
        ok(record(commands));
    });
    let told = said(destroy(made));
    scene.wait();
    ok(destroy(made));
    told
}

const MISTAKES: [Mistake; 14] = [
    Mistake {
        name: "an access whose stage was cut off",
        make: |layers| {
            let scene = Scene::new(layers, true);
            let access = vk::AccessFlags::TRANSFER_WRITE;
            let before = GeosweepAccess { stages: vk::PipelineStageFlags::empty(), access };
            let frame = GeosweepFrame { before, ..scene.frame() };
            let mut told = String::new();
            scene.record(false, |commands| unsafe {
                told = said(geosweep_record_frame(scene.surface, commands, &frame, null_mut()));
                said(geosweep_record_end(scene.surface, commands, before));
                said(geosweep_record_begin(scene.surface, commands, before));
                let access = before;
                let reader = GeosweepReader { access, layout: vk::ImageLayout::GENERAL };
                let frame = GeosweepFrame { reader, ..scene.frame() };
                let refused = geosweep_record_frame(scene.surface, commands, &frame, null_mut());
                assert!(said(refused).contains("frame->reader.access.stages is 0"));
            });
            scene.end();
            told
        },
        told: "frame->before.stages is 0, and the access beside it is 0x1000",
    },
    Mistake {
        name: "an instance for Vulkan 1.0",
        make: |_| {
            let application = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_0);
            let info = vk::InstanceCreateInfo::default().application_info(&application);
            let instance = unsafe { entry().create_instance(&info, None) }.unwrap();
            let device = unsafe { instance.enumerate_physical_devices() }.unwrap()[0];
            let told = said(unsafe {
                geosweep_check_device(get_instance_proc_addr(), instance.handle(), device)
            });
            unsafe { instance.destroy_instance(None) };
            told
        },
        told: "was created for Vulkan 1.0, but 1.1 is needed",
    },
    Mistake {
        name: "a surface with two frames among those recorded together",
        make: |layers| {
            let scene = Scene::new(layers, true);
            let surfaces = [scene.surface.cast_const(); 2];
            let frames = [scene.frame(), GeosweepFrame { slot: 1, ..scene.frame() }];
            let mut told = String::new();
            scene.record(false, |commands| unsafe {
                let (surfaces, frames) = (surfaces.as_ptr(), frames.as_ptr());
                told = said(geosweep_record_frames(surfaces, frames, 2, commands, null_mut()));
            });
            scene.end();
            told
        },
        told: "frames[1]: its surface has another frame among them",
    },
    Mistake {
        name: "a part of the ring that nobody has written",
        make: |layers| {
            let scene = Scene::new(layers, true);
            let frame = GeosweepFrame { points_offset: 4 * POINTS as u64, ..scene.frame() };
            // Heights of zero form a plane. Positions of zero coincide.
            let kind = GeosweepPointKind::Positions as i32;
            let points = GeosweepPoints { kind, buffer: scene.ring.handle, stride: 12, ..zero() };
            let rows = scene.heights.len() as u32 / 3 / COLS;
            let info = surface_info(rows, COLS, std::slice::from_ref(&points));
            let surface = scene.session.surface(&info);
            let plan = scene.session.plan(rows, COLS, &method(GeosweepWavefront::Curved, 12));
            scene.session.host.run(|commands| unsafe {
                let frame = GeosweepFrame { plan, ..frame };
                ok(geosweep_record_frame(surface, commands, &frame, null_mut()));
            });
            let outcome = scene.session.outcome(surface);
            assert!(outcome.edges_without_length > 0);
            ok(unsafe { geosweep_surface_destroy(surface) });
            ok(unsafe { geosweep_plan_destroy(plan) });
            scene.end();
            format!("edges without length: {}", outcome.edges_without_length)
        },
        told: "edges without length",
    },
    Mistake {
        name: "a part beyond the buffer",
        make: |layers| {
            let scene = Scene::new(layers, true);
            let frame = GeosweepFrame { points_offset: 1 << 40, ..scene.frame() };
            let mut told = String::new();
            scene.record(false, |commands| unsafe {
                told = said(geosweep_record_frame(scene.surface, commands, &frame, null_mut()));
            });
            scene.end();
            told
        },
        told: "is beyond the",
    },
    Mistake {
        name: "points replaced more often than there are slots",
        make: |layers| {
            let scene = Scene::new(layers, true);
            let kind = GeosweepPointKind::Heights as i32;
            let buffer = scene.ring.handle;
            let points = GeosweepPoints { kind, dx: 1.0, dy: 1.0, stride: 4, buffer, ..zero() };
            let set = || unsafe { geosweep_surface_set_points(scene.surface, 0, &points) };
            let mut recorded = Vec::new();
            for _ in 0..3 {
                ok(set());
                scene.record(false, |commands| unsafe {
                    ok(geosweep_record_measure(scene.surface, commands, 0, 0));
                    recorded.push(commands);
                });
            }
            let told = said(set());
            for commands in recorded {
                ok(unsafe { geosweep_surface_discard_commands(scene.surface, commands) });
            }
            ok(set());
            scene.end();
            told
        },
        told: "points 0 are replaced again while recordings that read them have not run",
    },
    Mistake {
        name: "contours lifted to points that were replaced",
        make: |layers| {
            let scene = Scene::new(layers, true);
            let mut contours = null_mut();
            ok(unsafe { geosweep_contours_create(scene.surface, 1000, &mut contours) });
            let kind = GeosweepPointKind::Heights as i32;
            let buffer = scene.ring.handle;
            let points = GeosweepPoints { kind, dx: 1.0, dy: 1.0, stride: 4, buffer, ..zero() };
            ok(unsafe { geosweep_surface_set_points(scene.surface, 0, &points) });
            let levels = GeosweepContourFrame { level_count: 3, step: 5.0, ..zero() };
            let mut told = String::new();
            scene.record(false, |commands| unsafe {
                let record = || {
                    geosweep_record_contours(scene.surface, commands, contours, &levels, null_mut())
                };
                told = said(record());
                ok(geosweep_contours_rebind(contours, scene.surface));
                ok(record());
                ok(geosweep_surface_discard_commands(scene.surface, commands));
            });
            ok(unsafe { geosweep_contours_destroy(contours) });
            scene.end();
            told
        },
        told: "geosweep_contours_rebind",
    },
    Mistake {
        name: "a preparation that is lost",
        make: |layers| {
            let scene = Scene::new(layers, false);
            scene.record(false, |commands| unsafe {
                ok(geosweep_record_prepare(scene.surface, commands));
            });
            let frame = scene.frame();
            scene.session.host.run(|commands| unsafe {
                ok(geosweep_record_frame(scene.surface, commands, &frame, null_mut()));
            });
            let told = said(unsafe { geosweep_surface_outcome(scene.surface, 0, &mut zero()) });
            scene.end();
            told
        },
        told: "preparation was recorded and has not run",
    },
    Mistake {
        name: "contours destroyed in flight",
        make: |layers| {
            let scene = Scene::new(layers, true);
            let mut contours = null_mut();
            ok(unsafe { geosweep_contours_create(scene.surface, 1000, &mut contours) });
            let levels = GeosweepContourFrame { level_count: 3, step: 5.0, ..zero() };
            let surface = scene.surface;
            let told = destroyed(
                &scene,
                contours,
                |commands| unsafe {
                    geosweep_record_contours(surface, commands, contours, &levels, null_mut())
                },
                |contours| unsafe { geosweep_contours_destroy(contours) },
            );
            scene.end();
            told
        },
        told: "contours is destroyed and a recording of it has not run",
    },
    Mistake {
        name: "paths destroyed in flight",
        make: |layers| {
            let scene = Scene::new(layers, true);
            let mut paths = null_mut();
            ok(unsafe { geosweep_paths_create(scene.surface, 1, 500, &mut paths) });
            let starts = [20.0, 30.0];
            let of = GeosweepPathFrame {
                starts: starts.as_ptr(),
                start_count: 1,
                sources: scene.frame().sources,
                ..zero()
            };
            let surface = scene.surface;
            let told = destroyed(
                &scene,
                paths,
                |commands| unsafe {
                    geosweep_record_paths(surface, commands, paths, &of, null_mut())
                },
                |paths| unsafe { geosweep_paths_destroy(paths) },
            );
            scene.end();
            told
        },
        told: "paths is destroyed and a recording of it has not run",
    },
    Mistake {
        name: "regions destroyed in flight",
        make: |layers| {
            let scene = Scene::new(layers, true);
            let mut regions = null_mut();
            let curved = GeosweepWavefront::Curved as i32;
            ok(unsafe { geosweep_regions_create(scene.surface, curved, &mut regions) });
            let of = GeosweepRegionFrame { sources: scene.frame().sources, ..zero() };
            let surface = scene.surface;
            let told = destroyed(
                &scene,
                regions,
                |commands| unsafe {
                    geosweep_record_regions(surface, commands, regions, &of, null_mut())
                },
                |regions| unsafe { geosweep_regions_destroy(regions) },
            );
            scene.end();
            told
        },
        told: "regions is destroyed and a recording of it has not run",
    },
    Mistake {
        name: "a surface recorded without an outcome, destroyed in flight",
        make: |layers| {
            let scene = Scene::new(layers, true);
            scene.record(true, |commands| unsafe {
                ok(geosweep_record_begin(scene.surface, commands, zero()));
                ok(geosweep_record_measure(scene.surface, commands, 1, 0));
                let (sources, plan) = (scene.frame().sources, scene.plan);
                ok(geosweep_record_solve(scene.surface, commands, &sources, plan));
            });
            let told = said(unsafe { geosweep_surface_destroy(scene.surface) });
            scene.end();
            told
        },
        told: "surface is destroyed and a recording of it has not run",
    },
    Mistake {
        name: "points written in flight",
        make: |layers| {
            let scene = Scene::new(layers, true);
            let data = scene.heights.as_ptr();
            let write = || unsafe {
                geosweep_surface_write_points(scene.surface, 1, data, std::ptr::null())
            };
            ok(write());
            scene.record(true, |commands| unsafe {
                let frame = GeosweepFrame { points: 1, slot: 1, ..scene.frame() };
                ok(geosweep_record_frame(scene.surface, commands, &frame, null_mut()));
            });
            let told = said(write());
            scene.wait();
            ok(write());
            scene.end();
            told
        },
        told: "number is 1, and a recording that reads these points has not run",
    },
    Mistake {
        name: "an outcome of another surface",
        make: |layers| {
            let scene = Scene::new(layers, true);
            let bytes = [0u8; GEOSWEEP_OUTCOME_BYTES as usize];
            let told = said(unsafe {
                geosweep_outcome_from_bytes(scene.surface, bytes.as_ptr(), &mut zero())
            });
            scene.end();
            told
        },
        told: "preparation was recorded and has not run",
    },
];

/// Runs the mistake that the environment variable names. [`mistakes_are_reported_and_end_no_process`] starts a process
/// for each mistake. Without the variable, this test does nothing.
#[test]
fn a_process_with_a_mistake() {
    let Ok(wanted) = std::env::var(NAME) else { return };
    let (name, layers) = wanted.split_once('/').unwrap();
    let mistake = MISTAKES.iter().find(|mistake| mistake.name == name).unwrap();
    println!("told: {}", (mistake.make)(layers == "layers"));
}

#[test]
fn mistakes_are_reported_and_end_no_process() {
    let program = std::env::current_exe().unwrap();
    for Mistake { name, told, .. } in &MISTAKES {
        for layers in ["layers", "none"] {
            let run = Command::new(&program)
                .args(["processes::a_process_with_a_mistake", "--exact", "--nocapture"])
                .env(NAME, format!("{name}/{layers}"))
                .output()
                .unwrap();
            let printed = String::from_utf8_lossy(&run.stdout);
            let complaint = String::from_utf8_lossy(&run.stderr);
            assert!(run.status.success(), "{name}, {layers}: {}\n{complaint}", run.status);
            let line = printed.lines().find_map(|line| line.split_once("told: "));
            let (_, said) = line.unwrap_or_else(|| panic!("{name}, {layers}: {printed}"));
            assert!(said.contains(told), "{name}, {layers}: {said}");
        }
    }
}
