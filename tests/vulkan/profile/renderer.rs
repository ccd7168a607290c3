//! A host with one surface and a profile.

use geosweep::Stop;
use geosweep::Wavefront;
use geosweep::ash::vk;
use geosweep::surface::Chart;
use geosweep::vulkan::embed::{
    self, Frame, Plan, PointKind, PointSource, Points, Reader, SourceInput, SurfaceInfo, Tools,
};
use geosweep::vulkan::profile::{Clock, Decided, Grain, PassRecord, Profile, QueryRange, Slots};
use geosweep::vulkan::{Method, Schedule};

use crate::common::{Lent, Pool};
use crate::host::{Host, HostBuffer};

pub const CHART: Chart = Chart { rows: 260, cols: 300 };
pub const STOP: Stop = Stop::within(1e-6).or_after(200);

/// A renderer with one surface and the resources of its profile.
pub struct Renderer {
    pub host: Host,
    pub solver: embed::Solver,
    pub surface: embed::FrameSurface,
    pub plan: Plan,
    pub points: HostBuffer,
    pub decisions: HostBuffer,
    /// Two queries of the host, followed by those of the profile.
    pub pool: vk::QueryPool,
    pub slots: Slots,
    pub profile: Profile,
    pub clock: Clock,
}

static WATCHED: [Pool<Renderer>; Schedule::ALL.len()] =
    [const { Pool::new() }; Schedule::ALL.len()];
static UNWATCHED: [Pool<Renderer>; Schedule::ALL.len()] =
    [const { Pool::new() }; Schedule::ALL.len()];

impl Renderer {
    /// Lends a renderer with planar fronts under the validation layers, with labels and names.
    pub fn watched(schedule: Schedule) -> Lent<Self> {
        let tools = Tools { labels: true, ..Tools::default() };
        let open = || Self::new(Host::new(), schedule, Wavefront::Planar, tools);
        Self::lend(&WATCHED[schedule as usize], open)
    }

    /// Lends a renderer with planar fronts without layers and labels.
    pub fn unwatched(schedule: Schedule) -> Lent<Self> {
        let host = Host::without_validation;
        let open = || Self::new(host(), schedule, Wavefront::Planar, Tools::default());
        Self::lend(&UNWATCHED[schedule as usize], open)
    }

    fn lend(pool: &'static Pool<Self>, open: impl FnOnce() -> Self) -> Lent<Self> {
        let mut renderer = pool.lend(open, |renderer| {
            assert_eq!(renderer.host.messages(), Vec::<String>::new());
        });
        // Each test begins with the profile of all passes of a frame.
        let Self { solver, surface, plan, slots, .. } = &*renderer;
        let count = solver.passes_of_frame(surface, plan, Grain::Blocks);
        renderer.profile = Profile::new(count, Grain::Blocks, *slots);
        renderer
    }

    pub fn new(mut host: Host, schedule: Schedule, wavefront: Wavefront, tools: Tools) -> Self {
        let device = host.device.clone();
        let heights: Vec<f32> = (0..CHART.points())
            .map(|i| ((i % 37) as f32 * 0.1).sin() + (i / 3000) as f32)
            .collect();
        let points = host.buffer_of(&heights);
        let passes = [(schedule, wavefront)];
        let (instance, physical_device) = (&host.instance, host.physical_device);
        let solver =
            embed::Solver::with_tools(instance, physical_device, &device, &passes, tools).unwrap();
        let kind = PointKind::Heights(geosweep::Spacing::square(1.0));
        let inputs = [Points { kind, ..Points::positions(points.handle, 4) }];
        let info = SurfaceInfo::new(CHART).with_points(&inputs);
        let surface = solver.surface(&device, host.allocator(), &info).unwrap();
        let method = Method::new(wavefront, STOP);
        let plan = solver.plan(CHART, method, 6).unwrap();
        let grain = Grain::Blocks;
        let count = solver.passes_of_frame(&surface, &plan, grain);
        let info = vk::QueryPoolCreateInfo::default()
            .query_type(vk::QueryType::TIMESTAMP)
            .query_count(2 + count + 1);
        let pool = unsafe { device.create_query_pool(&info, None) }.unwrap();
        let decisions = host.buffer(Slots::DECISION_BYTES, true);
        let timestamps = QueryRange { pool, first: 2, count: count + 1 };
        let decided = Decided { buffer: decisions.handle, offset: 0, portions: 1 };
        let slots = Slots::default().with_timestamps(timestamps).with_decisions(decided);
        let profile = Profile::new(count, grain, slots);
        let family = crate::host::family(&host.instance, host.physical_device);
        let clock = Clock::of(&host.instance, host.physical_device, family).unwrap();
        host.run(|commands| solver.record(&device, commands, &surface).prepare());
        Self { host, solver, surface, plan, points, decisions, pool, slots, profile, clock }
    }

    /// Returns a profile with the grain of iterations, and its own queries. It has room for `more` passes
    /// beyond those of a frame.
    pub fn profile_with(&self, more: u32) -> (Profile, vk::QueryPool) {
        let grain = Grain::Iterations;
        let passes = self.solver.passes_of_frame(&self.surface, &self.plan, grain) + more;
        let info = vk::QueryPoolCreateInfo::default()
            .query_type(vk::QueryType::TIMESTAMP)
            .query_count(passes + 1);
        let pool = unsafe { self.host.device.create_query_pool(&info, None) }.unwrap();
        let range = QueryRange { pool, first: 0, count: passes + 1 };
        (Profile::new(passes, grain, Slots::default().with_timestamps(range)), pool)
    }

    pub fn frame(
        &self,
        device: &geosweep::ash::Device,
        commands: vk::CommandBuffer,
        watched: bool,
    ) {
        let recording = self.solver.record(device, commands, &self.surface);
        let recording =
            if watched { recording.profiled(&self.profile).unwrap() } else { recording };
        recording
            .frame(
                &Frame::new(
                    &self.plan,
                    SourceInput::Inline(&[PointSource::at(20.0, 31.5)]),
                    Reader::COPY,
                )
                .with_points(0),
            )
            .unwrap();
    }

    /// Runs a frame between two timestamps of the host. Returns the nanoseconds between them, and the records of the
    /// passes.
    pub fn timed_frame(&self) -> (u64, Vec<PassRecord>) {
        let device = &self.host.device;
        let stage = vk::PipelineStageFlags::BOTTOM_OF_PIPE;
        self.host.run(|commands| unsafe {
            device.cmd_reset_query_pool(commands, self.pool, 0, 2);
            device.cmd_write_timestamp(commands, stage, self.pool, 0);
            self.frame(device, commands, true);
            device.cmd_write_timestamp(commands, stage, self.pool, 1);
        });
        let mut own = [0u64; 2];
        let flags = vk::QueryResultFlags::TYPE_64;
        unsafe { device.get_query_pool_results(self.pool, 0, &mut own, flags) }.unwrap();
        let bytes = self.decisions.bytes();
        let resolved =
            self.profile.resolve(device, Some(self.clock), Some(bytes)).unwrap().unwrap();
        assert_eq!(resolved.left_out, 0);
        (self.clock.nanoseconds(own[0], own[1]), resolved.passes)
    }
}

impl Drop for Renderer {
    fn drop(&mut self) {
        let Self { host, solver, surface, points, decisions, pool, .. } = self;
        let device = host.device.clone();
        unsafe { device.destroy_query_pool(*pool, None) };
        surface.destroy(&device, host.allocator());
        solver.destroy(&device);
        points.destroy(host);
        decisions.destroy(host);
    }
}
