//! The decal around a surface's source. geosweep computes its log map after the distances, and the surface's
//! shader reads it in the same frame.

use clap::ValueEnum;
use geosweep::vulkan::embed::{
    Access, FrameSurface, LogMapFrame, LogMapImage, Reader, Solver, SourceInput,
};

use crate::Result;
use crate::after_map::AfterMap;
use crate::gpu::Gpu;
use crate::sets::Sets;
use crate::shaders;

/// Sizes in spacings of lines: the first radius, its limits, and how much farther the log map reaches, so
/// that the shader can interpolate at the decal's border. This last size is more than a cell of any surface.
pub const RADIUS: f32 = 5.0;
const LIMITS: [f32; 2] = [1.0, 15.0];
const MARGIN: f32 = 0.8;
/// Factor from one size to the next.
const FACTOR: f32 = 1.25;
/// Value of u and v beyond the log map's reach.
const NOWHERE: f32 = 1e6;

/// Method by which a point of the surface finds its place in the decal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Placement {
    /// Uses the log map, so that the decal lies on the surface as if it were glued there
    LogMap,
    /// Projected from above, so that the decal smears over slopes
    Projected,
}

/// A decal's placement and its radius in spacings of lines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Placement; `None` while there is no decal.
    pub placement: Option<Placement>,
    pub radius: f32,
}

/// The decal of a surface.
pub struct Decal {
    pub look: Look,
    /// Log map, created when it is first shown.
    log_map: Option<LogMapImage>,
    /// Whether the map or the radius has changed since the log map was computed.
    outdated: bool,
}

impl Look {
    /// Returns the look with the next placement. No decal also counts as a placement.
    pub fn placed_otherwise(self) -> Self {
        let placement = match self.placement {
            None => Some(Placement::LogMap),
            Some(Placement::LogMap) => Some(Placement::Projected),
            Some(Placement::Projected) => None,
        };
        Self { placement, ..self }
    }

    /// Returns the look with a radius that is `by` sizes larger, or smaller if `by` is negative.
    pub fn larger(self, by: i32) -> Self {
        let [least, most] = LIMITS;
        Self { radius: (self.radius * FACTOR.powi(by)).clamp(least, most), ..self }
    }
}

impl Decal {
    pub fn new() -> Self {
        let look = Look { placement: None, radius: RADIUS };
        Self { look, log_map: None, outdated: true }
    }

    /// Changes the look from the next frame on. Waits for the device when the log map is first shown, since
    /// the device may be using the sets.
    pub fn show(
        &mut self,
        gpu: &mut Gpu,
        solver: &Solver,
        (surface, sets): (&FrameSurface, &Sets),
        look: Look,
    ) -> Result<()> {
        if look.placement == Some(Placement::LogMap) && self.log_map.is_none() {
            let device = gpu.device.clone();
            let log_map = solver.log_map(&device, gpu.allocator(), surface)?;
            gpu.wait();
            sets.bind_image(gpu, shaders::LOG_MAP, log_map.image(Reader::FRAGMENT.layout));
            self.log_map = Some(log_map);
        }
        self.outdated |= look.radius != self.look.radius;
        self.look = look;
        Ok(())
    }

    /// Records the passes that compute the log map, if the map or the radius has changed. `spacing` is the
    /// distance between lines.
    pub fn record(&mut self, map: &AfterMap, spacing: f32) -> Result<()> {
        self.outdated |= map.changed;
        let shown = self.look.placement == Some(Placement::LogMap);
        let Some(log_map) = self.log_map.as_ref().filter(|_| shown && self.outdated) else {
            return Ok(());
        };
        self.outdated = false;
        let frame = LogMapFrame::new(SourceInput::Buffer(0), Reader::FRAGMENT)
            .with_before(Access::TRANSFER_WRITE)
            .with_radius((self.look.radius + MARGIN) * spacing)
            .with_unreached(NOWHERE);
        map.recording().log_map(log_map, &frame)?;
        Ok(())
    }

    pub fn destroy(&mut self, gpu: &mut Gpu) {
        let device = gpu.device.clone();
        if let Some(mut log_map) = self.log_map.take() {
            log_map.destroy(&device, gpu.allocator());
        }
    }
}
