//! The passes of a recording, made once for many frames.

use crate::Stop;
use crate::update::Wavefront;
use crate::vulkan::plan::{self, Portions, Step};
use crate::vulkan::profile::Grain;
use crate::vulkan::{Method, Schedule, TexelChart, schedules};

/// The passes of a recording, for any surface with a grid of one size, in texels of 2 x 2 points.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    pub(super) texels: TexelChart,
    pub(super) schedule: Schedule,
    pub(super) wavefront: Wavefront,
    pub(super) stop: Stop,
    steps: Vec<Step>,
    asked: u32,
    iterations: u32,
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
            // The list of tiles that rounds leave has a place in the recording.
            if planned >= iterations || schedule.has_rounds() {
                break;
            }
        }
        Self { texels, schedule, wavefront, stop, steps, asked: iterations, iterations: planned }
    }

    /// Most records of a recording of the steps, with those of copies of what the device decides.
    pub(super) fn records(&self, grain: Grain) -> u32 {
        schedules::records(&self.steps, grain) + 2
    }

    /// The passes, to look at.
    pub fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// The front assumed in maps of the plan, which is not always the one asked for: see
    /// [`super::Solver::new`].
    pub fn wavefront(&self) -> Wavefront {
        self.wavefront
    }

    /// The order of updates.
    pub fn schedule(&self) -> Schedule {
        self.schedule
    }

    /// Iterations, or rounds of tiles, that were asked for, no more than a map may take.
    pub fn asked(&self) -> u32 {
        self.asked
    }

    /// Iterations, or rounds of tiles, in a recording: those beyond convergence visit nothing. Of tiles there
    /// may be fewer than were [asked](Plan::asked) for, and of raster scans a few more.
    pub fn iterations(&self) -> u32 {
        self.iterations
    }
}
