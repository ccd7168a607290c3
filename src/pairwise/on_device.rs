//! Computes rows on a Vulkan device, in batches.

use crate::surface::{SolverGrid, Surface};
use crate::vulkan::{HeadlessSolver, PairwiseOnDevice, SurfaceOnDevice};
use crate::{Convergence, DeviceChoice, Error, Monitor, Stop, Wavefront};

/// The batched engine of a surface on a device.
pub(super) struct OnDevice {
    pairwise: PairwiseOnDevice,
    surface: SurfaceOnDevice,
    solver: HeadlessSolver,
}

impl OnDevice {
    /// Opens a device, and prepares it for the surface that solvers see.
    pub fn new(
        choice: &DeviceChoice,
        surface: &Surface,
        wavefront: Wavefront,
        monitor: &Monitor,
    ) -> Result<Self, Error> {
        let solver = HeadlessSolver::new(choice)?.with_monitor(monitor.clone());
        let surface = solver.upload(surface)?;
        let pairwise = solver.pairwise(&surface, wavefront, None)?;
        Ok(Self { pairwise, surface, solver })
    }

    /// Returns the name of the device.
    pub fn name(&self) -> &str {
        self.solver.device_name()
    }

    /// Returns the number of bytes on the device.
    pub fn bytes(&self) -> usize {
        (self.surface.bytes() + self.pairwise.bytes()) as usize
    }

    /// Returns the number of rows in a batch.
    pub fn batch(&self) -> usize {
        self.pairwise.batch()
    }

    /// Computes the rows of some sources, batch by batch, unless the monitor cancels them. The row of a hole is +infinity.
    pub fn solve(
        &mut self,
        (surface, grid): (&Surface, &SolverGrid),
        sources: &[usize],
        stop: Stop,
        into: &mut [f32],
        (monitor, done): (&Monitor, &(dyn Fn(usize) + Sync)),
    ) -> Result<Convergence, Error> {
        let Self { pairwise, surface: on_device, solver } = self;
        let points = surface.chart().points();
        let of_grid = grid.surface().chart().points();
        let batch = pairwise.batch();
        let mut wide = vec![f32::INFINITY; if grid.is_wider() { batch * of_grid } else { 0 }];
        let mut convergence = Convergence::NONE;
        for (sources, rows) in sources.chunks(batch).zip(into.chunks_mut(batch * points)) {
            monitor.check()?;
            let sources = grid.points(sources);
            let solved = if grid.is_wider() {
                let wide = &mut wide[..sources.len() * of_grid];
                let solved = pairwise.solve(solver, on_device, &sources, stop, wide)?;
                let own = rows.chunks_exact_mut(points);
                own.zip(wide.chunks_exact(of_grid))
                    .for_each(|(own, wide)| grid.crop_into(wide, own));
                solved
            } else {
                pairwise.solve(solver, on_device, &sources, stop, rows)?
            };
            convergence = convergence.worse(solved);
            done(sources.len());
        }
        Ok(convergence)
    }
}
