//! What a profile says of passes, against counts and clocks of the tests' own.

mod common;
#[path = "embed/host/mod.rs"]
mod host;

use std::sync::atomic::{AtomicU32, Ordering};

use common::{CONVERGED, rough, seeds_at, some_point};
use geosweep::ash::vk;
use geosweep::cpu::Stop;
use geosweep::surface::{Chart, Seed};
use geosweep::vulkan::embed::{
    self, Access, Frame, Plan, PointKind, PointSource, Points, Reader, SourceInput, SurfaceInfo,
    Tools,
};
use geosweep::vulkan::plan::{self, Portions, Reached, Scan, Step};
use geosweep::vulkan::profile::{
    Capabilities, Capability, Clock, Decided, Detail, Grain, PassKind, PassRecord, Profile,
    QueryRange, Slots, SolveProfile,
};
use geosweep::vulkan::{Method, Schedule, Solver, SurfaceOnDevice, TexelChart};
use geosweep::{DeviceChoice, Surface, Wavefront};
use host::{Host, HostBuffer};

fn choice() -> DeviceChoice {
    DeviceChoice::Name(std::env::var("GEOSWEEP_TEST_DEVICE").unwrap_or_default())
}

fn method(wavefront: Wavefront, schedule: Schedule) -> Method {
    Method { wavefront, schedule: Some(schedule), stop: CONVERGED }
}

/// A surface on a device that is profiled.
struct Bench {
    surface: Surface,
    seeds: Vec<Seed>,
    solver: Solver,
    on_device: SurfaceOnDevice,
}

impl Bench {
    fn new(rows: usize, cols: usize, left_out: &[Capability]) -> Self {
        let surface = rough(rows, cols, 0);
        let seeds = seeds_at(&surface, some_point(&surface));
        let solver = Solver::for_profiling(&choice(), left_out).unwrap();
        let on_device = solver.upload(&surface).unwrap();
        Self { surface, seeds, solver, on_device }
    }

    fn profile(&mut self, method: Method, detail: Detail) -> SolveProfile {
        let Self { seeds, solver, on_device, .. } = self;
        solver.profile(on_device, seeds, method, detail).unwrap().1
    }

    /// The steps as they are recorded, portion by portion, and the texels.
    fn steps(&self, schedule: Schedule, portions: usize) -> (TexelChart, Vec<Vec<Step>>) {
        let texels = TexelChart::new(self.surface.chart()).unwrap();
        let tuning = self.solver.tuning();
        let sizes = Portions { lines: tuning.scan_lines, tile: tuning.tile };
        let places = self.seeds.iter().map(|seed| TexelChart::texel_of(seed.row, seed.col));
        let mut reached = Reached::around(places.map(|(row, col, _)| (row, col)));
        let steps = (0..portions)
            .map(|_| plan::recording(schedule, texels, sizes, reached.take(), u32::MAX))
            .collect();
        (texels, steps)
    }
}

fn of_kind(profile: &SolveProfile, kind: PassKind) -> impl Iterator<Item = &PassRecord> {
    profile.passes().filter(move |pass| pass.kind == kind)
}

fn sum(passes: &[&PassRecord], of: impl Fn(&PassRecord) -> Option<u64>) -> u64 {
    passes.iter().map(|pass| of(pass).unwrap_or_else(|| panic!("{pass:?}"))).sum()
}

