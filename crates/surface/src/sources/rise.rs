//! Computes the excess length of paths along the surface inside a cell over straight lines through space.

use glam::DVec2;

use crate::{Block, Cell, Direction, EdgeLengths, EdgeRule, Real, Surface, corner_weights};

/// The amount by which squared distances of a place in a cell from the cell's corners grow when edges are
/// measured along the surface instead of along chords.
///
/// Let p = sum of w_i p_i over the corners, with one corner at the origin. Then |p|^2 is the sum of w_i w_j
/// <p_i, p_j>, and 2 <p_i, p_j> = |p_i|^2 + |p_j|^2 - |p_i - p_j|^2. Both are linear in the squared lengths
/// of the edges. The shader `glsl/update/source_arrival.glsl` sums up these terms. Here only their growth is
/// summed up, since positions give chords more accurately.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rise {
    corners: [(usize, usize); 4],
    weights: [f64; 4],
    /// The growth of the squared length between any two corners.
    squares: [[f64; 4]; 4],
}

impl Rise {
    /// Returns the rise of a place, or `None` if edges are chords or cannot be measured.
    pub(super) fn at(surface: &Surface, cell: Cell, place: DVec2) -> Option<Self> {
        let corners = cell.corners();
        if surface.edge_rule() == EdgeRule::Chord || corners[0] == corners[3] {
            return None;
        }
        let there = corners.map(|(row, col)| surface.has(row, col));
        let weights = corner_weights(there, cell.inside(place))?;
        // The bends at the corners depend on points up to two rows and columns around.
        let Block { rows, cols } = surface.chart().around_span(cell.rows, cell.cols, [2, 2]);
        let around = surface.window(rows.clone(), cols.clone()).unweighted();
        let lengths = |rule| EdgeLengths::<f64>::new(&around.clone().with_edge_rule(rule)).ok();
        let (arcs, chords) = (lengths(EdgeRule::Arc)?, lengths(EdgeRule::Chord)?);
        let between = |a: (usize, usize), b: (usize, usize)| {
            let chart = surface.chart();
            let leads = |to: &Direction| chart.neighbour(a.0, a.1, *to) == Some(b);
            let to = Direction::ALL.into_iter().find(leads);
            let square = |edges: &EdgeLengths<f64>, to| {
                edges.length(a.0 - rows.start, a.1 - cols.start, to).powi(2)
            };
            to.map_or(0.0, |to| match (square(&arcs, to), square(&chords, to)) {
                (arc, _) if arc >= f64::FAR => 0.0,
                (arc, chord) => arc - chord,
            })
        };
        let squares = corners.map(|a| corners.map(|b| between(a, b)));
        Some(Self { corners, weights, squares })
    }

    /// Returns the growth of the squared distance from a corner of the cell, without slowness.
    pub(super) fn from(&self, corner: (usize, usize)) -> f64 {
        let Self { corners, weights, squares } = self;
        let Some(corner) = corners.iter().position(|&other| other == corner) else { return 0.0 };
        let to = |a: usize| weights[a] * squares[corner][a];
        let within = |a: usize| (0..4).map(|b| weights[b] * squares[a][b]).sum::<f64>();
        (0..4).map(|a| to(a) - 0.5 * weights[a] * within(a)).sum()
    }
}

#[cfg(test)]
mod tests {
    use crate::builtin::Builtin;
    use crate::{EdgeRule, Sources, Spacing, Surface};
    use glam::DVec3;

    /// The distances are known on a cylinder. The place itself lies on the bilinear patch.
    #[test]
    fn sources_between_points_of_a_cylinder_are_as_far_as_its_unrolled_plane_says() {
        let (radius, turn) = (1.0, 0.1);
        let point = |row: usize, col: usize| {
            let (sin, cos) = (turn * col as f64).sin_cos();
            DVec3::new(radius * cos, radius * sin, 0.1 * row as f64)
        };
        let positions = (0..64).map(|k| point(k / 8, k % 8)).collect();
        let surface = Surface::from_positions(8, 8, positions).unwrap();
        let error = |rule| {
            let surface = surface.clone().with_edge_rule(rule);
            let seeds = Sources::point(3.3, 4.5).seeds(&surface).unwrap();
            assert_eq!(seeds.len(), 4);
            let exact = |row: usize, col: usize| {
                (0.1 * (row as f64 - 3.3)).hypot(radius * turn * (col as f64 - 4.5))
            };
            let error = |seed: &crate::Seed| (seed.time / exact(seed.row, seed.col) - 1.0).abs();
            seeds.iter().map(error).fold(0.0, f64::max)
        };
        let (chord, arc) = (error(EdgeRule::Chord), error(EdgeRule::Arc));
        println!("chord {chord:e}, arc {arc:e}");
        assert!(chord > 3e-4 && arc < 1e-6, "chord {chord:e}, arc {arc:e}");
    }

    #[test]
    fn on_a_plane_nothing_is_longer() {
        let heights = (0..30).map(|k| (k / 6) as f64 * 0.7 + (k % 6) as f64 * 0.2).collect();
        let surface = Surface::from_heights(5, 6, heights, Spacing::square(1.0)).unwrap();
        for place in [[1.25, 2.5], [1.0, 2.5], [0.0, 4.75], [3.5, 5.0]] {
            let seeds = |rule| {
                let surface = surface.clone().with_edge_rule(rule);
                Sources::point(place[0], place[1]).seeds(&surface).unwrap()
            };
            for (a, b) in seeds(EdgeRule::Arc).iter().zip(&seeds(EdgeRule::Chord)) {
                approx::assert_relative_eq!(a.time, b.time, max_relative = 1e-14);
            }
        }
    }

    /// The surfaces include holes around the cell, borders and narrow grids.
    #[test]
    fn every_place_of_a_surface_has_a_rise_that_is_no_more_than_the_bend() {
        let mask: Vec<_> = (0..36).map(|k| k % 7 != 5).collect();
        let sphere = Builtin::Sphere.surface(6, 6).unwrap().with_mask(&mask).unwrap();
        let narrow = Builtin::Sphere.surface(2, 9).unwrap();
        let line = Builtin::Sphere.surface(1, 9);
        for surface in [sphere, narrow].into_iter().chain(line) {
            let steps = |points: usize| (0..=4 * (points - 1)).map(|k| 0.25 * k as f64);
            for row in steps(surface.rows()) {
                for col in steps(surface.cols()) {
                    let seeds = |rule| {
                        let surface = surface.clone().with_edge_rule(rule);
                        Sources::point(row, col).seeds(&surface)
                    };
                    let (Ok(arcs), Ok(chords)) = (seeds(EdgeRule::Arc), seeds(EdgeRule::Chord))
                    else {
                        continue;
                    };
                    assert_eq!(arcs.len(), chords.len());
                    for (arc, chord) in arcs.iter().zip(&chords) {
                        assert!(arc.time.is_finite() && arc.time >= 0.98 * chord.time);
                        assert!(arc.time <= 1.1 * chord.time, "{arc:?} {chord:?}");
                    }
                }
            }
        }
    }
}
