//! Mistakes that renderers make, with checks, with and without the validation layers. A call's status or an outcome
//! reports each, and the renderer continues.

use std::ptr::null_mut;

use geosweep::ash::vk;
use geosweep_capi::*;

use crate::host::{Host, HostBuffer};
use crate::session::{
    Session, destroy, entry, frame, get_instance_proc_addr, height_points, last_error, method, ok,
    surface_info, zero,
};

const ROWS: u32 = 90;
const COLS: u32 = 110;
const POINTS: usize = (ROWS * COLS) as usize;

/// A surface with two slots, points 0 in a ring of two parts, and points 1 in the program's memory.
struct Scene<'a> {
    session: &'a Session,
    surface: *mut GeosweepSurface,
    plan: *mut GeosweepPlan,
    sources: [GeosweepSource; 1],
    ring: vk::Buffer,
    heights: &'a [f32],
}

impl<'a> Scene<'a> {
    /// Creates the scene. If `is_ready` is set, prepares and measures the surface.
    fn new(session: &'a Session, ring: &HostBuffer, heights: &'a [f32], is_ready: bool) -> Self {
        let points = [in_buffer(ring.handle), height_points(heights)];
        let info = GeosweepSurfaceInfo { slots: 2, ..surface_info(ROWS, COLS, &points) };
        let mut surface = null_mut();
        ok(unsafe { geosweep_surface_create(session.solver, &info, &mut surface) });
        let plan = session.plan(ROWS, COLS, &method(GeosweepWavefront::Curved, 12));
        let sources = [geosweep_source_at(3.0, 4.0)];
        let scene = Self { session, surface, plan, sources, ring: ring.handle, heights };
        if is_ready {
            session.host.run(|commands| unsafe {
                ok(geosweep_record_prepare(surface, commands));
                ok(geosweep_record_frame(surface, commands, &scene.frame(), null_mut()));
            });
        }
        scene
    }

    fn frame(&self) -> GeosweepFrame {
        frame(self.plan, &self.sources)
    }

    /// Records commands and waits for none.
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

    /// Submits a map without an outcome, and what `record` adds.
    fn solve(&self, record: impl FnOnce(vk::CommandBuffer)) {
        self.record(true, |commands| unsafe {
            ok(geosweep_record_begin(self.surface, commands, zero()));
            ok(geosweep_record_solve(self.surface, commands, &self.frame().sources, self.plan));
            record(commands);
        });
    }

    fn wait(&self) {
        unsafe { self.session.host.device.device_wait_idle() }.unwrap();
    }

    /// Destroys an object while a recording that uses it is in flight, which must be refused. Destroys it again
    /// afterwards, which must succeed. Returns the message of the refusal.
    fn destroyed<T>(
        &self,
        made: *mut T,
        record: impl FnOnce(vk::CommandBuffer) -> GeosweepStatus,
        destroy: impl Fn(*mut T) -> GeosweepStatus,
    ) -> String {
        self.solve(|commands| ok(record(commands)));
        let told = said(destroy(made));
        self.wait();
        ok(destroy(made));
        told
    }
}

fn in_buffer(buffer: vk::Buffer) -> GeosweepPoints {
    GeosweepPoints { data: std::ptr::null(), buffer, ..height_points(&[]) }
}

/// A mistake and how it is reported.
struct Mistake {
    name: &'static str,
    /// Whether the surface was prepared and measured before.
    is_ready: bool,
    make: fn(&Scene) -> String,
    /// Words of the report.
    told: &'static str,
}

/// Returns the message of a call that must be refused.
fn said(status: GeosweepStatus) -> String {
    assert_ne!(status, GeosweepStatus::Success);
    last_error()
}

fn levels() -> GeosweepContourFrame {
    GeosweepContourFrame { level_count: 3, step: 5.0, ..zero() }
}