/// Marks the texels of every block of the plan in a grid of booleans, and holds the records of the
/// device's passes against the marks, scan by scan.
#[test]
fn texels_visited_and_skipped_are_those_of_the_plan() {
    let sizes = [(61, 90), (90, 61), (3, 200)];
    for ((rows, cols), grain) in
        sizes.into_iter().flat_map(|size| [(size, Grain::Blocks), (size, Grain::Scans)])
    {
        let mut bench = Bench::new(rows, cols, &[]);
        let detail = Detail { grain, ..Detail::default() };
        let profile = bench.profile(method(Wavefront::Planar, Schedule::Raster), detail);
        // Four iterations a recording.
        let recordings = of_kind(&profile, PassKind::Count).count() / 4;
        let (texels, portions) = bench.steps(Schedule::Raster, recordings);
        let (height, width) = (texels.inner_rows().len(), texels.inner_cols().len());
        let visits = profile.passes().filter(|pass| pass.area.is_some() && !pass.is_idle());
        let done = visits.filter_map(|pass| pass.iteration).max().unwrap() + 1;
        let mut skipped_by_bounds = 0;
        let mut iteration = 0;
        for step_list in portions {
            // Nothing follows the last count but its barrier.
            let iterations = step_list.split(|step| *step == Step::Count);
            for steps in iterations.filter(|steps| steps.len() > 1) {
                for scan in Scan::ALL {
                    let mut marks = vec![false; height * width];
                    let mut blocks = 0;
                    for pass in steps.iter().filter_map(|step| match step {
                        Step::Scan(pass) if pass.scan == scan => Some(pass),
                        _ => None,
                    }) {
                        blocks += 1;
                        for k in 0..pass.lines as i32 {
                            let (dx, dy) = scan.ahead();
                            let line = (pass.line as i32 + k * (dx + dy)) as usize - 1;
                            for along in pass.texels.clone() {
                                let along = along as usize - 1;
                                let (row, col) =
                                    if dy != 0 { (line, along) } else { (along, line) };
                                assert!(!marks[row * width + col], "visited twice: {pass:?}");
                                marks[row * width + col] = true;
                            }
                        }
                    }
                    let marked = marks.iter().filter(|&&mark| mark).count() as u64;
                    let visited = if iteration < done { marked } else { 0 };
                    let of_scan: Vec<_> = of_kind(&profile, PassKind::Scan(scan))
                        .filter(|pass| pass.iteration == Some(iteration))
                        .collect();
                    let records = if grain == Grain::Blocks { blocks } else { 1 };
                    assert_eq!(of_scan.len(), records, "{scan:?} of {iteration}");
                    let dispatches: u32 = of_scan.iter().map(|pass| pass.dispatches).sum();
                    assert_eq!(dispatches as usize, blocks);
                    assert_eq!(sum(&of_scan, |pass| pass.work.texels), visited);
                    let all = (height * width) as u64;
                    assert_eq!(sum(&of_scan, |pass| pass.work.skipped), all - visited);
                    skipped_by_bounds += all - marked;
                }
                iteration += 1;
            }
        }
        assert!(skipped_by_bounds > 0, "the source is in the middle");
    }
}

/// Seven by four points are four by two texels. Planar: 16 bytes of arrival times read and as many
/// written for each texel, and four points' four edge lengths of 4 bytes. Curved: as many again for
/// the fronts' curvature, and 16 for the surface's. Two triangles a point.
#[test]
fn bytes_agree_with_a_count_by_hand() {
    let mut bench = Bench::new(7, 4, &[]);
    for (wavefront, read, written) in
        [(Wavefront::Planar, 16 + 64, 16), (Wavefront::Curved, 32 + 64 + 16, 32)]
    {
        let profile = bench.profile(method(wavefront, Schedule::Raster), Detail::default());
        // The second iteration visits all of the grid.
        let second: Vec<_> = profile
            .passes()
            .filter(|pass| pass.iteration == Some(1) && matches!(pass.kind, PassKind::Scan(_)))
            .collect();
        assert_eq!(sum(&second, |pass| pass.work.texels), 4 * 8);
        assert_eq!(sum(&second, |pass| pass.work.bytes_read), 4 * 8 * read);
        assert_eq!(sum(&second, |pass| pass.work.bytes_written), 4 * 8 * written);
        assert_eq!(sum(&second, |pass| pass.work.triangles), 4 * 8 * 4 * 2);
        let all_points = bench.profile(method(wavefront, Schedule::AllPoints), Detail::default());
        let first = of_kind(&all_points, PassKind::AllPoints).next().unwrap();
        assert_eq!(first.work.bytes(), Some(8 * (read + written)));
        assert_eq!(first.work.triangles, Some(8 * 4 * 8));
        let unpack = of_kind(&profile, PassKind::Unpack).next().unwrap();
        assert_eq!((unpack.work.bytes_read, unpack.work.bytes_written), (Some(112), Some(112)));
    }
}

