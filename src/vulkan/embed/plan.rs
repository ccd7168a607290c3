//! Lists the passes of a recording. A plan is made once and used for many frames.

use crate::Stop;
use crate::update::Wavefront;
use crate::vulkan::profile::Grain;
use crate::vulkan::profile::steps::records;
use crate::vulkan::schedules::plan;
use crate::vulkan::schedules::plan::{Portions, Step};
use crate::vulkan::{Method, Schedule, TexelChart};

/// List of the passes of a recording. It fits every surface whose grid has the same size in texels of 2 x 2
/// points.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    pub(super) texels: TexelChart,
    pub(super) schedule: Schedule,
    pub(super) wavefront: Wavefront,
    pub(super) stop: Stop,
    steps: Vec<Step>,
    asked: u32,
    iterations: u32,
    pub(super) is_over_seams: bool,
}

impl Plan {
    pub(super) fn new(
        portions: Portions,
        texels: TexelChart,
        schedule: Schedule,
        method: Method,
        iterations: u32,
    ) -> Self {
        let Method { wavefront, stop, .. } = method;
        let mut steps = Vec::new();
        let mut planned = 0;
        let iterations = iterations.clamp(1, stop.iterations.max(1));
        loop {
            let more = schedule.plan(texels, portions, None, iterations - planned);
            planned += plan::iterations(&more);
            steps.extend(more);
            // A recording holds only one batch of rounds, since there is room for only one list of the tiles
            // that a batch leaves over.
            if planned >= iterations || schedule.has_rounds() {
                break;
            }
        }
        let (asked, iterations, is_over_seams) = (iterations, planned, false);
        Self { texels, schedule, wavefront, stop, steps, asked, iterations, is_over_seams }
    }

    /// Returns the plan for glued surfaces ([`super::SurfaceInfo::gluing`]): fronts pass seams after each scan, or
    /// each round of tiles.
    pub fn over_seams(self) -> Self {
        if self.is_over_seams {
            return self;
        }
        Self { steps: plan::with_exchanges(self.steps), is_over_seams: true, ..self }
    }

    /// Returns the largest number of profile records that a recording of the steps makes. The number includes
    /// copies of the device's decisions, and checks of targets.
    pub(super) fn records(&self, grain: Grain) -> u32 {
        records(&self.steps, grain) + self.iterations + 2
    }

    /// Returns the passes for inspection.
    pub fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// Returns the wavefront of the plan's maps. It can differ from the requested one: see
    /// [`super::Solver::new`].
    pub fn wavefront(&self) -> Wavefront {
        self.wavefront
    }

    /// Returns the schedule, which is the order of updates.
    pub fn schedule(&self) -> Schedule {
        self.schedule
    }

    /// Returns the requested number of iterations, or of rounds of tiles, limited to the largest number that
    /// [`Method::stop`] allows.
    pub fn asked(&self) -> u32 {
        self.asked
    }

    /// Returns the number of iterations, or of rounds of tiles, in a recording. Iterations after convergence
    /// visit nothing. A recording may hold fewer rounds of tiles than were [asked](Plan::asked) for, or a few
    /// more raster iterations.
    pub fn iterations(&self) -> u32 {
        self.iterations
    }
}
