//! Defines the kinds of fronts, and selects the one for a map. No other module makes this choice.

use std::fmt;
use std::str::FromStr;

use crate::constants::{self, SOURCES_INSIDE};
use crate::name::{UnknownName, by_name};
use crate::{Sources, Surface};

/// The shape of the front that an update assumes inside a triangle. The numbers of the kinds are those of
/// `WAVEFRONT` in `glsl/update/wavefront.glsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(i32)]
pub enum Wavefront {
    /// A straight front (paper, section 3). It is first-order accurate, also for extended sources.
    Planar = constants::PLANAR as i32,
    /// A circular front around a virtual point source, for maps of a single point source. It is exact on
    /// developable surfaces except for the sampling, and second-order accurate elsewhere. Maps of several
    /// sources or over an uneven slowness are solved with [`Self::Curved`] instead, and their report says so:
    /// circular fronts do not tell to which source they belong where they meet. Fast marching, which updates
    /// in one order, keeps them for several sources.
    Circular = constants::CIRCULAR as i32,
    /// A front that carries its curvature beside the arrival time. It is second-order accurate on curved
    /// surfaces, also around holes and for extended sources. Maps on the CPU are solved with [`Self::Rays`] instead
    /// where fronts may meet, and their report says so.
    Curved = constants::CURVED as i32,
    /// A front that carries its anchor, the corner or source from which it comes on a straight line, in place
    /// of its curvature. From point sources it is exact over floor plans ([`crate::Surface::is_floor_plan`]).
    /// On other surfaces and from curves it is refused. Engines that are given the edges of another surface
    /// solve as [`Self::Curved`].
    Anchored = constants::ANCHORED as i32,
    /// A front that carries its curvature, the direction of its ray, and the number of its source, for maps on the
    /// CPU. Where fronts of several sources meet, or a front meets itself, each goes on alone. Elsewhere it is as
    /// accurate as [`Self::Curved`], and takes three to six times as long. Maps of several sources, from curves and
    /// on closed surfaces have these fronts, unless all cells are alike and none is missing. Over an uneven slowness,
    /// maps are solved with [`Self::Curved`] instead, and their report says so.
    Rays = 4,
}

impl Wavefront {
    /// The wavefronts that suit any surface and engine.
    pub const FOR_ANY_SURFACE: [Self; 3] = [Self::Planar, Self::Circular, Self::Curved];
    /// All wavefronts.
    pub const ALL: [Self; 5] =
        [Self::Planar, Self::Circular, Self::Curved, Self::Anchored, Self::Rays];

    /// Returns whether fronts carry their curvature.
    pub fn is_curved(self) -> bool {
        self == Self::Curved
    }

    /// Returns whether fronts carry a value beside their arrival time.
    #[doc(hidden)]
    pub fn has_two_layers(self) -> bool {
        matches!(self, Self::Curved | Self::Anchored)
    }

    /// Returns the name that the tool and reports use.
    pub fn name(self) -> &'static str {
        match self {
            Self::Planar => "planar",
            Self::Circular => "circular",
            Self::Curved => "curved",
            Self::Anchored => "anchored",
            Self::Rays => "rays",
        }
    }

    /// Returns the wavefront of a map: the requested one, or by default the best one in this setting.
    ///
    /// # Errors
    /// If the requested wavefront does not suit the setting.
    #[doc(hidden)]
    pub fn resolve(asked: Option<Self>, setting: Setting) -> Result<Self, Unsuited> {
        let Setting { is_rough, is_slowed_unevenly, sources, engine, .. } = setting;
        let from_curves = sources == SourceKind::Curves;
        match asked {
            Some(Self::Anchored) => setting.has_anchors().map(|()| Self::Anchored),
            Some(Self::Rays) if is_slowed_unevenly => Ok(Self::Curved),
            Some(Self::Rays) if engine.is_device() => Err(Unsuited::RaysOnDevice),
            Some(Self::Circular) if from_curves => Err(Unsuited::CircularFromCurves),
            // Circular fronts do not tell from which source they come. Where fronts of several sources meet,
            // or where a front that a slowness bends meets itself, the result would depend on the order of
            // updates. Fast marching has only one order. Matrices with a constant slowness keep circular
            // fronts for their speed; where rays bend, circles have no centre.
            Some(Self::Circular)
                if sources.are_several() && engine != EngineKind::FastMarching
                    || is_slowed_unevenly =>
            {
                Ok(if setting.has_rays() { Self::Rays } else { Self::Curved })
            }
            // Where fronts meet, a curvature alone does not tell them apart.
            Some(Self::Curved) if setting.has_rays() => Ok(Self::Rays),
            Some(wavefront) => Ok(wavefront),
            None if engine == EngineKind::FastMarching => Ok(Self::Planar),
            None if setting.is_map() && setting.are_straight => Ok(Self::Curved),
            None if setting.is_map() && setting.has_anchors().is_ok() => Ok(Self::Anchored),
            None if is_rough => Ok(Self::Planar),
            None if setting.has_rays() => Ok(Self::Rays),
            None => Ok(Self::Curved),
        }
    }

    /// Returns the default wavefront for a setting.
    #[doc(hidden)]
    pub fn chosen(setting: Setting) -> Self {
        Self::resolve(None, setting).unwrap_or(Self::Curved)
    }

    /// Returns the curved wavefront in place of [`Self::Rays`].
    #[doc(hidden)]
    pub fn without_rays(self) -> Self {
        if self == Self::Rays { Self::Curved } else { self }
    }

    /// Returns the wavefront with which an engine solves if it accepts any request: this one, or the curved
    /// one if this one does not suit the setting.
    #[doc(hidden)]
    pub fn or_curved(self, setting: Setting) -> Self {
        Self::resolve(Some(self), setting).unwrap_or(Self::Curved)
    }
}

