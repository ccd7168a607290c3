//! A headless solver that is profiled.

use geosweep::surface::Seed;
use geosweep::vulkan::plan::{Reached, Step};
use geosweep::vulkan::profile::{Capability, Detail, PassKind, PassRecord, SolveProfile};
use geosweep::vulkan::{HeadlessSolver, Method, Schedule, SurfaceOnDevice, TexelChart, Tuning};
use geosweep::{Surface, Wavefront};

use crate::common::{CONVERGED, Lent, Pool, device_choice, rough, seeds_at, some_point};

pub fn method(wavefront: Wavefront, schedule: Schedule) -> Method {
    Method::new(wavefront, CONVERGED).with_schedule(schedule)
}

static SOLVERS: Pool<HeadlessSolver> = Pool::new();

/// Lends a solver on a device with everything that profiling uses.
pub fn profiling_solver() -> Lent<HeadlessSolver> {
    SOLVERS.lend(|| HeadlessSolver::for_profiling(&device_choice(), &[]).unwrap(), |_| ())
}

/// A surface on a device that is profiled.
pub struct Bench {
    pub surface: Surface,
    pub seeds: Vec<Seed>,
    pub on_device: SurfaceOnDevice,
    pub solver: Lent<HeadlessSolver>,
}

impl Bench {
    pub fn new(rows: usize, cols: usize) -> Self {
        Self::with(rows, cols, profiling_solver())
    }

    /// Returns a bench on a device that lacks some capabilities.
    pub fn without(rows: usize, cols: usize, left_out: &[Capability]) -> Self {
        let solver = HeadlessSolver::for_profiling(&device_choice(), left_out);
        Self::with(rows, cols, solver.unwrap().into())
    }

    /// Returns a bench with the tuning that `change` returns.
    pub fn tuned(rows: usize, cols: usize, change: impl FnOnce(Tuning) -> Tuning) -> Self {
        let solver = HeadlessSolver::for_profiling(&device_choice(), &[]).unwrap();
        let tuning = change(solver.tuning());
        Self::with(rows, cols, solver.with_tuning(tuning).unwrap().into())
    }

    fn with(rows: usize, cols: usize, solver: Lent<HeadlessSolver>) -> Self {
        let surface = rough(rows, cols, 0);
        let seeds = seeds_at(&surface, some_point(&surface));
        let on_device = solver.upload(&surface).unwrap();
        Self { surface, seeds, on_device, solver }
    }

    pub fn profile(&mut self, method: Method, detail: Detail) -> SolveProfile {
        let Self { seeds, solver, on_device, .. } = self;
        solver.profile(on_device, seeds, method, detail).unwrap().1
    }

    /// Returns the number of iterations of the map without a profile.
    pub fn iterations(&mut self, method: Method) -> u32 {
        self.solver.solve(&mut self.on_device, &self.seeds, method).unwrap().iterations
    }

    /// Returns the recorded steps, portion by portion, and the texels.
    pub fn steps(&self, method: Method, portions: usize) -> (TexelChart, Vec<Vec<Step>>) {
        let texels = TexelChart::new(self.surface.chart()).unwrap();
        let sizes = self.solver.tuning().portions(method.wavefront, texels);
        let schedule = method.schedule.unwrap();
        let places = self.seeds.iter().map(|seed| TexelChart::texel_of(seed.row, seed.col));
        let mut reached = Reached::around(places.map(|(row, col, _)| (row, col)));
        let steps =
            (0..portions).map(|_| schedule.plan(texels, sizes, reached.take(), u32::MAX)).collect();
        (texels, steps)
    }
}

pub fn of_kind(profile: &SolveProfile, kind: PassKind) -> impl Iterator<Item = &PassRecord> {
    profile.passes().filter(move |pass| pass.kind == kind)
}

pub fn sum(passes: &[&PassRecord], of: impl Fn(&PassRecord) -> Option<u64>) -> u64 {
    passes.iter().map(|pass| of(pass).unwrap_or_else(|| panic!("{pass:?}"))).sum()
}
