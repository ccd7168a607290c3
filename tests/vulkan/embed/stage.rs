//! A host with a solver and a surface, and the operations of tests on them. Hosts and solvers are lent, since
//! compiling their pipelines takes longer than most tests.

use std::ops::{Deref, DerefMut};

use geosweep::surface::{Chart, Geometry, Gluing};
use geosweep::vulkan::embed::{
    self, Access, Frame, PointKind, PointSource, Points, Reader, ResultImage, SourceInput,
    SurfaceInfo, Tools,
};
use geosweep::vulkan::{Method, Schedule, Tuning};
use geosweep::{Sources, Stop, Surface, Wavefront};

use crate::common::{Lent, Pool};
use crate::host::{Host, HostBuffer};

/// A host, and a solver with the passes that were used so far. While a stage has the solver, `solver` is `None`.
pub struct Kept {
    host: Host,
    solver: Option<embed::Solver>,
}

static WATCHED: Pool<Kept> = Pool::new();
static WATCHED_BUT_FOR_SHADERS: Pool<Kept> = Pool::new();
static UNWATCHED: Pool<Kept> = Pool::new();

impl Kept {
    /// Lends [`Host::new`].
    pub fn watched() -> Lent<Self> {
        WATCHED.lend(|| Host::new().into(), Self::check)
    }

    /// Lends [`Host::with_synchronization_validation`].
    pub fn watched_but_for_shaders() -> Lent<Self> {
        let open = || Host::with_synchronization_validation().into();
        WATCHED_BUT_FOR_SHADERS.lend(open, Self::check)
    }

    /// Lends [`Host::without_validation`].
    pub fn unwatched() -> Lent<Self> {
        UNWATCHED.lend(|| Host::without_validation().into(), Self::check)
    }

    /// Returns a host with a solver of its own, which has these `tools` and the tuning that `change` returns.
    pub fn tuned(host: Host, tools: Tools, change: impl FnOnce(Tuning) -> Tuning) -> Self {
        let (instance, device) = (&host.instance, &host.device);
        let physical_device = host.physical_device;
        let mut solver =
            embed::Solver::with_tools(instance, physical_device, device, &[], tools).unwrap();
        let tuning = change(solver.tuning());
        solver.set_tuning(instance, physical_device, device, tuning).unwrap();
        assert_eq!(solver.tuning(), tuning);
        Self { host, solver: Some(solver) }
    }

    fn check(&self) {
        assert_eq!((self.host.messages(), self.host.allocations()), (Vec::new(), 0));
    }
}

impl From<Host> for Kept {
    fn from(host: Host) -> Self {
        Self { host, solver: None }
    }
}

impl From<Host> for Lent<Kept> {
    fn from(host: Host) -> Self {
        Kept::from(host).into()
    }
}

impl Deref for Kept {
    type Target = Host;

    fn deref(&self) -> &Host {
        &self.host
    }
}

impl DerefMut for Kept {
    fn deref_mut(&mut self) -> &mut Host {
        &mut self.host
    }
}

impl Drop for Kept {
    fn drop(&mut self) {
        let Some(mut solver) = self.solver.take() else { return };
        let said = self.host.messages();
        solver.destroy(&self.host.device);
        if !std::thread::panicking() {
            assert_eq!(self.host.messages(), said);
        }
    }
}

pub const STOP: Stop = Stop::within(1e-6).or_after(400);

/// Raster scans with each wavefront that suits any surface.
pub const RASTER: [(Schedule, Wavefront); 3] = [
    (Schedule::Raster, Wavefront::Planar),
    (Schedule::Raster, Wavefront::Circular),
    (Schedule::Raster, Wavefront::Curved),
];

/// A prepared surface. [`Stage::end`] destroys it.
pub struct Stage {
    pub host: Lent<Kept>,
    pub solver: embed::Solver,
    pub surface: embed::FrameSurface,
    download: HostBuffer,
    /// Buffers that end with the stage.
    own: Vec<HostBuffer>,
}

