//! Defines where maps end on a device: at a radius, or at targets.

use bytemuck::{Pod, Zeroable};

use super::VulkanError;
use super::setters::setters;
pub use crate::constants::MOST_TARGETS;
use crate::surface::Chart;

/// Grid point at which a map may end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Pod, Zeroable)]
#[repr(C)]
pub struct TargetPoint {
    /// Row, from 0 to rows - 1.
    pub row: u32,
    /// Column, from 0 to cols - 1.
    pub col: u32,
}

impl TargetPoint {
    /// Returns the target at a grid point.
    pub fn at(row: u32, col: u32) -> Self {
        Self { row, col }
    }
}

/// Part of the surface for which a map is solved. The distances in this part are those of the whole map. All
/// other points are unreached.
///
/// The work is about as much as for a surface of the size of this part. With tiles, a map ends after the round
/// in which the last needed target gets its distance. With raster scans, targets do not reduce the work, since
/// an iteration brings early and late fronts in any order. Only a radius reduces it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct MapLimit<'a> {
    /// Largest arrival time: a distance where sources start at 0. With +infinity there is no radius.
    pub radius: f32,
    /// Points whose distances are needed, at most [`MOST_TARGETS`]. Without any, the radius alone counts. If
    /// fewer targets can be reached than are needed, the map extends to the radius.
    pub targets: &'a [TargetPoint],
    /// Number of the nearest targets whose distances are needed. A number larger than the number of targets
    /// stands for all of them.
    pub needed: u32,
}

impl<'a> MapLimit<'a> {
    /// The whole map.
    pub const NONE: Self = Self { radius: f32::INFINITY, targets: &[], needed: u32::MAX };

    /// Returns the limit at a radius.
    pub fn at(radius: f32) -> Self {
        Self { radius, ..Self::NONE }
    }

    /// Returns the limit at all of the targets.
    pub fn to(targets: &'a [TargetPoint]) -> Self {
        Self { targets, ..Self::NONE }
    }

    setters! {
        with_radius(radius: f32);
        with_needed(needed: u32);
    }

    /// Returns whether there is a radius or a target.
    pub(crate) fn is_there(&self) -> bool {
        self.radius < f32::INFINITY || !self.targets.is_empty()
    }

    /// Checks the limit of a map on this grid.
    pub(crate) fn check(&self, chart: Chart) -> Result<(), VulkanError> {
        let fault = |reason: String| Err(VulkanError::Limit(reason));
        let Self { radius, targets, needed } = *self;
        if radius.is_nan() || radius <= 0.0 {
            return fault(format!("the radius {radius} is not positive"));
        }
        if targets.len() > MOST_TARGETS as usize {
            let given = targets.len();
            return fault(format!("{given} targets are more than {MOST_TARGETS}"));
        }
        if needed == 0 {
            return fault("none of the targets is needed; give at least 1".into());
        }
        let Chart { rows, cols } = chart;
        let is_off = |at: &&TargetPoint| at.row as usize >= rows || at.col as usize >= cols;
        match targets.iter().find(is_off) {
            Some(TargetPoint { row, col }) => {
                fault(format!("the target ({row}, {col}) is outside the {rows} x {cols} points"))
            }
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_that_cannot_be_are_refused() {
        let chart = Chart { rows: 8, cols: 9 };
        let many = vec![TargetPoint::at(1, 2); MOST_TARGETS as usize + 1];
        let off = [TargetPoint::at(7, 8), TargetPoint::at(8, 0)];
        for (limit, part) in [
            (MapLimit::at(0.0), "the radius 0 is not positive"),
            (MapLimit::at(f32::NAN), "the radius NaN is not positive"),
            (MapLimit::to(&many), "1025 targets are more than 1024"),
            (MapLimit::to(&off), "the target (8, 0) is outside the 8 x 9 points"),
            (MapLimit::to(&off[..1]).with_needed(0), "none of the targets is needed"),
        ] {
            let error = limit.check(chart).unwrap_err().to_string();
            assert!(error.contains(part), "{error}");
        }
        for limit in [MapLimit::NONE, MapLimit::at(1e-3), MapLimit::to(&off[..1])] {
            limit.check(chart).unwrap();
        }
        assert!(!MapLimit::NONE.is_there() && MapLimit::at(2.0).is_there());
        assert!(MapLimit::to(&off[..1]).is_there());
    }
}
