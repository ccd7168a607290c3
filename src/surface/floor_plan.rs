//! Floor plans: planes with holes, where fronts are circles around sources and corners.

use glam::DVec3;

use super::{Geometry, Surface};

/// How far from the plane its points may lie, in parts of their extent: the rounding of files in single
/// precision.
const FLAT: f64 = 1e-6;

impl Surface {
    /// Whether the surface is a plane with holes and without a slowness, on which
    /// [`Wavefront::Arcs`](crate::Wavefront::Arcs) is as good as exact and the default.
    pub fn is_floor_plan(&self) -> bool {
        let has_holes = self.present().iter().any(|&present| !present);
        let is_metric = matches!(self.geometry(), Geometry::Metric(_));
        has_holes && !is_metric && self.slowness().is_none() && self.is_plane()
    }

    fn is_plane(&self) -> bool {
        let chart = self.chart();
        let every = |step: usize| {
            let places = (0..chart.points()).step_by(step).map(move |index| chart.position(index));
            places.filter_map(|(row, col)| self.position(row, col))
        };
        // Some thousand points tell the plane, if it is one.
        let step = (chart.points() / 4096) | 1;
        let Some(first) = every(step).next() else { return false };
        let farthest = |from: &dyn Fn(DVec3) -> DVec3| {
            let longer = |a: DVec3, b: DVec3| if b.length() > a.length() { b } else { a };
            every(step).map(|place| from(place - first)).fold(DVec3::ZERO, longer)
        };
        let along = farthest(&|way| way);
        let Some(direction) = along.try_normalize() else { return false };
        let across = farthest(&|way| way.reject_from_normalized(direction));
        let Some(normal) = direction.cross(across).try_normalize() else { return false };
        every(1).all(|place| (place - first).dot(normal).abs() <= FLAT * along.length())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Spacing;
    use crate::surface::builtin::Builtin;

    #[test]
    fn planes_with_holes_are_floor_plans() {
        assert!(Builtin::Maze.surface(33, 40).unwrap().is_floor_plan());
        let plane = Builtin::ShearedPlane { degrees: 60.0 }.surface(20, 30).unwrap();
        assert!(!plane.is_floor_plan());
        let mask: Vec<_> = (0..600).map(|index| index != 205).collect();
        assert!(plane.clone().with_mask(&mask).unwrap().is_floor_plan());
        let slow = plane.with_slowness(vec![2.0; 600]).unwrap().with_mask(&mask).unwrap();
        assert!(!slow.is_floor_plan());
    }

    #[test]
    fn slopes_are_planes_and_anything_rougher_is_not() {
        for (bump, flat) in [(0.0, true), (1e-7, true), (1e-3, false)] {
            let mut heights: Vec<f64> = (0..600).map(|i| 3.0 * f64::from(i % 30)).collect();
            heights[77] += bump;
            heights[100] = f64::NAN;
            let surface =
                Surface::from_heights(20, 30, heights, Spacing { dx: 1.0, dy: 2.0 }).unwrap();
            assert_eq!(surface.is_floor_plan(), flat, "{bump}");
        }
        let sphere = Builtin::Sphere.surface(20, 30).unwrap();
        let mask: Vec<_> = (0..600).map(|index| index != 205).collect();
        assert!(!sphere.with_mask(&mask).unwrap().is_floor_plan());
    }
}
