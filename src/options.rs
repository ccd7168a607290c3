//! Holds the options of maps, and checks them.

use crate::surface::{Sources, Surface};
use crate::update::{EngineKind, Setting, SourceKind, Wavefront};
#[cfg(feature = "vulkan")]
use crate::vulkan::Schedule;
use crate::{Engine, Error, Monitor, Stop, Targets};

/// Rounding of distances, as a fraction: a distance that exceeds the radius by less lies within it.
const ROUNDING: f64 = 1e-6;

/// Options of a map. The default suits most surfaces.
///
/// ```
/// use geosweep::{Engine, Options, Wavefront};
///
/// let options = Options::default().with_engine(Engine::Cpu).with_wavefront(Wavefront::Curved);
/// assert_eq!(options.wavefront, Some(Wavefront::Curved));
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Options {
    /// The engine that computes the map.
    pub engine: Engine,
    /// The wavefront assumed inside a triangle. With `None` it is chosen as follows:
    ///
    /// - [`Wavefront::Anchored`] over floor plans ([`Surface::is_floor_plan`]) from points, where it is
    ///   exact;
    /// - [`Wavefront::Planar`] on surfaces that turn at random, on surfaces whose slowness jumps in many
    ///   places, and for fast marching;
    /// - [`Wavefront::Rays`] on the CPU where fronts may meet: from several sources or curves, and on closed surfaces.
    ///   Exceptions are an uneven slowness, and open surfaces whose cells are all alike and of which none is missing,
    ///   where curved fronts are exact;
    /// - [`Wavefront::Curved`] elsewhere, also over a slowness. It is the most accurate one on smooth
    ///   surfaces and from curves, and as good as the circular one on rough terrain.
    ///
    /// A map with curved fronts takes about twice the time of one with circular fronts. A map with anchors
    /// takes less time than one with curved fronts.
    pub wavefront: Option<Wavefront>,
    /// The order of updates on a Vulkan device. It makes no difference to the map. With `None` it is
    /// [`Schedule::best_on`] the device. The CPU engines have one order each.
    #[cfg(feature = "vulkan")]
    pub schedule: Option<Schedule>,
    /// Relative change below which iterations stop: no arrival time fell by more than this fraction in an iteration.
    /// With `None` it is [`crate::DEFAULT_TOLERANCE`], or [`crate::DEFAULT_TOLERANCE_F64`] in double precision.
    pub tolerance: Option<f64>,
    /// Maximum number of iterations of four scans. With `None` it is ten for each row and column, more than
    /// any surface but a labyrinth needs.
    pub iterations: Option<u32>,
    /// Largest distance of the map, in its unit, up to a millionth. Points that are farther are unreached: their distance
    /// is +infinity. Distances within the radius are those of the whole map. With `None` or +infinity there is no
    /// limit. The work is proportional to the area within the radius, except for measuring the surface.
    pub radius: Option<f64>,
    /// The targets of the map. The map ends when no front can reach them earlier, and points that are farther are
    /// unreached. On the CPU, and by tiles on a device, the work is about that of a map with the radius that the
    /// targets need. If a needed target cannot be reached, the whole map is computed, and the distance of that target
    /// is +infinity.
    pub targets: Option<Targets>,
    /// The monitor by which another thread follows the computation and may cancel it.
    pub monitor: Option<Monitor>,
}

impl Options {
    /// Sets [`Options::engine`].
    pub fn with_engine(self, engine: Engine) -> Self {
        Self { engine, ..self }
    }

    /// Sets [`Options::wavefront`].
    pub fn with_wavefront(self, wavefront: impl Into<Option<Wavefront>>) -> Self {
        Self { wavefront: wavefront.into(), ..self }
    }

    /// Sets [`Options::schedule`].
    #[cfg(feature = "vulkan")]
    pub fn with_schedule(self, schedule: impl Into<Option<Schedule>>) -> Self {
        Self { schedule: schedule.into(), ..self }
    }

    /// Sets [`Options::tolerance`].
    pub fn with_tolerance(self, tolerance: impl Into<Option<f64>>) -> Self {
        Self { tolerance: tolerance.into(), ..self }
    }

    /// Sets [`Options::iterations`].
    pub fn with_iterations(self, iterations: impl Into<Option<u32>>) -> Self {
        Self { iterations: iterations.into(), ..self }
    }

    /// Sets [`Options::radius`].
    ///
    /// ```
    /// use geosweep::{Options, Sources, Spacing, Surface, distance_map};
    ///
    /// let surface = Surface::from_heights(40, 50, vec![0.0; 2000], Spacing::square(1.0))?;
    /// let options = Options::default().with_radius(5.0);
    /// let map = distance_map(&surface, &Sources::point(20.0, 20.0), &options)?;
    /// assert!(map.distance(24, 23) == 5.0 && map.distance(24, 24).is_infinite());
    /// # Ok::<(), geosweep::Error>(())
    /// ```
    pub fn with_radius(self, radius: impl Into<Option<f64>>) -> Self {
        Self { radius: radius.into(), ..self }
    }

    /// Sets [`Options::targets`].
    pub fn with_targets(self, targets: impl Into<Option<Targets>>) -> Self {
        Self { targets: targets.into(), ..self }
    }