/// The device's own count of invocations says how many groups have run, whatever was planned.
#[test]
fn the_device_counts_the_invocations_of_the_groups_in_the_records() {
    let mut bench = Bench::new(70, 131, &[]);
    let tuning = bench.solver.tuning();
    let detail = Detail { grain: Grain::Blocks, invocations: true, tiles: true };
    for (schedule, group) in [
        (Schedule::Raster, tuning.scan_width),
        (Schedule::AllPoints, 64),
        (Schedule::Tiles, tuning.tile / 2 * 4),
    ] {
        let profile = bench.profile(method(Wavefront::PointSource, schedule), detail);
        let mut counted = 0;
        for pass in profile.passes() {
            let is_pass =
                matches!(pass.kind, PassKind::Scan(_) | PassKind::AllPoints | PassKind::Tiles);
            if is_pass {
                let groups: u32 = pass.groups.unwrap().iter().product();
                assert_eq!(pass.invocations, Some(u64::from(groups * group)), "{pass:?}");
                counted += usize::from(groups > 0);
            }
        }
        assert!(counted > 4, "{schedule}");
    }
}

/// The lists of tiles hold as many tiles as the records, each once, and the first are those around
/// the source.
#[test]
fn tiles_are_listed_as_they_were_visited() {
    let mut bench = Bench::new(100, 131, &[]);
    let detail = Detail { tiles: true, ..Detail::default() };
    let profile = bench.profile(method(Wavefront::Curved, Schedule::Tiles), detail);
    let tile = bench.solver.tuning().tile as usize;
    let across = 131usize.div_ceil(tile);
    let tiles = 100usize.div_ceil(tile) * across;
    let lists: Vec<_> = profile.submissions.iter().flat_map(|found| &found.tiles).collect();
    let rounds: Vec<_> = of_kind(&profile, PassKind::Tiles).collect();
    assert_eq!(lists.len(), rounds.len());
    let mut seen = vec![false; tiles];
    for (list, round) in lists.iter().zip(&rounds) {
        assert_eq!(round.groups, Some([list.len() as u32, 1, 1]));
        let texels = (tile * tile / 4 * list.len()) as u64;
        assert_eq!(round.work.texels, Some(texels));
        assert_eq!(round.work.skipped, Some((tile * tile / 4 * tiles) as u64 - texels));
        let mut sorted = (*list).clone();
        sorted.sort_unstable();
        sorted.dedup();
        assert_eq!(sorted.len(), list.len());
        sorted.iter().for_each(|&number| seen[number as usize] = true);
    }
    assert!(seen.iter().all(|&seen| seen), "every tile is visited once at least");
    let (row, col) = some_point(&bench.surface);
    assert!(lists[0].contains(&((row / tile * across + col / tile) as u32)));
}

/// Whatever is looked at, and whatever the device lacks, the map is the same to the last bit; and
/// what is lacking is said.
#[test]
fn a_device_that_lacks_something_still_gives_the_rest() {
    let all = Capability::ALL;
    let singles = all.map(|one| vec![one]);
    for left_out in [vec![], all.to_vec()].into_iter().chain(singles) {
        let mut bench = Bench::new(40, 33, &left_out);
        let found = bench.solver.capabilities().unwrap().clone();
        for capability in all {
            let reason = found.reason(capability);
            if left_out.contains(&capability) {
                let text = reason.unwrap().to_string();
                assert_eq!(text, "not available on this device (left out as asked)");
            } else if let Some(reason) = reason {
                assert!(reason.to_string().starts_with("not available on this device ("));
            }
        }
        for schedule in Schedule::ALL {
            let method = method(Wavefront::Curved, schedule);
            let Bench { seeds, solver, on_device, .. } = &mut bench;
            let plain = solver.solve(on_device, seeds, method).unwrap();
            let detail = Detail { grain: Grain::Blocks, invocations: true, tiles: true };
            let (watched, profile) = solver.profile(on_device, seeds, method, detail).unwrap();
            assert_eq!(watched.distances, plain.distances);
            assert_eq!((watched.iterations, watched.residual), (plain.iterations, plain.residual));
            for pass in profile.passes() {
                assert_eq!(pass.nanoseconds.is_some(), found.timestamps.is_ok(), "{pass:?}");
                assert_eq!(pass.begin.is_some(), found.timestamps.is_ok());
                assert_eq!(pass.invocations.is_some(), found.statistics.is_ok());
            }
            // What is counted needs no capability.
            let in_iterations: Vec<_> = profile.passes().filter(|p| p.area.is_some()).collect();
            assert!(in_iterations.len() > 2);
            assert!(in_iterations.iter().all(|pass| pass.work.texels.is_some()));
            let aligned = found.calibration.is_ok() && found.timestamps.is_ok();
            for submission in &profile.submissions {
                assert_eq!(submission.nanoseconds.is_some(), found.timestamps.is_ok());
                assert_eq!(submission.begin.is_some(), aligned);
                assert!(submission.submitted <= submission.ended);
            }
        }
        let executables = bench.solver.executables().unwrap();
        assert_eq!(!executables.is_empty(), found.executables.is_ok());
    }
}

