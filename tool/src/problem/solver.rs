//! How to solve: the options of every command that computes a map.

use clap::ValueEnum;
use geosweep::vulkan::Schedule;
use geosweep::{DeviceChoice, Engine, Options, Wavefront};

#[derive(clap::Args)]
pub struct SolverArgs {
    /// The front assumed between points
    #[arg(long, value_enum, default_value_t, help_heading = "Solver")]
    wavefront: WavefrontArg,
    /// What computes the map
    #[arg(long, value_enum, default_value_t, help_heading = "Solver")]
    engine: EngineArg,
    /// The Vulkan device: its index in `geosweep devices`, or a part of its name; implies
    /// --engine vulkan
    #[arg(long, value_name = "NAME|INDEX", help_heading = "Solver")]
    device: Option<String>,
    /// The order of updates on a Vulkan device, the same map from each; any but auto implies
    /// --engine vulkan, and is for single maps
    #[arg(long, value_enum, default_value_t, help_heading = "Solver")]
    schedule: ScheduleArg,
    /// Stop after this many iterations: of four scans, of two updates of all points, or rounds of
    /// tiles (default: 10 for each row and column)
    #[arg(long, value_name = "N", help_heading = "Solver")]
    iterations: Option<u32>,
    /// Stop when no distance falls by more than this fraction in an iteration (default: 1e-6; in
    /// double precision 1e-13)
    #[arg(long, value_name = "T", help_heading = "Solver", allow_hyphen_values = true)]
    tolerance: Option<f64>,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum WavefrontArg {
    /// Curved; but anchored over floor plans from points, point on a surface with a slowness, for point
    /// sources that start together, and planar for fast marching
    #[default]
    Auto,
    /// Carries its curvature: the most accurate on smooth surfaces, around walls and from curves,
    /// in about twice the time of point
    Curved,
    /// Knows its anchor, the corner or source that it comes from on a straight line: exact, for point
    /// sources over floor plans only (flat, evenly spaced, with holes)
    Anchored,
    /// Circular: exact on developable surfaces but for the sampling, for point sources only
    Point,
    /// Straight: first-order accurate, as in the paper
    Planar,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum EngineArg {
    /// The first usable Vulkan device, else the CPU; for `pairwise` the CPU
    #[default]
    Auto,
    /// A Vulkan device, or an error
    Vulkan,
    /// Raster scans on the CPU
    Cpu,
    /// Fast marching on the CPU, the sequential reference for the planar front
    FastMarching,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum ScheduleArg {
    /// What is best on the device
    #[default]
    Auto,
    /// Scans over rows and columns, as in the paper
    Raster,
    /// All points at once: for tiny grids, and for comparison
    AllPoints,
    /// Tiles in the device's shared memory, where something has changed
    Tiles,
}

/// A device by its index or a part of its name.
pub fn device_choice(text: &str) -> DeviceChoice {
    match text.parse() {
        Ok(index) => DeviceChoice::Index(index),
        Err(_) => DeviceChoice::Name(text.to_owned()),
    }
}

impl SolverArgs {
    pub fn options(&self) -> Result<Options, String> {
        let stops = self.iterations.is_some() || self.tolerance.is_some();
        if self.engine == EngineArg::FastMarching && stops {
            return Err("--iterations and --tolerance are for engines that iterate, which fast \
                        marching does not; leave them out"
                .into());
        }
        Ok(Options {
            engine: self.engine()?,
            schedule: self.schedule()?,
            wavefront: match self.wavefront {
                WavefrontArg::Auto => None,
                WavefrontArg::Anchored => Some(Wavefront::Anchored),
                WavefrontArg::Curved => Some(Wavefront::Curved),
                WavefrontArg::Point => Some(Wavefront::PointSource),
                WavefrontArg::Planar => Some(Wavefront::Planar),
            },
            tolerance: self.tolerance,
            iterations: self.iterations,
        })
    }

    fn schedule(&self) -> Result<Option<Schedule>, String> {
        let schedule = match self.schedule {
            ScheduleArg::Auto => return Ok(None),
            ScheduleArg::Raster => Schedule::Raster,
            ScheduleArg::AllPoints => Schedule::AllPoints,
            ScheduleArg::Tiles => Schedule::Tiles,
        };
        match self.engine {
            EngineArg::Auto | EngineArg::Vulkan => Ok(Some(schedule)),
            EngineArg::Cpu | EngineArg::FastMarching => {
                Err("--schedule is for --engine vulkan; leave one of them out".into())
            }
        }
    }

    fn engine(&self) -> Result<Engine, String> {
        let device = self.device.as_deref().map(device_choice);
        match (self.engine, device) {
            (EngineArg::Auto | EngineArg::Vulkan, Some(device)) => Ok(Engine::Vulkan(device)),
            (_, Some(_)) => Err("--device is for --engine vulkan; leave one of them out".into()),
            (EngineArg::Auto, None) => Ok(Engine::Auto),
            (EngineArg::Vulkan, None) => Ok(Engine::Vulkan(DeviceChoice::Any)),
            (EngineArg::Cpu, None) => Ok(Engine::Cpu),
            (EngineArg::FastMarching, None) => Ok(Engine::FastMarching),
        }
    }
}