    /// Sets the monitor of a computation.
    ///
    /// ```
    /// use geosweep::{Error, Monitor, Options, Sources, Spacing, Surface, distance_map};
    ///
    /// let surface = Surface::from_heights(40, 50, vec![0.0; 2000], Spacing::square(1.0))?;
    /// let monitor = Monitor::default();
    /// let options = Options::default().with_monitor(monitor.clone());
    /// distance_map(&surface, &Sources::point(3.0, 4.0), &options)?;
    /// assert!(monitor.progress().iterations >= 1);
    ///
    /// monitor.cancel();
    /// let cancelled = distance_map(&surface, &Sources::point(3.0, 4.0), &options);
    /// assert!(matches!(cancelled, Err(Error::Cancelled)));
    /// # Ok::<(), geosweep::Error>(())
    /// ```
    pub fn with_monitor(self, monitor: impl Into<Option<Monitor>>) -> Self {
        Self { monitor: monitor.into(), ..self }
    }

    /// Returns the monitor, or a new one if none is set.
    pub(crate) fn monitor(&self) -> Monitor {
        self.monitor.clone().unwrap_or_default()
    }

    /// Returns the rule by which iterations stop. `tolerance` is the default of the precision.
    pub(crate) fn stop(&self, surface: &Surface, tolerance: f64) -> Result<Stop, Error> {
        let tolerance = self.tolerance.unwrap_or(tolerance);
        if !(0.0..1.0).contains(&tolerance) {
            let message = format!("tolerance {tolerance} is not in the range from 0 to 1");
            return Err(Error::Options(message));
        }
        let stop = Stop::settled(surface, tolerance);
        let iterations = self.iterations.unwrap_or(stop.iterations);
        if iterations == 0 {
            return Err(Error::Options("at least one iteration is needed".into()));
        }
        Ok(stop.or_after(iterations))
    }

    /// Returns the largest distance within the radius, or +infinity if none is set. A distance that is the radius but for
    /// rounding lies within it.
    pub(crate) fn checked_radius(&self) -> Result<f64, Error> {
        let radius = self.radius.unwrap_or(f64::INFINITY);
        if radius > 0.0 {
            return Ok(radius * (1.0 + ROUNDING));
        }
        let message =
            format!("the radius {radius} is not a positive number; leave it out for no limit");
        Err(Error::Options(message))
    }

    /// Returns an error if an option is set that rows of a distance matrix do not support.
    pub(crate) fn check_for_rows(&self) -> Result<(), Error> {
        let fault = |message: &str| Err(Error::Options(message.into()));
        #[cfg(feature = "vulkan")]
        if self.schedule.is_some() {
            return fault(
                "a schedule is for single maps; the rows of a matrix have one order of updates on \
                 each engine, leave the schedule out",
            );
        }
        if self.targets.is_some() {
            return fault(
                "targets are for single maps; leave them out, or compute rows within a radius",
            );
        }
        Ok(())
    }

    /// Returns the targets, or an error if a target is not a point of the surface.
    pub(crate) fn checked_targets(&self, surface: &Surface) -> Result<Option<Targets>, Error> {
        let Some(targets) = &self.targets else { return Ok(None) };
        let fault = |message: String| Err(Error::Options(message));
        if targets.points().is_empty() {
            return fault("there is no target; leave the targets out for the whole map".into());
        }
        let (rows, cols) = (surface.rows(), surface.cols());
        for &[row, col] in targets.points() {
            if row >= rows || col >= cols {
                return fault(format!(
                    "the target ({row}, {col}) is outside the grid of {rows} x {cols} points"
                ));
            }
            if !surface.has(row, col) {
                return fault(format!(
                    "the target ({row}, {col}) is in a hole; choose a point of the surface"
                ));
            }
        }
        Ok(Some(targets.clone()))
    }

    /// Returns the wavefront of a map.
    pub(crate) fn resolve_wavefront(
        &self,
        surface: &Surface,
        sources: &Sources,
    ) -> Result<Wavefront, Error> {
        self.wavefront_of(surface, SourceKind::of(sources))
    }

    /// Returns the wavefront of a map from sources of a known kind.
    pub(crate) fn wavefront_of(
        &self,
        surface: &Surface,
        sources: SourceKind,
    ) -> Result<Wavefront, Error> {
        let engine = match self.engine {
            Engine::FastMarching => EngineKind::FastMarching,
            #[cfg(feature = "vulkan")]
            Engine::Vulkan(_) => EngineKind::MapOnDevice,
            // A schedule is for a device.
            #[cfg(feature = "vulkan")]
            Engine::Auto if self.schedule.is_some() => EngineKind::MapOnDevice,
            _ => EngineKind::Map,
        };
        let setting = Setting::new(surface, sources, engine);
        Ok(Wavefront::resolve(self.wavefront, setting)?)
    }

    /// Returns the wavefront of the rows of a distance matrix.
    pub(crate) fn wavefront_of_rows(&self, surface: &Surface) -> Result<Wavefront, Error> {
        let engine = match self.engine {
            Engine::FastMarching => EngineKind::FastMarching,
            Engine::Auto | Engine::Cpu => EngineKind::Matrix,
            #[cfg(feature = "vulkan")]
            Engine::Vulkan(_) => EngineKind::MatrixOnDevice,
        };
        let setting = Setting::new(surface, SourceKind::POINT, engine);
        Ok(Wavefront::resolve(self.wavefront, setting)?)
    }
}