impl fmt::Display for Wavefront {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Parses the [`name`](Wavefront::name) of a wavefront. `point` is an older name of the circular one.
///
/// ```
/// use geosweep::Wavefront;
/// assert_eq!("circular".parse(), Ok(Wavefront::Circular));
/// assert_eq!("point".parse(), Ok(Wavefront::Circular));
/// let error = "round".parse::<Wavefront>().unwrap_err();
/// let expected = "no wavefront is called `round`; there are planar, circular, curved, anchored, rays";
/// assert_eq!(error.to_string(), expected);
/// ```
impl FromStr for Wavefront {
    type Err = UnknownName;

    fn from_str(text: &str) -> Result<Self, UnknownName> {
        let text = if text.trim() == "point" { Self::Circular.name() } else { text };
        by_name("wavefront", text, &Self::ALL, |wavefront| wavefront.name())
    }
}

/// The facts on which the choice of a wavefront depends.
#[derive(Clone, Copy, Debug)]
#[doc(hidden)]
pub struct Setting {
    /// Whether the surface is known to be a floor plan ([`Surface::is_floor_plan`]).
    pub is_floor_plan: bool,
    /// Whether the surface turns at random from point to point ([`crate::Resolution::is_rough`]).
    pub is_rough: bool,
    /// Whether the surface has a slowness that is not the same everywhere.
    pub is_slowed_unevenly: bool,
    /// Whether fronts of several sources, or a front and itself, may meet on the surface, and straight lines do not tell
    /// them apart.
    pub fronts_meet: bool,
    /// Whether such fronts run along straight lines of the chart: all cells are alike, and no point is missing.
    pub are_straight: bool,
    pub sources: SourceKind,
    pub engine: EngineKind,
}

/// The kind of sources of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[doc(hidden)]
pub enum SourceKind {
    /// Points. Some of them may lie inside cells.
    Points { single: bool, inside_cells: usize },
    /// Curves, possibly with points.
    Curves,
}

impl SourceKind {
    /// A single grid point.
    #[doc(hidden)]
    pub const POINT: Self = Self::Points { single: true, inside_cells: 0 };

    #[doc(hidden)]
    pub fn of(sources: &Sources) -> Self {
        if !sources.are_points() {
            return Self::Curves;
        }
        let (single, inside_cells) = (sources.iter().count() == 1, sources.inside_cells());
        Self::Points { single, inside_cells }
    }

    /// Returns the kind of these sources if others will be added to them.
    #[doc(hidden)]
    pub fn several(sources: &Sources) -> Self {
        match Self::of(sources) {
            Self::Points { inside_cells, .. } => Self::Points { single: false, inside_cells },
            Self::Curves => Self::Curves,
        }
    }

    fn are_several(self) -> bool {
        !matches!(self, Self::Points { single: true, .. })
    }
}

/// The kind of engine that solves a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EngineKind {
    /// Single maps on the CPU.
    Map,
    /// Single maps on a device, where fronts do not carry their ray.
    MapOnDevice,
    /// Fast marching.
    FastMarching,
    /// The rows of a distance matrix on the CPU. They are solved map by map where fronts carry a value.
    Matrix,
    /// The rows of a distance matrix on a device, where fronts have no anchors.
    MatrixOnDevice,
}