/// The device begins with a submission after the host has submitted it and ends before the host
/// knows: on one clock, which calibrated timestamps make of two.
#[test]
fn calibrated_times_lie_between_submission_and_its_end() {
    let mut bench = Bench::new(80, 80, &[]);
    let profile = bench.profile(method(Wavefront::Planar, Schedule::Raster), Detail::default());
    if bench.solver.capabilities().unwrap().calibration.is_err() {
        assert!(profile.submissions.iter().all(|found| found.begin.is_none()));
        return;
    }
    // Of the reading of both clocks; a host that is interrupted in all tries reads worse.
    let slack = 2e6;
    for found in &profile.submissions {
        let (begin, taken) = (found.begin.unwrap(), found.nanoseconds.unwrap() as f64);
        assert!(begin > found.submitted.as_nanos() as f64 - slack, "{found:?}");
        assert!(begin + taken < found.ended.as_nanos() as f64 + slack, "{found:?}");
    }
}

#[test]
fn passes_follow_one_another_inside_their_submission() {
    let mut bench = Bench::new(50, 50, &[]);
    for schedule in Schedule::ALL {
        let profile = bench.profile(method(Wavefront::Planar, schedule), Detail::default());
        for submission in &profile.submissions {
            let mut end = 0;
            for pass in &submission.passes {
                assert_eq!(pass.begin, Some(end));
                end += pass.nanoseconds.unwrap();
            }
            assert!(submission.lead.unwrap() + end <= submission.nanoseconds.unwrap());
        }
        assert!(profile.pass_nanoseconds().unwrap() <= profile.nanoseconds().unwrap());
    }
}

const CHART: Chart = Chart { rows: 260, cols: 300 };
const STOP: Stop = Stop { tolerance: 1e-6, iterations: 200 };

/// A renderer with one surface, and what its profile needs.
struct Renderer {
    host: Host,
    solver: embed::Solver,
    surface: embed::Surface,
    plan: Plan,
    points: HostBuffer,
    decisions: HostBuffer,
    /// Two queries of the host's own and then those of the profile.
    pool: vk::QueryPool,
    profile: Profile,
    clock: Clock,
}

