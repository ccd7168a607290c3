//! The distance map of a surface. This module and those of the lines, the decal and the agents on the map are all
//! that uses geosweep in this program.

use geosweep::Stop;
use geosweep::Wavefront;
use geosweep::ash::vk;
use geosweep::surface::{Chart, Gluing};
use geosweep::vulkan::embed::{
    Access, Frame, FrameSurface, Lookup, Outcome, Plan, PointSource, Points, Reader, ResultImage,
    Solver, SourceBuffer, SourceInput, SurfaceInfo,
};
use geosweep::vulkan::{Method, Schedule};

use crate::Result;
use crate::frames::{self, IN_FLIGHT};
use crate::gpu::Gpu;

/// Value in the image at points that are not reached.
const UNREACHED: f32 = -1.0;

/// Memory of the program that a map reads and writes.
pub struct Memory {
    /// Positions, four floats each.
    pub positions: vk::Buffer,
    /// Single source, in the form that the picking pass writes.
    pub source: vk::Buffer,
    /// Places on the grid, as [`places`] returns them.
    pub places: vk::Buffer,
    /// Distances of these places, from which the range of the colors follows.
    pub distances: vk::Buffer,
}

pub struct Map {
    surface: FrameSurface,
    plan: Plan,
    due: Due,
    /// Slot of the image that is drawn.
    slot: usize,
    /// Slot that each frame in flight has written, and the number of the recording.
    written: [Option<(usize, u64)>; IN_FLIGHT],
    recordings: u64,
    outcome: Option<Outcome>,
}

/// Work of the next frame for the map.
#[derive(Clone, Copy, PartialEq)]
enum Due {
    Nothing,
    /// The map continues, since it has not converged.
    Resume,
    /// The source or the method is new.
    Solve,
    /// The points are new.
    Measure,
}

/// Number of places in each direction at which distances are looked up. On an open surface the corners would be
/// enough; the farthest point of a closed one may be anywhere.
const PLACES: usize = 5;

/// Returns rows and columns of places that are spread over a grid, its corners among them.
pub fn places(chart: Chart) -> Vec<[f32; 2]> {
    let at = |place: usize, points: usize| (place * (points - 1)) as f32 / (PLACES - 1) as f32;
    let all = (0..PLACES).flat_map(|row| (0..PLACES).map(move |col| [row, col]));
    all.map(|[row, col]| [at(row, chart.rows), at(col, chart.cols)]).collect()
}

impl Map {
    /// Creates the map of a grid, whose sides may be glued.
    pub fn new(
        gpu: &mut Gpu,
        solver: &Solver,
        (chart, gluing): (Chart, Option<&Gluing>),
        memory: &Memory,
    ) -> Result<Self> {
        let device = gpu.device.clone();
        let lookup_buffers = [Lookup {
            places: memory.places,
            places_offset: 0,
            distances: memory.distances,
            distances_offset: 0,
            count: (PLACES * PLACES) as u32,
        }];
        let source_buffers = [SourceBuffer { buffer: memory.source, offset: 0, count: 1 }];
        let inputs = [Points::positions(memory.positions, 16)];
        let info = SurfaceInfo::new(chart)
            .with_slots(IN_FLIGHT)
            .with_gluing(gluing)
            .with_points(&inputs)
            .with_sources(&source_buffers)
            .with_lookups(&lookup_buffers);
        let surface = solver.surface(&device, gpu.allocator(), &info)?;
        let plan = plan(solver, &surface, None, Wavefront::Curved)?;
        let written = [None; IN_FLIGHT];
        let due = Due::Measure;
        Ok(Self { surface, plan, due, slot: 0, written, recordings: 0, outcome: None })
    }

    /// Records the preparation of the surface: once before anything else, and again when the solver has new passes.
    pub fn prepare(&self, gpu: &Gpu, solver: &Solver, commands: vk::CommandBuffer) {
        solver.record(&gpu.device, commands, &self.surface).prepare();
    }

    /// Returns the image of distances in a slot.
    pub fn image(&self, slot: usize) -> Result<ResultImage> {
        Ok(self.surface.result(slot, reader().layout)?)
    }

    /// Returns the surface on which contours and paths are found.
    pub fn surface(&self) -> &FrameSurface {
        &self.surface
    }

    /// Returns the slot that is drawn.
    pub fn slot(&self) -> usize {
        self.slot
    }