impl EngineKind {
    fn is_device(self) -> bool {
        matches!(self, Self::MapOnDevice | Self::MatrixOnDevice)
    }
}

/// Largest distance in rows and columns of points that split triangles on surfaces where fronts carry their ray.
const SKEWED_MOST: usize = 2;

impl Setting {
    /// Makes the setting of a map of a surface.
    #[doc(hidden)]
    pub fn new(surface: &Surface, sources: SourceKind, engine: EngineKind) -> Self {
        let is_floor_plan = surface.is_floor_plan();
        let is_rough = surface.resolution().is_some_and(|resolution| resolution.is_rough());
        let is_slowed_unevenly = surface.is_slowed_unevenly();
        let meet = sources.are_several() || surface.is_glued();
        // In the thin cells around a pole, rays that leave a curve come up to a cell early.
        let from_beside_pole = sources == SourceKind::Curves && surface.has_poles();
        let are_straight = meet && surface.is_whole() && surface.has_even_cells();
        // Where points that split triangles lie far away, rays come early, and do not settle.
        let fronts_meet = meet
            && !(is_slowed_unevenly || from_beside_pole)
            && !(are_straight || surface.has_skewed_cells(SKEWED_MOST));
        Self {
            is_floor_plan,
            is_rough,
            is_slowed_unevenly,
            fronts_meet,
            are_straight,
            sources,
            engine,
        }
    }

    /// Makes the setting of an engine that is given edges and seeds. Such an engine knows nothing of the
    /// surface but whether it is a floor plan.
    #[doc(hidden)]
    pub fn of_engine(is_floor_plan: bool) -> Self {
        Self {
            is_floor_plan,
            is_rough: false,
            is_slowed_unevenly: false,
            fronts_meet: false,
            are_straight: false,
            sources: SourceKind::POINT,
            engine: EngineKind::Map,
        }
    }

    /// Makes the setting of [`Self::of_engine`] for an engine on a device.
    #[doc(hidden)]
    pub fn of_device(is_floor_plan: bool) -> Self {
        Self { engine: EngineKind::MapOnDevice, ..Self::of_engine(is_floor_plan) }
    }

    /// Returns whether fronts carry their ray in place of their curvature alone.
    fn has_rays(self) -> bool {
        self.engine == EngineKind::Map && self.fronts_meet
    }

    fn is_map(self) -> bool {
        matches!(self.engine, EngineKind::Map | EngineKind::MapOnDevice)
    }

    /// Returns an error for surfaces, sources and engines for which fronts have no anchors.
    fn has_anchors(self) -> Result<(), Unsuited> {
        match self.sources {
            _ if !self.is_floor_plan => Err(Unsuited::NoFloorPlan),
            _ if self.engine == EngineKind::MatrixOnDevice => Err(Unsuited::AnchoredMatrixOnDevice),
            SourceKind::Curves => Err(Unsuited::AnchoredFromCurves),
            SourceKind::Points { inside_cells, .. } if inside_cells > SOURCES_INSIDE as usize => {
                Err(Unsuited::TooManyInside)
            }
            SourceKind::Points { .. } => Ok(()),
        }
    }
}

/// The reason why a wavefront does not suit a setting, with advice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[doc(hidden)]
pub enum Unsuited {
    #[error(
        "the circular wavefront needs point sources; use the curved or the planar one for curves"
    )]
    CircularFromCurves,
    #[error(
        "the anchored wavefront is for floor plans: flat surfaces whose points are evenly spaced, without \
         obtuse triangles and without a slowness; use the curved one for other surfaces"
    )]
    NoFloorPlan,
    #[error(
        "the anchored wavefront needs point sources; use the curved or the planar one for curves"
    )]
    AnchoredFromCurves,
    #[error(
        "the anchored wavefront is for up to {} sources that are not at grid points; round them to grid \
         points, or use the curved one",
        SOURCES_INSIDE
    )]
    TooManyInside,
    #[error(
        "the rows of a matrix have no anchored fronts on a Vulkan device; compute them on the CPU, or use \
         curved fronts"
    )]
    AnchoredMatrixOnDevice,
    #[error("the rays wavefront runs on the CPU only; use the engine cpu, or curved fronts")]
    RaysOnDevice,
}

#[cfg(test)]
mod tests {
    use super::*;
    use Wavefront::*;

    const CURVES: SourceKind = SourceKind::Curves;

    fn resolved(
        asked: impl Into<Option<Wavefront>>,
        setting: Setting,
    ) -> Result<Wavefront, Unsuited> {
        Wavefront::resolve(asked.into(), setting)
    }

