//! Defines the kinds of fronts ([`FrontOver`]) and selects the one for a surface. `kind.rs` and `lanes.rs` define their
//! interfaces to solvers. Each kind has a file. Code that kinds share has files of its own: `straight.rs` for planar
//! and circular fronts, `slowed.rs` for fronts over an uneven slowness, and `surface_array.rs` and `exchange.rs` for
//! all kinds.
//!
//! Solvers are written once, for any [`FrontKind`]. Functions that take a [`Wavefront`] use [`for_kind`],
//! which compiles a solver for each kind.

mod anchored;
mod circular;
mod curved;
pub(super) mod exchange;
mod kind;
mod lanes;
mod planar;
mod pulled;
mod rays;
mod slowed;
mod slowed_curved;
mod slowed_planar;
mod straight;
mod surface_array;

pub(super) use anchored::Anchored;
pub(super) use circular::Circular;
pub(super) use curved::Curved;
pub(super) use kind::{FrontKind, Fronts, PointKind, TriangleFronts, TriangleKind};
pub(super) use lanes::LaneKind;
pub(super) use planar::Planar;
pub(super) use pulled::{BATCH, MOST, Pulled, prefetch_rows};
pub(super) use rays::Rays;
pub(super) use slowed_curved::SlowedCurved;
pub(super) use slowed_planar::SlowedPlanar;
pub(super) use surface_array::SurfaceArray;

use geosweep_surface::update::{Setting, Wavefront};
use geosweep_surface::{EdgeLengths, Real};

/// A kind of front with the data that it needs of one surface.
#[expect(clippy::large_enum_variant, reason = "it is matched on at once")]
pub(super) enum FrontOver<R> {
    Planar(Planar),
    Circular(Circular),
    Curved(Curved<R>),
    Anchored(Anchored<R>),
    Rays(Rays<R>),
    SlowedPlanar(SlowedPlanar<R>),
    SlowedCurved(SlowedCurved<R>),
}

impl<R: Real> FrontOver<R> {
    /// Selects the kind of front that computes `wavefront` on the surface with these edges. Curved fronts replace kinds
    /// that the surface does not allow.
    pub(super) fn new(edges: &EdgeLengths<R>, wavefront: Wavefront) -> Self {
        let floor = edges.floor();
        if let Some(slowness) = edges.shared_slowness() {
            return match wavefront {
                Wavefront::Planar => Self::SlowedPlanar(SlowedPlanar::new(slowness)),
                // Rays bend where the slowness varies, so circular and anchored fronts, which assume straight rays,
                // become curved ones.
                _ => Self::SlowedCurved(SlowedCurved::new(edges, slowness)),
            };
        }
        match (wavefront.or_curved(Setting::of_engine(floor.is_some())), floor) {
            (Wavefront::Planar, _) => Self::Planar(Planar),
            (Wavefront::Circular, _) => Self::Circular(Circular::new(edges)),
            (Wavefront::Anchored, Some(grid)) => Self::Anchored(Anchored::new(edges, grid)),
            (Wavefront::Rays, _) => Self::Rays(Rays::new(edges)),
            (Wavefront::Anchored | Wavefront::Curved, _) => Self::Curved(Curved::new(edges)),
        }
    }
}

/// Evaluates `$solve`, compiled once for each kind, with the kind of front for a wavefront on a surface:
/// `for_kind!(edges, wavefront, kind => ..)`.
macro_rules! for_kind {
    ($edges:expr, $wavefront:expr, $kind:ident => $solve:expr) => {
        match $crate::fronts::FrontOver::new($edges, $wavefront) {
            $crate::fronts::FrontOver::Planar($kind) => $solve,
            $crate::fronts::FrontOver::Circular($kind) => $solve,
            $crate::fronts::FrontOver::Curved($kind) => $solve,
            $crate::fronts::FrontOver::Anchored($kind) => $solve,
            $crate::fronts::FrontOver::Rays($kind) => $solve,
            $crate::fronts::FrontOver::SlowedPlanar($kind) => $solve,
            $crate::fronts::FrontOver::SlowedCurved($kind) => $solve,
        }
    };
}
pub(super) use for_kind;

/// Evaluates `$solve` as [`for_kind`] does, for solvers that need a [`TriangleKind`]. Curved fronts replace anchored
/// ones.
macro_rules! for_triangle_kind {
    ($edges:expr, $wavefront:expr, $kind:ident => $solve:expr) => {
        match $crate::fronts::FrontOver::new($edges, $wavefront) {
            $crate::fronts::FrontOver::Planar($kind) => $solve,
            $crate::fronts::FrontOver::Circular($kind) => $solve,
            $crate::fronts::FrontOver::Curved($kind) => $solve,
            $crate::fronts::FrontOver::Rays($kind) => $solve,
            $crate::fronts::FrontOver::SlowedPlanar($kind) => $solve,
            $crate::fronts::FrontOver::SlowedCurved($kind) => $solve,
            $crate::fronts::FrontOver::Anchored(_) => {
                let $kind = $crate::fronts::Curved::new($edges);
                $solve
            }
        }
    };
}
pub(super) use for_triangle_kind;