impl Stage {
    pub fn new(
        host: impl Into<Lent<Kept>>,
        passes: &[(Schedule, Wavefront)],
        info: &SurfaceInfo,
    ) -> Self {
        let mut host = host.into();
        let device = host.device.clone();
        let mut solver = host.solver.take().unwrap_or_else(|| {
            embed::Solver::new(&host.instance, host.physical_device, &device, &[]).unwrap()
        });
        for &(schedule, wavefront) in passes {
            solver.add_passes(&device, schedule, wavefront).unwrap();
        }
        let surface = solver.surface(&device, host.allocator(), info).unwrap();
        assert_eq!(solver.bytes_for(&device, info).unwrap(), surface.bytes());
        let download = host.buffer(4 * info.chart.points() as u64, true);
        host.run(|commands| solver.record(&device, commands, &surface).prepare());
        Self { host, solver, surface, download, own: Vec::new() }
    }

    /// Creates a stage with a glued or open surface, whose points a buffer holds as these numbers.
    pub fn on(
        host: impl Into<Lent<Kept>>,
        passes: &[(Schedule, Wavefront)],
        glued: (&Surface, Option<&Gluing>),
        numbers: (PointKind, Vec<f32>),
    ) -> Self {
        Self::on_changed(host, passes, glued, numbers, |info| info)
    }

    /// Creates a stage as [`Stage::on`] does, with parameters of the surface that `change` returns.
    pub fn on_changed(
        host: impl Into<Lent<Kept>>,
        passes: &[(Schedule, Wavefront)],
        (surface, gluing): (&Surface, Option<&Gluing>),
        (kind, numbers): (PointKind, Vec<f32>),
        change: impl FnOnce(SurfaceInfo) -> SurfaceInfo,
    ) -> Self {
        let mut host = host.into();
        let buffer = host.buffer_of(&numbers);
        let stride = size_of_val(&numbers[..]) as u64 / surface.chart().points() as u64;
        let points = [Points { kind, ..Points::positions(buffer.handle, stride) }];
        let info = SurfaceInfo::new(surface.chart())
            .with_points(&points)
            .with_edge_rule(surface.edge_rule())
            .with_gluing(gluing);
        let mut stage = Self::new(host, passes, &change(info));
        stage.own.push(buffer);
        stage
    }

    /// Creates a stage with the surface of [`vertices`].
    pub fn of_waves(
        host: impl Into<Lent<Kept>>,
        passes: &[(Schedule, Wavefront)],
        info: SurfaceInfo,
        phase: f32,
    ) -> Self {
        let mut host = host.into();
        let buffer = host.buffer_of(&vertices(info.chart, phase));
        let points = [Points::positions(buffer.handle, 32)];
        let mut stage = Self::new(host, passes, &info.with_points(&points));
        stage.own.push(buffer);
        stage
    }

    pub fn plan(&self, schedule: Schedule, wavefront: Wavefront, iterations: u32) -> embed::Plan {
        let method = Method::new(wavefront, STOP).with_schedule(schedule);
        self.solver.plan(self.surface.chart(), method, iterations).unwrap()
    }

    /// Runs a frame, then recordings until the map has converged.
    pub fn map(&self, points: usize, sources: SourceInput, plan: &embed::Plan) -> Vec<f32> {
        self.run(|recording| {
            recording.frame(&Frame::new(plan, sources, Reader::COPY).with_points(points))
        });
        self.finish(plan);
        self.read()
    }

    /// Runs a recording that measures the points and solves the map as far as the plan goes.
    pub fn solve(&self, sources: SourceInput, plan: &embed::Plan) {
        self.run(|recording| {
            recording.begin(Access::NONE);
            recording.measure(0).unwrap();
            recording.solve(sources, plan).unwrap();
            recording.outcome(0).unwrap();
            recording.result(0, Reader::COPY, f32::INFINITY)
        });
    }

    /// Adds sources to the map, and returns the map once it has converged.
    pub fn add(&self, sources: SourceInput, plan: &embed::Plan) -> Vec<f32> {
        self.run(|recording| {
            recording.begin(Access::NONE);
            recording.add(sources, plan).unwrap();
            recording.outcome(0).unwrap();
            recording.result(0, Reader::COPY, f32::INFINITY)
        });
        self.finish(plan);
        self.read()
    }

    /// Resumes the plan until the map has converged.
    pub fn finish(&self, plan: &embed::Plan) {
        while !self.surface.outcome(0).unwrap().converged {
            let before = self.surface.outcome(0).unwrap();
            self.run(|recording| {
                recording.begin(Access::NONE);
                recording.resume(plan).unwrap();
                recording.outcome(0).unwrap();
                recording.result(0, Reader::COPY, f32::INFINITY)
            });
            let after = self.surface.outcome(0).unwrap();
            assert!(after.iterations > before.iterations, "{before:?} {after:?}");
        }
    }