    pub fn use_method(
        &mut self,
        solver: &Solver,
        schedule: Schedule,
        wavefront: Wavefront,
    ) -> Result<()> {
        self.plan = plan(solver, &self.surface, Some(schedule), wavefront)?;
        self.due = self.due.at_least(Due::Solve);
        self.outcome = None;
        Ok(())
    }

    /// Notes that the source has moved.
    pub fn moved_source(&mut self) {
        self.due = self.due.at_least(Due::Solve);
    }

    /// Notes that the points have moved.
    pub fn moved_points(&mut self) {
        self.due = Due::Measure;
    }

    /// Returns whether a frame would change the map, or is needed to learn whether it has converged.
    pub fn is_due(&self) -> bool {
        self.due != Due::Nothing || self.written.iter().any(Option::is_some)
    }

    /// Returns the outcome of the last map that the device has finished.
    pub fn outcome(&self) -> Option<Outcome> {
        self.outcome
    }

    /// Reads the outcome of a frame, after its fence.
    pub fn collect(&mut self, frame: frames::Frame) -> Result<()> {
        if let Some((slot, recording)) = self.written[frame.index].take() {
            let outcome = self.surface.outcome(slot)?;
            self.outcome = Some(outcome);
            if recording == self.recordings && !outcome.converged && self.due == Due::Nothing {
                self.due = Due::Resume;
            }
        }
        Ok(())
    }

    /// Returns whether [`Map::record`] has something to record.
    pub fn records(&self) -> bool {
        self.due != Due::Nothing
    }

    /// Records the due work. Points and sources come from earlier compute shaders and copies.
    pub fn record(&mut self, gpu: &Gpu, solver: &Solver, frame: frames::Frame) -> Result<()> {
        let due = std::mem::replace(&mut self.due, Due::Nothing);
        // The previous frame may still draw the other image.
        let slot = (self.slot + 1) % IN_FLIGHT;
        let recording = solver.record(&gpu.device, frame.commands, &self.surface);
        match due {
            Due::Nothing => return Ok(()),
            Due::Resume => {
                recording.begin(Access::NONE);
                recording.resume(&self.plan)?;
                recording.outcome(slot)?;
                recording.result(slot, reader(), UNREACHED)?;
            }
            Due::Solve | Due::Measure => {
                recording.frame(
                    &Frame::new(&self.plan, SourceInput::Buffer(0), reader())
                        .with_before(Access::COMPUTE_WRITE.and(Access::TRANSFER_WRITE))
                        .with_points((due == Due::Measure).then_some(0))
                        .with_slot(slot)
                        .with_unreached(UNREACHED),
                )?;
            }
        }
        recording.lookup(0, UNREACHED, Access::FRAGMENT_READ, Access::FRAGMENT_READ)?;
        self.recordings += 1;
        self.written[frame.index] = Some((slot, self.recordings));
        self.slot = slot;
        Ok(())
    }

    pub fn destroy(&mut self, gpu: &mut Gpu) {
        let device = gpu.device.clone();
        self.surface.destroy(&device, gpu.allocator());
    }
}

impl Due {
    fn at_least(self, other: Self) -> Self {
        if self == Self::Measure { self } else { other }
    }
}

/// Returns the readers of the image: the surface's shader, and the pass that moves agents.
fn reader() -> Reader {
    Reader::sampled(Access::FRAGMENT_READ.and(Access::COMPUTE_READ))
}

/// Returns the picking pass's output for a source at a grid point.
pub fn source(at: [f32; 2]) -> [f32; 4] {
    let PointSource { row, col, time, curvature } = PointSource::at(at[0], at[1]);
    [row, col, time, curvature]
}

fn plan(
    solver: &Solver,
    surface: &FrameSurface,
    schedule: Option<Schedule>,
    wavefront: Wavefront,
) -> Result<Plan> {
    // The tolerance is below what a picture shows.
    let stop = Stop::within(1e-4).or_after(10_000);
    // Number of iterations that smooth surfaces need in one frame. If they are not enough, the next frames continue
    // the map.
    let iterations = match schedule {
        Some(Schedule::Tiles) => 128,
        Some(Schedule::Raster) | None => 8,
    };
    let method = Method::new(wavefront, stop).with_schedule(schedule);
    let plan = solver.plan(surface.chart(), method, iterations)?;
    Ok(if surface.is_glued() { plan.over_seams() } else { plan })
}
