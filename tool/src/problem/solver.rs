//! Holds the solver options of every command that computes a map.

use geosweep::vulkan::Schedule;
use geosweep::{DeviceChoice, Engine, Options, Wavefront};

use crate::choices::{Choice, auto_or, one_of};

#[derive(clap::Args)]
pub struct SolverArgs {
    /// Wavefront assumed between points
    #[arg(long, default_value = "auto", value_parser = auto_or(BEST_WAVEFRONT, &WAVEFRONTS))]
    #[arg(help_heading = "Solver")]
    wavefront: Choice<Wavefront>,
    /// Engine that computes the map
    #[arg(long, default_value = "auto", value_parser = one_of(&ENGINES))]
    #[arg(help_heading = "Solver")]
    engine: Engine,
    /// Vulkan device: its index in `geosweep devices`, or a part of its name; implies --engine vulkan
    #[arg(long, value_name = "NAME|INDEX", help_heading = "Solver")]
    device: Option<DeviceChoice>,
    /// Order of updates on a Vulkan device. All orders lead to the same map. Any value but auto implies
    /// --engine vulkan, and is only for single maps
    #[arg(long, default_value = "auto", value_parser = auto_or(BEST_SCHEDULE, &schedules()))]
    #[arg(help_heading = "Solver")]
    schedule: Choice<Schedule>,
    /// Stop after this many iterations. An iteration is four scans, or a round of tiles
    /// (default: 10 for each row and column)
    #[arg(long, value_name = "N", help_heading = "Solver")]
    iterations: Option<u32>,
    /// Stop when no distance falls by more than this fraction in an iteration (default: 1e-6; in
    /// double precision 1e-13)
    #[arg(long, value_name = "T", help_heading = "Solver", allow_hyphen_values = true)]
    tolerance: Option<f64>,
}

const BEST_WAVEFRONT: &str = "\
    Curved, with four exceptions: rays on the CPU for several sources, curves and closed surfaces, unless all \
    cells are alike and none is missing; anchored for point sources on floor plans; planar where normals or \
    the slowness vary at random from point to point; and planar for fast marching";
const WAVEFRONTS: [(Wavefront, &str); 5] = [
    (
        Wavefront::Curved,
        "Carries its curvature: the most accurate on smooth surfaces, around walls and from \
         curves, in about twice the time of circular",
    ),
    (
        Wavefront::Anchored,
        "Stores its anchor, the corner or source from which it comes in a straight line: exact, but \
         only for point sources on floor plans (flat, evenly spaced, with or without holes)",
    ),
    (
        Wavefront::Circular,
        "Circular: exact on developable surfaces, except for the error of sampling the surface, from \
         one point source; curved fronts replace it for several sources and where the slowness varies",
    ),
    (
        Wavefront::Rays,
        "Carries its curvature, its direction and its source, on the CPU: the most accurate where fronts of \
         several sources meet, or a front meets itself, in three to six times the time of curved",
    ),
    (Wavefront::Planar, "Straight: first-order accurate, as in the paper"),
];

const ENGINES: [(Engine, &str); 4] = [
    (
        Engine::Auto,
        "The CPU, or a GPU if there is one and it is faster, its set-up included. Measured on an NVIDIA \
         H200, that is from 17 million points with curved or anchored fronts, 63 million with circular \
         and 125 million with planar fronts",
    ),
    (Engine::Vulkan(DeviceChoice::Any), "The best Vulkan device, or an error"),
    (Engine::Cpu, "Raster scans on the CPU"),
    (
        Engine::FastMarching,
        "Fast marching on the CPU: points one after another, as fronts reach them. The engine cpu \
         does so too where a slowness changes much from point to point",
    ),
];

const BEST_SCHEDULE: &str = "The best schedule on the device";

fn schedules() -> [(Schedule, &'static str); Schedule::ALL.len()] {
    Schedule::ALL.map(|schedule| (schedule, schedule.about()))
}

impl SolverArgs {
    /// Returns whether a Vulkan device is requested.
    pub fn wants_device(&self) -> bool {
        let is_vulkan = matches!(self.engine, Engine::Vulkan(_));
        is_vulkan || self.device.is_some() || self.schedule.is_some()
    }

    pub fn options(&self) -> Result<Options, String> {
        let stops = self.iterations.is_some() || self.tolerance.is_some();
        if self.engine == Engine::FastMarching && stops {
            return Err("--iterations and --tolerance are for engines that iterate, which fast \
                        marching does not; leave them out"
                .into());
        }
        if matches!(self.engine, Engine::Cpu | Engine::FastMarching) {
            let for_vulkan =
                [("--device", self.device.is_some()), ("--schedule", self.schedule.is_some())];
            if let Some((option, _)) = for_vulkan.into_iter().find(|(_, is_given)| *is_given) {
                return Err(format!(
                    "{option} is only for --engine vulkan; leave out {option} or the other --engine"
                ));
            }
        }
        let device = self.device.clone().map(Engine::Vulkan);
        Ok(Options::default()
            .with_engine(device.unwrap_or_else(|| self.engine.clone()))
            .with_schedule(self.schedule)
            .with_wavefront(self.wavefront)
            .with_tolerance(self.tolerance)
            .with_iterations(self.iterations))
    }
}