    /// Records, submits, waits, and copies the image of distances.
    pub fn run(
        &self,
        record: impl FnOnce(embed::Recording) -> Result<ResultImage, geosweep::vulkan::VulkanError>,
    ) {
        let device = &self.host.device;
        self.host.run(|commands| {
            let image = record(self.solver.record(device, commands, &self.surface)).unwrap();
            self.host.copy_image(commands, image, &self.download);
        });
    }

    /// Returns the distances that [`Stage::run`] has copied.
    pub fn read(&self) -> Vec<f32> {
        self.download.floats()[..self.surface.chart().points()].to_vec()
    }

    /// Destroys everything except what was lent. Asserts that nothing is left in the allocator, and that the
    /// validation layers have reported nothing.
    pub fn end(self, buffers: impl IntoIterator<Item = HostBuffer>) {
        assert_eq!(self.host.messages(), Vec::<String>::new());
        assert_eq!(self.take_down(buffers), Vec::<String>::new());
    }

    /// Destroys everything except what was lent. Asserts that nothing is left in the allocator. Returns the
    /// messages of the validation layers.
    pub fn take_down(self, buffers: impl IntoIterator<Item = HostBuffer>) -> Vec<String> {
        let Self { mut host, solver, mut surface, download, own } = self;
        let device = host.device.clone();
        surface.destroy(&device, host.allocator());
        host.solver = Some(solver);
        host.free(download);
        own.into_iter().chain(buffers).for_each(|buffer| host.free(buffer));
        assert_eq!(host.allocations(), 0);
        host.messages()
    }
}

/// Returns a point source.
pub fn source(row: f32, col: f32) -> [PointSource; 1] {
    [PointSource::at(row, col)]
}

/// Returns positions of a wavy surface, with eight floats per point, like vertices that have further
/// attributes.
pub fn vertices(chart: Chart, phase: f32) -> Vec<f32> {
    (0..chart.points())
        .flat_map(|index| {
            let (row, col) = chart.position(index);
            let (x, y) = (col as f32, 1.2 * row as f32);
            let z = 2.0 * (0.3 * x + phase).sin() * (0.2 * y).cos();
            [x, y, z, 0.5, 0.5, 0.0, 0.0, 1.0]
        })
        .collect()
}

/// Returns the numbers of a surface's points as a host has them, NaN at holes, and their kind.
pub fn numbers_of(surface: &Surface) -> (PointKind, Vec<f32>) {
    let present = |index: usize, number: f64| match surface.present()[index] {
        true => number as f32,
        false => f32::NAN,
    };
    match surface.geometry() {
        Geometry::Heights { heights, spacing } => {
            let numbers = heights.iter().enumerate().map(|(index, &height)| present(index, height));
            (PointKind::Heights(*spacing), numbers.collect())
        }
        Geometry::Positions(_) => positions_of(surface),
        Geometry::Metric(tensors) => {
            let numbers = tensors.iter().enumerate().flat_map(|(index, tensor)| {
                [tensor.rr, tensor.rc, tensor.cc].map(|number| present(index, number))
            });
            (PointKind::Metric, numbers.collect())
        }
    }
}

/// Returns x, y and z of each point, NaN at holes.
pub fn positions_of(surface: &Surface) -> (PointKind, Vec<f32>) {
    let chart = surface.chart();
    let position = |index| {
        let (row, col) = chart.position(index);
        let place = surface.position(row, col).filter(|_| surface.has(row, col));
        place.map_or([f32::NAN; 3], |position| position.as_vec3().to_array())
    };
    (PointKind::Positions, (0..chart.points()).flat_map(position).collect())
}

/// Returns sources at these places.
pub fn sources_at(places: &[[f32; 2]]) -> Vec<PointSource> {
    places.iter().map(|&[row, col]| PointSource::at(row, col)).collect()
}

/// Returns the same sources for the CPU.
pub fn on_cpu(sources: &[PointSource]) -> Sources {
    let add = |all: Sources, source: &PointSource| {
        all.and_point(source.row.into(), source.col.into(), source.time.into())
    };
    sources.iter().fold(Sources::default(), add)
}
