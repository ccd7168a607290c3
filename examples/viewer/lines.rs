//! Contours and a path of a surface as lines. geosweep finds them after the map, and indirect draws draw them
//! in the same frame. The program never reads them.

use geosweep::vulkan::embed::{
    Access, ContourFrame, Contours, CurveBuffer, FrameSurface, LevelInput, PathFrame, Paths,
    PathsInfo, Solver, SourceInput, StartInput,
};

use crate::Result;
use crate::after_map::AfterMap;
use crate::gpu::Gpu;
use crate::pick::{Pick, PickPass};

/// Number of levels. The maps here need fewer, but levels beyond the farthest point cost next to nothing.
const LEVELS: usize = 200;
/// Largest number of vertices of all contours together.
const CONTOUR_ROOM: u32 = 400_000;
/// Room for the path, which may have many bends.
const PATH: PathsInfo = PathsInfo::new(1, 4096);

pub struct Lines {
    /// Start of the path; NaN until a place is picked.
    pub start: Pick,
    /// Contours, created when they are first shown.
    contours: Option<Contours>,
    path: Option<Paths>,
    /// Whether contours are drawn.
    shows_contours: bool,
    /// Whether lines must be found although the map has not changed.
    due: bool,
}

impl Lines {
    pub fn new(gpu: &mut Gpu, picking: &PickPass) -> Result<Self> {
        let start = Pick::new(gpu, picking)?;
        Ok(Self { start, contours: None, path: None, shows_contours: false, due: false })
    }

    /// Shows or hides contours from the next frame on.
    pub fn show_contours(
        &mut self,
        gpu: &mut Gpu,
        solver: &Solver,
        surface: &FrameSurface,
        show: bool,
    ) -> Result<()> {
        if show && self.contours.is_none() {
            let device = gpu.device.clone();
            let made = solver.contours(&device, gpu.allocator(), surface, CONTOUR_ROOM)?;
            self.contours = Some(made);
        }
        self.due |= self.shows_contours != show;
        self.shows_contours = show;
        Ok(())
    }

    /// Shows the path from the start's place in the next frame.
    pub fn show_path(
        &mut self,
        gpu: &mut Gpu,
        solver: &Solver,
        surface: &FrameSurface,
    ) -> Result<()> {
        if self.path.is_none() {
            let device = gpu.device.clone();
            self.path = Some(solver.paths(&device, gpu.allocator(), surface, PATH)?);
        }
        self.due = true;
        Ok(())
    }

    /// Records the passes that find the lines, if the map or the lines have changed. The levels of contours are
    /// multiples of `spacing`.
    pub fn record(&mut self, map: &AfterMap, spacing: f32) -> Result<()> {
        let due = std::mem::replace(&mut self.due, false);
        if !due && !map.changed {
            return Ok(());
        }
        let recording = map.recording();
        let (points, reader) = (0, Access::DRAW);
        if let Some(contours) = self.contours.as_ref().filter(|_| self.shows_contours) {
            let levels = LevelInput::Spacing { step: spacing, count: LEVELS };
            recording.contours(contours, &ContourFrame::new(levels, reader).with_points(points))?;
        }
        if let Some(path) = &self.path {
            let buffer = self.start.source.handle;
            let starts = StartInput::Buffer { buffer, offset: 0, count: 1 };
            let (before, sources) = (Access::TRANSFER_WRITE, SourceInput::Buffer(0));
            recording.paths(
                path,
                &PathFrame::new(starts, sources, reader).with_before(before).with_points(points),
            )?;
        }
        Ok(())
    }

    /// Returns the contours to draw.
    pub fn contours(&self) -> Option<CurveBuffer> {
        self.contours.as_ref().filter(|_| self.shows_contours).map(Contours::curves)
    }

    /// Returns the path to draw.
    pub fn path(&self) -> Option<CurveBuffer> {
        self.path.as_ref().map(Paths::curves)
    }

    pub fn destroy(&mut self, gpu: &mut Gpu) {
        let device = gpu.device.clone();
        if let Some(mut contours) = self.contours.take() {
            contours.destroy(&device, gpu.allocator());
        }
        if let Some(mut path) = self.path.take() {
            path.destroy(&device, gpu.allocator());
        }
        self.start.destroy(gpu);
    }
}
