//! The kinds of objects, with a mark for each.

use super::contours::GeosweepContours;
use super::directions::GeosweepDirections;
use super::log_map::GeosweepLogMap;
use super::objects::Object;
use super::paths::GeosweepPaths;
use super::plan::GeosweepPlan;
use super::profile::GeosweepProfile;
use super::regions::GeosweepRegions;
use super::shared::Shared;
use super::solver::GeosweepSolver;
use super::surface::GeosweepSurface;

macro_rules! objects {
    ($($kind:ident: $mark:literal, $shared:expr;)*) => {$(
        impl Object for $kind {
            const NAME: &'static str = stringify!($kind);
            const MARK: u32 = $mark;

            fn shared(&self) -> &Shared {
                let shared: fn(&Self) -> &Shared = $shared;
                shared(self)
            }
        }
    )*};
}

objects! {
    GeosweepSolver: 0x6753_0001, |solver| solver.shared();
    GeosweepSurface: 0x6753_0002, |surface| &surface.shared;
    GeosweepPlan: 0x6753_0003, |plan| &plan.shared;
    GeosweepContours: 0x6753_0004, |contours| &contours.shared;
    GeosweepPaths: 0x6753_0005, |paths| &paths.shared;
    GeosweepRegions: 0x6753_0006, |regions| &regions.shared;
    GeosweepProfile: 0x6753_0007, |profile| &profile.shared;
    GeosweepDirections: 0x6753_0008, |directions| &directions.shared;
    GeosweepLogMap: 0x6753_0009, |log_map| &log_map.shared;
}