impl Renderer {
    fn new(mut host: Host, schedule: Schedule, tools: Tools) -> Self {
        let device = host.device.clone();
        let heights: Vec<f32> = (0..CHART.points())
            .map(|i| ((i % 37) as f32 * 0.1).sin() + (i / 3000) as f32)
            .collect();
        let points = host.buffer_of(&heights);
        let passes = [(schedule, Wavefront::Planar)];
        let (instance, physical_device) = (&host.instance, host.physical_device);
        let solver =
            embed::Solver::with_tools(instance, physical_device, &device, &passes, tools).unwrap();
        let kind = PointKind::Heights(geosweep::Spacing::square(1.0));
        let inputs = [Points { kind, ..Points::positions(points.handle, 4) }];
        let info = SurfaceInfo { points: &inputs, ..SurfaceInfo::new(CHART) };
        let surface = solver.surface(&device, host.allocator(), &info).unwrap();
        let method = Method { wavefront: Wavefront::Planar, schedule: None, stop: STOP };
        let plan = solver.plan(CHART, method, 6).unwrap();
        let grain = Grain::Blocks;
        let count = solver.passes_of_frame(&surface, &plan, grain);
        let info = vk::QueryPoolCreateInfo::default()
            .query_type(vk::QueryType::TIMESTAMP)
            .query_count(2 + count + 1);
        let pool = unsafe { device.create_query_pool(&info, None) }.unwrap();
        let decisions = host.buffer(Slots::DECISION_BYTES, true);
        let timestamps = Some(QueryRange { pool, first: 2, count: count + 1 });
        let decided = Decided { buffer: decisions.handle, offset: 0, portions: 1 };
        let slots = Slots { timestamps, decisions: Some(decided), ..Slots::default() };
        let profile = Profile::new(count, grain, slots);
        let family = host::family(&host.instance, host.physical_device);
        let clock = Clock::of(&host.instance, host.physical_device, family).unwrap();
        host.run(|commands| solver.record(&device, commands, &surface).prepare());
        Self { host, solver, surface, plan, points, decisions, pool, profile, clock }
    }

    fn frame(&self, device: &geosweep::ash::Device, commands: vk::CommandBuffer, watched: bool) {
        let recording = self.solver.record(device, commands, &self.surface);
        let recording = if watched { recording.profiled(&self.profile) } else { recording };
        recording
            .frame(&Frame {
                before: Access::NONE,
                points: Some(0),
                sources: SourceInput::Inline(&[PointSource::at(20.0, 31.5)]),
                plan: &self.plan,
                slot: 0,
                reader: Reader::COPY,
                unreached: f32::INFINITY,
            })
            .unwrap();
    }