    #[test]
    fn the_best_wavefront_is_chosen_where_none_is_asked_for() {
        let any = Setting::of_engine(false);
        let apart = SourceKind::Points { single: false, inside_cells: 0 };
        let slow = Setting { is_slowed_unevenly: true, ..any };
        assert_eq!(resolved(None, any), Ok(Curved));
        assert_eq!(resolved(None, slow), Ok(Curved));
        assert_eq!(resolved(None, Setting { sources: apart, ..slow }), Ok(Curved));
        assert_eq!(resolved(None, Setting { sources: CURVES, ..slow }), Ok(Curved));
        let meet = Setting { fronts_meet: true, ..any };
        assert_eq!(resolved(None, meet), Ok(Rays));
        assert_eq!(resolved(Curved, meet), Ok(Rays));
        assert_eq!(resolved(Circular, Setting { sources: apart, ..meet }), Ok(Rays));
        assert_eq!(resolved(None, Setting { is_rough: true, ..meet }), Ok(Planar));
        for engine in [EngineKind::MapOnDevice, EngineKind::Matrix, EngineKind::MatrixOnDevice] {
            assert_eq!(resolved(None, Setting { engine, ..meet }), Ok(Curved));
        }
        let rough = Setting { is_rough: true, ..slow };
        assert_eq!(resolved(None, rough), Ok(Planar));
        assert_eq!(resolved(Curved, rough), Ok(Curved));
        let floor = Setting::of_engine(true);
        assert_eq!(resolved(None, floor), Ok(Anchored));
        assert_eq!(resolved(None, Setting { sources: CURVES, ..floor }), Ok(Curved));
        for (engine, expected) in [
            (EngineKind::FastMarching, Planar),
            (EngineKind::Matrix, Curved),
            (EngineKind::MatrixOnDevice, Curved),
        ] {
            assert_eq!(resolved(None, Setting { engine, ..floor }), Ok(expected));
        }
    }

    #[test]
    fn requested_wavefronts_are_kept_or_refused() {
        let floor = Setting::of_engine(true);
        for wavefront in Wavefront::ALL {
            for engine in [EngineKind::Map, EngineKind::FastMarching, EngineKind::Matrix] {
                assert_eq!(resolved(wavefront, Setting { engine, ..floor }), Ok(wavefront));
            }
        }
        let inside = |inside_cells| SourceKind::Points { single: true, inside_cells };
        let most = SOURCES_INSIDE as usize;
        assert_eq!(resolved(Anchored, Setting { sources: inside(most), ..floor }), Ok(Anchored));
        for (refused, setting) in [
            (Unsuited::NoFloorPlan, Setting::of_engine(false)),
            (Unsuited::AnchoredFromCurves, Setting { sources: CURVES, ..floor }),
            (Unsuited::TooManyInside, Setting { sources: inside(most + 1), ..floor }),
            (
                Unsuited::AnchoredMatrixOnDevice,
                Setting { engine: EngineKind::MatrixOnDevice, ..floor },
            ),
        ] {
            assert_eq!(resolved(Anchored, setting), Err(refused));
            assert_eq!(Anchored.or_curved(setting), Curved);
        }
        let curves = Setting { sources: CURVES, ..floor };
        assert_eq!(resolved(Circular, curves), Err(Unsuited::CircularFromCurves));
        assert_eq!(resolved(Planar, curves), Ok(Planar));
        let slow =
            |engine| Setting { is_slowed_unevenly: true, engine, ..Setting::of_engine(false) };
        assert_eq!(resolved(Rays, slow(EngineKind::Map)), Ok(Curved));
        for engine in [EngineKind::MapOnDevice, EngineKind::MatrixOnDevice] {
            let setting = Setting { engine, ..floor };
            assert_eq!(resolved(Rays, setting), Err(Unsuited::RaysOnDevice));
            assert_eq!(Rays.or_curved(setting), Curved);
        }
        let several = SourceKind::Points { single: false, inside_cells: 0 };
        let with = |engine| Setting { sources: several, engine, ..floor };
        assert_eq!(resolved(Circular, with(EngineKind::Map)), Ok(Curved));
        assert_eq!(resolved(Circular, with(EngineKind::FastMarching)), Ok(Circular));
        for engine in [EngineKind::Map, EngineKind::Matrix, EngineKind::FastMarching] {
            assert_eq!(resolved(Circular, slow(engine)), Ok(Curved));
        }
    }
}
