//! Computes a map in one call on a Vulkan device, or on whichever engine suits it best.

use crate::auto::Choice;
use crate::cpu;
use crate::share::share;
use crate::solve::Problem;
use crate::surface::{EdgeLengths, Seed};
use crate::vulkan::{self, DeviceChoice, Schedule, VulkanError};
use crate::{DistanceMap, Error, Targets, UsedEngine};

impl Problem<'_> {
    /// Solves on the engine that the crate chooses.
    pub fn solve_on_the_best(&self) -> Result<DistanceMap, Error> {
        let time = self.time_limit();
        if self.straight.is_some() {
            let reason = "fronts reach all points along straight lines".into();
            return Ok(self.solve_on_cpu()?.because(reason));
        }
        let seeds: Vec<_> = self.seeds.iter().map(|seed| self.grid.seed(*seed)).collect();
        let share = share(self.grid.surface(), &seeds, time, self.targets.as_ref());
        let (chart, is_kept) = (self.surface.chart(), vulkan::are_pipelines_kept());
        let reason = match Choice::of(chart, self.wavefront, share, is_kept) {
            Choice::Cpu(reason) => return Ok(self.solve_on_cpu()?.because(reason)),
            Choice::Gpu(reason) => reason,
        };
        use VulkanError::{NoDevice, NoLoader, NoUsableDevice, Surface};
        match self.solve_on_vulkan(&DeviceChoice::Gpu) {
            Ok(map) => self.finished(map.because(reason)),
            Err(Surface(error)) => Err(error.into()),
            Err(error @ (NoLoader(_) | NoDevice | NoUsableDevice(_))) => {
                Ok(self.solve_on_cpu()?.because(format!("there is no GPU: {error}")))
            }
            Err(error) => {
                let mut map = self.solve_on_cpu()?.because(reason);
                map.report.fallback = Some(error.to_string());
                Ok(map)
            }
        }
    }

    /// Solves on a device.
    pub fn solve_on_vulkan(&self, choice: &DeviceChoice) -> Result<DistanceMap, VulkanError> {
        let monitor = self.monitor.clone();
        vulkan::with_device(choice, monitor, |solver| self.solve_on_device(solver))
    }

    fn solve_on_device(
        &self,
        solver: &mut vulkan::HeadlessSolver,
    ) -> Result<DistanceMap, VulkanError> {
        let mut surface = solver.upload(self.grid.surface())?;
        let method = vulkan::Method::new(self.wavefront, self.stop)
            .with_schedule(self.schedule)
            .with_radius(self.time_limit());
        let seeds = self.solver_seeds();
        let solution = match &self.targets {
            Some(targets) => {
                let estimate = match solver.schedule(&surface, method) {
                    Schedule::Raster => self.estimate(&seeds, targets)?,
                    _ => f64::INFINITY,
                };
                solver.solve_to_about(&mut surface, &seeds, targets, estimate, method)?
            }
            None => solver.solve(&mut surface, &seeds, method)?,
        };
        let schedule = solution.schedule.name();
        let mut report = self.report(UsedEngine::Vulkan, schedule, solution.time);
        report.device = Some(solver.device_name().to_owned());
        (report.iterations, report.residual) = (solution.iterations, solution.residual);
        Ok(self.finish(solution.distances, report))
    }

    /// Returns an estimate of the arrival time at the targets.
    fn estimate(&self, seeds: &[Seed], targets: &Targets) -> Result<f64, VulkanError> {
        let edges = EdgeLengths::<f32>::new(self.grid.surface())?;
        Ok(cpu::estimate_targets(&edges, seeds, targets).0)
    }

    /// Returns the map that a device computed. A cancelled computation is an error, since its map may be incomplete.
    pub fn finished(&self, map: DistanceMap) -> Result<DistanceMap, Error> {
        self.monitor.check()?;
        Ok(map)
    }
}