    /// A frame between two timestamps of the host's own: the time between them, and the records.
    fn timed_frame(&self) -> (u64, Vec<PassRecord>) {
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

    fn end(self) -> Vec<String> {
        let Self { mut host, mut solver, mut surface, points, decisions, pool, .. } = self;
        let device = host.device.clone();
        unsafe { device.destroy_query_pool(pool, None) };
        surface.destroy(&device, host.allocator());
        solver.destroy(&device);
        host.free(points);
        host.free(decisions);
        host.messages()
    }
}

/// The host's own timestamps around a frame are the total. What lies between its passes, such as
/// the reset of queries, is in no pass; an interruption of the driver's thread there can only
/// happen in some of the tries.
#[test]
fn the_passes_of_a_frame_add_up_to_its_total() {
    let renderer = Renderer::new(Host::without_validation(), Schedule::Raster, Tools::default());
    let shares: Vec<f64> = (0..5)
        .map(|_| {
            let (total, passes) = renderer.timed_frame();
            let of_passes: u64 = passes.iter().map(|pass| pass.nanoseconds.unwrap()).sum();
            assert!(of_passes <= total, "{of_passes} of {total}");
            of_passes as f64 / total as f64
        })
        .collect();
    let best = shares.iter().copied().fold(0.0, f64::max);
    assert!(best > 0.9, "{shares:?}");
    renderer.end();
}

/// Under the validation layers, with synchronization validation; labels and names included.
#[test]
fn a_frame_is_taken_down_pass_by_pass() {
    for schedule in Schedule::ALL {
        let tools = Tools { labels: true, executables: false };
        let renderer = Renderer::new(Host::new(), schedule, tools);
        for _ in 0..2 {
            let (_, passes) = renderer.timed_frame();
            let outcome = renderer.surface.outcome(0).unwrap();
            let kinds: Vec<_> = passes.iter().map(|pass| pass.kind).collect();
            assert_eq!(kinds[..2], [PassKind::Points, PassKind::Edges]);
            assert_eq!(kinds[kinds.len() - 2..], [PassKind::Outcome, PassKind::Distances]);
            let most =
                renderer.solver.passes_of_frame(&renderer.surface, &renderer.plan, Grain::Blocks);
            assert!(kinds.len() as u32 <= most);
            // Each iteration that the device has done is there, and no other.
            let done = passes
                .iter()
                .filter(|pass| pass.area.is_some() && !pass.is_idle())
                .filter_map(|pass| pass.iteration)
                .max();
            assert_eq!(done, Some(outcome.iterations - 1), "{schedule}");
        }
        assert_eq!(renderer.end(), Vec::<String>::new(), "{schedule}");
    }
}

/// Without what the device has decided, nothing is made up.
#[test]
fn what_is_not_read_back_is_not_known() {
    for schedule in Schedule::ALL {
        let renderer = Renderer::new(Host::without_validation(), schedule, Tools::default());
        renderer.timed_frame();
        let device = &renderer.host.device;
        let resolved = renderer.profile.resolve(device, None, None).unwrap().unwrap();
        for pass in &resolved.passes {
            assert_eq!((pass.begin, pass.nanoseconds, pass.invocations), (None, None, None));
            // All iterations of a frame's plan are dispatched indirectly.
            if pass.area.is_some() {
                assert_eq!((pass.groups, pass.work.texels, pass.work.bytes()), (None, None, None));
                assert!(!pass.is_idle());
            }
        }
        renderer.end();
    }
}

/// Recording does not wait for the device, and neither does asking too early.
#[test]
fn results_that_are_not_there_are_not_waited_for() {
    let renderer = Renderer::new(Host::without_validation(), Schedule::Raster, Tools::default());
    let host = &renderer.host;
    // The queries are reset and not written.
    host.run(|commands| unsafe {
        host.device.cmd_reset_query_pool(commands, renderer.pool, 0, 3);
    });
    let commands = host.commands();
    host.begin(commands);
    renderer.frame(&host.device, commands, true);
    host.end(commands);
    let early = renderer.profile.resolve(&host.device, Some(renderer.clock), None).unwrap();
    assert_eq!(early, None);
    host.submit(commands, vk::Fence::null());
    unsafe { host.device.queue_wait_idle(host.queue) }.unwrap();
    let late = renderer.profile.resolve(&host.device, Some(renderer.clock), None).unwrap();
    assert!(late.unwrap().passes.iter().all(|pass| pass.nanoseconds.is_some()));
    renderer.end();
}

/// A profile that is too small leaves passes out and says how many.
#[test]
fn passes_without_room_are_counted() {
    let mut renderer = Renderer::new(Host::new(), Schedule::Raster, Tools::default());
    let all = renderer.timed_frame().1.len() as u32;
    let timestamps = Some(QueryRange { pool: renderer.pool, first: 2, count: 11 });
    renderer.profile = Profile::new(100, Grain::Blocks, Slots { timestamps, ..Slots::default() });
    let device = &renderer.host.device;
    renderer.host.run(|commands| renderer.frame(device, commands, true));
    let found = renderer.profile.resolve(device, Some(renderer.clock), None).unwrap().unwrap();
    // Without a buffer for decisions the two copies of them are not recorded.
    assert_eq!((found.passes.len(), found.left_out), (10, all - 2 - 10));
    // An empty range is none.
    let timestamps = Some(QueryRange { pool: renderer.pool, first: 2, count: 0 });
    renderer.profile = Profile::new(all, Grain::Blocks, Slots { timestamps, ..Slots::default() });
    renderer.host.run(|commands| renderer.frame(device, commands, true));
    let found = renderer.profile.resolve(device, Some(renderer.clock), None).unwrap().unwrap();
    assert_eq!((found.passes.len(), found.left_out), (all as usize - 2, 0));
    assert!(found.passes.iter().all(|pass| pass.nanoseconds.is_none()));
    assert_eq!(renderer.end(), Vec::<String>::new());
}

static QUERIES: AtomicU32 = AtomicU32::new(0);

extern "system" fn count_query() -> vk::Result {
    QUERIES.fetch_add(1, Ordering::Relaxed);
    vk::Result::SUCCESS
}

/// The functions of the device that only profiling calls are counted.
#[test]
fn profiling_that_is_off_records_nothing() {
    let renderer = Renderer::new(Host::without_validation(), Schedule::Raster, Tools::default());
    let names =
        [c"vkCmdWriteTimestamp", c"vkCmdResetQueryPool", c"vkCmdBeginQuery", c"vkCmdEndQuery"];
    let counting = renderer.host.device_with(|name| {
        names.contains(&name).then_some(count_query as extern "system" fn() -> vk::Result)
    });
    let count = |watched: bool| {
        QUERIES.store(0, Ordering::Relaxed);
        renderer.host.run(|commands| renderer.frame(&counting, commands, watched));
        QUERIES.load(Ordering::Relaxed)
    };
    assert_eq!(count(false), 0);
    let steps = renderer.plan.steps().iter().filter(|step| **step != Step::Barrier).count();
    assert!(count(true) > steps as u32);
    renderer.end();
}

/// A host asks before it makes its device.
#[test]
fn capabilities_say_what_there_is() {
    let host = Host::without_validation();
    let family = host::family(&host.instance, host.physical_device);
    let found = Capabilities::of(&host.instance, host.physical_device, family, false);
    let clock = Clock::of(&host.instance, host.physical_device, family);
    assert_eq!(found.timestamps.ok(), clock);
    assert!(found.labels.unwrap_err().to_string().contains("VK_EXT_debug_utils"));
    let none = found.clone().without(&Capability::ALL);
    assert_eq!(none.device_extensions(), Vec::<&std::ffi::CStr>::new());
}

#[cfg(feature = "tracing")]
mod spans {
    use std::sync::Mutex;