const MISTAKES: [Mistake; 14] = [
    Mistake {
        name: "an access whose stage was cut off",
        is_ready: true,
        make: |scene| {
            let access = vk::AccessFlags::TRANSFER_WRITE;
            let before = GeosweepAccess { stages: vk::PipelineStageFlags::empty(), access };
            let frame = GeosweepFrame { before, ..scene.frame() };
            let mut told = String::new();
            scene.record(false, |commands| unsafe {
                told = said(geosweep_record_frame(scene.surface, commands, &frame, null_mut()));
                said(geosweep_record_end(scene.surface, commands, before));
                said(geosweep_record_begin(scene.surface, commands, before));
                let layout = vk::ImageLayout::GENERAL;
                let reader = GeosweepReader { access: before, layout };
                let frame = GeosweepFrame { reader, ..scene.frame() };
                let refused = geosweep_record_frame(scene.surface, commands, &frame, null_mut());
                assert!(said(refused).contains("frame->reader.access.stages is 0"));
            });
            told
        },
        told: "frame->before.stages is 0, and the access beside it is 0x1000",
    },
    Mistake {
        name: "an instance for Vulkan 1.0",
        is_ready: false,
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
        is_ready: true,
        make: |scene| {
            let surfaces = [scene.surface.cast_const(); 2];
            let frames = [scene.frame(), GeosweepFrame { slot: 1, ..scene.frame() }];
            let mut told = String::new();
            scene.record(false, |commands| unsafe {
                let (surfaces, frames) = (surfaces.as_ptr(), frames.as_ptr());
                told = said(geosweep_record_frames(surfaces, frames, 2, commands, null_mut()));
            });
            told
        },
        told: "frames[1]: its surface has another frame among them",
    },
    Mistake {
        name: "a part of the ring that nobody has written",
        is_ready: true,
        make: |scene| {
            // Heights of zero form a plane. Positions of zero coincide.
            let kind = GeosweepPointKind::Positions as i32;
            let points = [GeosweepPoints { kind, buffer: scene.ring, stride: 12, ..zero() }];
            let (session, rows) = (scene.session, ROWS / 3);
            let surface = session.surface(&surface_info(rows, COLS, &points));
            let plan = session.plan(rows, COLS, &method(GeosweepWavefront::Curved, 12));
            let points_offset = 4 * POINTS as u64;
            session.host.run(|commands| unsafe {
                let frame = GeosweepFrame { plan, points_offset, ..scene.frame() };
                ok(geosweep_record_frame(surface, commands, &frame, null_mut()));
            });
            let without_length = session.outcome(surface).edges_without_length;
            destroy!(geosweep_surface_destroy(surface), geosweep_plan_destroy(plan));
            format!("edges without length: {}", without_length > 0)
        },
        told: "edges without length: true",
    },
    Mistake {
        name: "a part beyond the buffer",
        is_ready: true,
        make: |scene| {
            let frame = GeosweepFrame { points_offset: 1 << 40, ..scene.frame() };
            let mut told = String::new();
            scene.record(false, |commands| unsafe {
                told = said(geosweep_record_frame(scene.surface, commands, &frame, null_mut()));
            });
            told
        },
        told: "is beyond the",
    },
    Mistake {
        name: "points replaced more often than there are slots",
        is_ready: true,
        make: |scene| {
            let points = in_buffer(scene.ring);
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
            told
        },
        told: "points 0 are replaced again while recordings that read them have not run",
    },
    Mistake {
        name: "contours lifted to points that were replaced",
        is_ready: true,
        make: |scene| {
            let mut contours = null_mut();
            ok(unsafe { geosweep_contours_create(scene.surface, 1000, &mut contours) });
            let points = in_buffer(scene.ring);
            ok(unsafe { geosweep_surface_set_points(scene.surface, 0, &points) });
            let mut told = String::new();
            scene.record(false, |commands| unsafe {
                let surface = scene.surface;
                let record =
                    || geosweep_record_contours(surface, commands, contours, &levels(), null_mut());
                told = said(record());
                ok(geosweep_contours_rebind(contours, surface));
                ok(record());
                ok(geosweep_surface_discard_commands(surface, commands));
            });
            destroy!(geosweep_contours_destroy(contours));
            told
        },
        told: "geosweep_contours_rebind",
    },
    Mistake {
        name: "a preparation that is lost",
        is_ready: false,
        make: |scene| {
            scene.record(false, |commands| unsafe {
                ok(geosweep_record_prepare(scene.surface, commands));
            });
            let frame = scene.frame();
            scene.session.host.run(|commands| unsafe {
                ok(geosweep_record_frame(scene.surface, commands, &frame, null_mut()));
            });
            said(unsafe { geosweep_surface_outcome(scene.surface, 0, &mut zero()) })
        },
        told: "preparation was recorded and has not run",
    },
    Mistake {
        name: "contours destroyed in flight",
        is_ready: true,
        make: |scene| {
            let mut made = null_mut();
            ok(unsafe { geosweep_contours_create(scene.surface, 1000, &mut made) });
            let (surface, of) = (scene.surface, levels());
            let record = |commands| unsafe {
                geosweep_record_contours(surface, commands, made, &of, null_mut())
            };
            scene.destroyed(made, record, |made| unsafe { geosweep_contours_destroy(made) })
        },
        told: "contours is destroyed and a recording of it has not run",
    },
    Mistake {
        name: "paths destroyed in flight",
        is_ready: true,
        make: |scene| {
            let mut made = null_mut();
            ok(unsafe { geosweep_paths_create(scene.surface, 1, 500, &mut made) });
            let (starts, sources) = ([20.0, 30.0], scene.frame().sources);
            let (starts, start_count) = (starts.as_ptr(), 1);
            let of = GeosweepPathFrame { starts, start_count, sources, ..zero() };
            let record = |commands| unsafe {
                geosweep_record_paths(scene.surface, commands, made, &of, null_mut())
            };
            scene.destroyed(made, record, |made| unsafe { geosweep_paths_destroy(made) })
        },
        told: "paths is destroyed and a recording of it has not run",
    },
    Mistake {
        name: "regions destroyed in flight",
        is_ready: true,
        make: |scene| {
            let mut made = null_mut();
            let curved = GeosweepWavefront::Curved as i32;
            ok(unsafe { geosweep_regions_create(scene.surface, curved, &mut made) });
            let of = GeosweepRegionFrame { sources: scene.frame().sources, ..zero() };
            let record = |commands| unsafe {
                geosweep_record_regions(scene.surface, commands, made, &of, null_mut())
            };
            scene.destroyed(made, record, |made| unsafe { geosweep_regions_destroy(made) })
        },
        told: "regions is destroyed and a recording of it has not run",
    },
    Mistake {
        name: "a surface recorded without an outcome, destroyed in flight",
        is_ready: true,
        make: |scene| {
            scene.solve(|_| {});
            said(unsafe { geosweep_surface_destroy(scene.surface) })
        },
        told: "surface is destroyed and a recording of it has not run",
    },
    Mistake {
        name: "points written in flight",
        is_ready: true,
        make: |scene| {
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
            told
        },
        told: "number is 1, and a recording that reads these points has not run",
    },
    Mistake {
        name: "an outcome of another surface",
        is_ready: true,
        make: |scene| {
            let bytes = [0u8; GEOSWEEP_OUTCOME_BYTES as usize];
            said(unsafe { geosweep_outcome_from_bytes(scene.surface, bytes.as_ptr(), &mut zero()) })
        },
        told: "preparation was recorded and has not run",
    },
];

#[test]
fn mistakes_are_reported_and_the_renderer_goes_on() {
    let heights: Vec<f32> = (0..POINTS).map(|index| (0.1 * index as f32).sin()).collect();
    for layers in [true, false] {
        let mut host = match layers {
            true => Host::with_synchronization_validation(),
            false => Host::without_validation(),
        };
        let ring = host.buffer_of(&[&heights[..], &[0.0; POINTS]].concat());
        let session = Session::with_checks(host);
        for Mistake { name, is_ready, make, told } in &MISTAKES {
            let scene = Scene::new(&session, &ring, &heights, *is_ready);
            let said = make(&scene);
            assert!(said.contains(told), "{name}, layers {layers}: {said}");
            scene.wait();
            destroy!(geosweep_surface_destroy(scene.surface), geosweep_plan_destroy(scene.plan));
        }
        // The mistakes themselves may be messages of the layers.
        ok(unsafe { geosweep_solver_destroy(session.solver) });
        let mut host = session.host;
        host.free(ring);
        assert_eq!(host.allocations(), 0);
    }
}