    use tracing::field::{Field, Visit};
    use tracing::span::{Attributes, Id, Record};
    use tracing::{Event, Metadata, Subscriber};

    use super::*;

    #[derive(Default)]
    struct Spans(Mutex<Vec<Vec<(&'static str, String)>>>);

    struct Fields<'a>(&'a mut Vec<(&'static str, String)>);

    impl Visit for Fields<'_> {
        fn record_debug(&mut self, field: &Field, value: &dyn std::fmt::Debug) {
            self.0.push((field.name(), format!("{value:?}")));
        }
    }

    impl Subscriber for Spans {
        fn enabled(&self, metadata: &Metadata<'_>) -> bool {
            metadata.target() == "geosweep::gpu"
        }
        fn new_span(&self, span: &Attributes<'_>) -> Id {
            let mut fields = Vec::new();
            span.record(&mut Fields(&mut fields));
            let mut all = self.0.lock().unwrap();
            all.push(fields);
            Id::from_u64(all.len() as u64)
        }
        fn record(&self, _: &Id, _: &Record<'_>) {}
        fn record_follows_from(&self, _: &Id, _: &Id) {}
        fn event(&self, _: &Event<'_>) {}
        fn enter(&self, _: &Id) {}
        fn exit(&self, _: &Id) {}
    }

    /// Each pass is a span with its numbers.
    #[test]
    fn passes_are_spans() {
        let mut bench = Bench::new(30, 30, &[]);
        let profile = bench.profile(method(Wavefront::Planar, Schedule::Raster), Detail::default());
        let passes: Vec<_> = profile.passes().copied().collect();
        let spans = std::sync::Arc::new(Spans::default());
        tracing::subscriber::with_default(std::sync::Arc::clone(&spans), || {
            geosweep::vulkan::profile::emit(&passes);
        });
        let spans = spans.0.lock().unwrap();
        assert_eq!(spans.len(), passes.len());
        for (span, pass) in spans.iter().zip(&passes) {
            let field = |name: &str| span.iter().find(|(field, _)| *field == name).map(|f| &f.1);
            let number = |value: Option<u64>| value.map(|value| value.to_string());
            assert_eq!(field("kind"), Some(&format!("{:?}", pass.kind.name())));
            assert_eq!(field("gpu_ns").cloned(), number(pass.nanoseconds));
            assert_eq!(field("texels").cloned(), number(pass.work.texels));
            assert_eq!(field("invocations").cloned(), number(pass.invocations));
        }
    }
}
