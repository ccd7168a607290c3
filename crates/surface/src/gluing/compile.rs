//! Finds the grid points that a gluing joins, and checks that they coincide.

use std::borrow::Cow;
use std::collections::HashMap;

use glam::DVec3;

use super::super::geometry::Geometry;
use super::super::seams::{COINCIDENT, Rim, spread};
use super::super::{Chart, Direction, GridSide, MetricTensor, Seam, Surface, SurfaceError};
use super::lattice::Lattice;
use super::{Gluing, GluingError, Run};

/// Smallest number of lines that a grid may have across a seam.
const LEAST_LINES: usize = 4;

/// The pairs of points that a gluing joins, by their row-major indices.
pub(super) struct Compiled {
    pub pairs: Vec<[usize; 2]>,
    pub lattice: Lattice,
}

/// Returns the pairs of points that a seam joins, holes included.
pub(in super::super) fn pairs_of(
    chart: Chart,
    seam: &Seam,
) -> Result<Vec<[usize; 2]>, GluingError> {
    let indices = |side: GridSide| -> Vec<usize> {
        side.places(chart).map(|(row, col)| chart.index(row, col)).collect()
    };
    let paired = |a: Vec<usize>, b: Vec<usize>| a.into_iter().zip(b).map(|(a, b)| [a, b]).collect();
    match *seam {
        Seam::Sides { sides, reversed } | Seam::Neighbours { sides, reversed } => {
            let [a, mut b] = sides.map(indices);
            if a.len() != b.len() {
                return Err(GluingError::Lengths { sides, points: [a.len(), b.len()] });
            }
            if reversed {
                b.reverse();
            }
            Ok(paired(a, b))
        }
        Seam::Fold(side) => {
            let (there, half) = (indices(side), indices(side).len() / 2);
            let back = there.iter().rev().copied().collect();
            Ok(paired(there[..half].to_vec(), back))
        }
        Seam::Pole { side, .. } => {
            let points = indices(side);
            Ok(points[1..].iter().map(|&point| [points[0], point]).collect())
        }
        // The pole is not a grid point.
        Seam::Ring(_) => Ok(Vec::new()),
    }
}

impl Compiled {
    /// Compiles a gluing whose pairs follow from the grid's size. Returns `None` for [`Gluing::Charts`], whose pairs
    /// follow from positions.
    pub(super) fn on_grid(chart: Chart, gluing: &Gluing) -> Result<Option<Self>, GluingError> {
        let compiled = match gluing {
            Gluing::Seams(_) | Gluing::Octahedral => Self::of_seams(chart, &gluing.seams())?,
            Gluing::Runs(runs) => {
                Self { pairs: pairs_of_runs(chart, runs)?, lattice: Lattice::default() }
            }
            Gluing::Charts => return Ok(None),
        };
        Ok(Some(compiled))
    }

    fn of_seams(chart: Chart, seams: &[Seam]) -> Result<Self, GluingError> {
        let Chart { rows, cols } = chart;
        let mut compiled = Self { pairs: Vec::new(), lattice: Lattice::default() };
        for (number, seam) in seams.iter().enumerate() {
            if let Seam::Neighbours { .. } | Seam::Ring(_) = seam {
                return Err(GluingError::Unsupported {
                    what: "a seam whose line the grid lacks",
                    instead: "surface::CompletedGrid adds it, or append the line to the grid",
                });
            }
            let pairs = pairs_of(chart, seam)?;
            if seams[..number].contains(seam) {
                return Err(twice(chart, pairs[0]));
            }
            let lattice = Lattice::of(seam);
            let is_small = lattice.cols.is_some() && cols < LEAST_LINES
                || lattice.rows.is_some() && rows < LEAST_LINES;
            if is_small || pairs.is_empty() {
                return Err(GluingError::TooSmall { rows, cols });
            }
            compiled.lattice = compiled.lattice.and(lattice);
            compiled.pairs.extend(pairs);
        }
        Ok(compiled)
    }
}

pub(super) fn twice(chart: Chart, pair: [usize; 2]) -> GluingError {
    GluingError::Twice { places: pair.map(|index| chart.position(index)) }
}

/// Returns the pairs of copies that runs name, or an error if a run leaves the grid, runs differ in length, or a pair
/// occurs twice.
fn pairs_of_runs(chart: Chart, runs: &[[Run; 2]]) -> Result<Vec<[usize; 2]>, GluingError> {
    let Chart { rows, cols } = chart;
    let mut pairs = Vec::new();
    for run in runs {
        let [a, b] = run.each_ref().map(|run| {
            let points = chart.walk(run.from, run.to).take(run.points);
            points.map(|(row, col)| chart.index(row, col)).collect::<Vec<_>>()
        });
        for (found, &Run { from: (row, col), points, .. }) in [&a, &b].into_iter().zip(run) {
            if found.len() < points || chart.at(row as isize, col as isize).is_none() {
                return Err(GluingError::Outside { row, col, rows, cols });
            }
        }
        if a.len() != b.len() {
            return Err(GluingError::Runs { points: [a.len(), b.len()] });
        }
        for pair in a.into_iter().zip(b).map(|(a, b)| [a.min(b), a.max(b)]) {
            // The middle of a fold is its own copy.
            if pair[0] != pair[1] {
                pairs.push(pair);
            }
        }
    }
    let mut sorted = pairs.clone();
    sorted.sort_unstable();
    match sorted.windows(2).find(|pairs| pairs[0] == pairs[1]) {
        Some(pairs) => Err(twice(chart, pairs[0])),
        None if pairs.is_empty() => Err(GluingError::Nothing),
        None => Ok(pairs),
    }
}

/// Largest relative difference between the slownesses of copies of a point. Both are one number of the file, rounded.
const SAME_SLOWNESS: f64 = 1e-3;

impl Gluing {
    /// Returns the seams that the gluing names by sides of the grid.
    fn seams(&self) -> Cow<'_, [Seam]> {
        use GridSide::{FirstColumn, FirstRow, LastColumn, LastRow};
        match self {
            Self::Seams(seams) => Cow::Borrowed(seams),
            Self::Octahedral => {
                let sides = [FirstRow, LastRow, FirstColumn, LastColumn];
                Cow::Owned(sides.map(Seam::Fold).to_vec())
            }
            Self::Runs(_) | Self::Charts => Cow::Borrowed(&[]),
        }
    }

    /// Checks that a geometry allows the gluing. `has_positions` says whether it has a position or a height at each
    /// point, and `is_in_space` whether all copies of a point have the same position.
    #[doc(hidden)]
    pub fn check_geometry(
        &self,
        has_positions: bool,
        is_in_space: bool,
    ) -> Result<(), GluingError> {
        let positions = |what| match is_in_space {
            true => Ok(()),
            false => Err(GluingError::NoPositions { what }),
        };
        let of_seam = |seam: &Seam| {
            let Lattice { cols, rows, .. } = Lattice::of(seam);
            match (cols.or(rows), seam) {
                (Some(true), _) if !has_positions => Err(GluingError::ReversedMetric),
                (Some(_), _) | (None, Seam::Neighbours { .. }) => Ok(()),
                (None, Seam::Fold(_)) => positions("a fold"),
                (None, Seam::Pole { .. } | Seam::Ring(_)) => positions("a pole"),
                (None, Seam::Sides { .. }) => positions("a seam between a row and a column"),
            }
        };
        match self {
            Self::Seams(seams) => seams.iter().try_for_each(of_seam),
            Self::Octahedral => positions("an octahedral map"),
            Self::Charts => positions("the gluing of charts"),
            Self::Runs(_) => Ok(()),
        }
    }
}

impl Surface {
    pub(super) fn compile(&self, gluing: &Gluing) -> Result<Compiled, SurfaceError> {
        let geometry = self.geometry();
        gluing.check_geometry(geometry.has_positions(), geometry.is_in_space())?;
        let compiled = match Compiled::on_grid(self.chart, gluing)? {
            Some(compiled) => compiled,
            None => Compiled { pairs: self.coinciding()?, lattice: Lattice::default() },
        };
        self.check_pairs(&compiled.pairs)?;
        gluing.seams().iter().try_for_each(|seam| self.check_size(seam))?;
        Ok(compiled)
    }

    /// Checks that the points of each pair coincide relative to the size of the seam. At the end of a strip that is
    /// much narrower than its cells are long, all points are close together relative to the cells.
    fn check_size(&self, seam: &Seam) -> Result<(), GluingError> {
        let Geometry::Positions(positions) = self.geometry() else { return Ok(()) };
        let mut pairs = pairs_of(self.chart, seam)?;
        pairs.retain(|pair| pair.iter().all(|&index| self.present()[index]));
        let size = match *seam {
            Seam::Sides { .. } | Seam::Neighbours { .. } | Seam::Fold(_) => {
                spread(pairs.iter().flatten().map(|&index| positions[index]))
            }
            Seam::Pole { side, .. } | Seam::Ring(side) => Rim::new(self, side).spread_behind(),
        };
        for [a, b] in pairs {
            let apart = positions[a].distance(positions[b]);
            // A size of 0 has nothing to compare with.
            if size > 0.0 && apart > COINCIDENT * size {
                let places = [a, b].map(|index| self.chart.position(index));
                return Err(GluingError::Apart { places, apart, edge: size });
            }
        }
        Ok(())
    }

    /// Returns pairs of coinciding points beside holes or the border.
    fn coinciding(&self) -> Result<Vec<[usize; 2]>, GluingError> {
        let is_rim = |&(row, col): &(usize, usize)| {
            self.has(row, col)
                && Direction::ALL.into_iter().any(|to| {
                    self.chart.neighbour(row, col, to).is_none_or(|(row, col)| !self.has(row, col))
                })
        };
        let rim: Vec<_> = self.chart.places().filter(is_rim).collect();
        let edge = |&(row, col): &(usize, usize)| self.longest_edge((row, col));
        let shortest =
            rim.iter().map(edge).filter(|&edge| edge > 0.0).fold(f64::INFINITY, f64::min);
        // Points are sorted into cubes whose side is the tolerance, and compared with the points of the cubes around.
        let near = COINCIDENT * shortest;
        let cube = |at: DVec3| (at / near).floor().to_array().map(|k| k as i64);
        let mut found: HashMap<[i64; 3], Vec<(usize, DVec3)>> = HashMap::new();
        let mut pairs = Vec::new();
        for (row, col) in rim {
            let Some(at) = self.position(row, col) else { continue };
            let (index, [x, y, z]) = (self.chart.index(row, col), cube(at));
            let around = (0..27).map(|k| [x + k % 3 - 1, y + k / 3 % 3 - 1, z + k / 9 - 1]);
            let others = around.filter_map(|cube| found.get(&cube)).flatten();
            let first =
                others.filter(|(_, other)| other.distance(at) <= near).map(|(k, _)| *k).min();
            match first {
                Some(first) => pairs.push([first, index]),
                None => found.entry([x, y, z]).or_default().push((index, at)),
            }
        }
        if pairs.is_empty() { Err(GluingError::Nothing) } else { Ok(pairs) }
    }

    /// Returns the length of the longest edge from a point to its neighbours along rows and columns.
    fn longest_edge(&self, (row, col): (usize, usize)) -> f64 {
        let ways = [Direction::East, Direction::North, Direction::West, Direction::South];
        let neighbours = ways.into_iter().filter_map(|to| self.chart.neighbour(row, col, to));
        neighbours
            .filter(|&(r, c)| self.has(r, c) && self.has(row, col))
            .map(|there| self.length_on_surface((row, col), there))
            .fold(0.0, f64::max)
    }

    /// Checks that the points of each pair coincide.
    fn check_pairs(&self, pairs: &[[usize; 2]]) -> Result<(), GluingError> {
        let mut worst: Option<(f64, GluingError)> = None;
        for &pair in pairs {
            let places = pair.map(|index| self.chart.position(index));
            if pair.iter().any(|&index| !self.present()[index]) {
                continue;
            }
            let edge = places.map(|place| self.longest_edge(place)).into_iter().fold(0.0, f64::max);
            let (apart, edge) = self.apart(pair, edge);
            let excess = apart / edge;
            // The excess is not a number if both are zero. The point then has no edge to compare with, and passes.
            if excess > COINCIDENT && worst.as_ref().is_none_or(|(most, _)| excess > *most) {
                worst = Some((excess, GluingError::Apart { places, apart, edge }));
            }
        }
        worst.map_or(Ok(()), |(_, error)| Err(error))
    }

    /// Returns the distance between two points, and the size with which the distance is compared.
    fn apart(&self, [a, b]: [usize; 2], edge: f64) -> (f64, f64) {
        match self.geometry() {
            Geometry::Positions(positions) => (positions[a].distance(positions[b]), edge),
            Geometry::Heights { heights, .. } => ((heights[a] - heights[b]).abs(), edge),
            Geometry::Metric(metric) => {
                let [MetricTensor { rr, rc, cc }, other] = [metric[a], metric[b]];
                let apart = [rr - other.rr, rc - other.rc, cc - other.cc];
                (apart.into_iter().map(f64::abs).fold(0.0, f64::max), rr.max(cc))
            }
        }
    }

    /// Gives all copies of a point the geometry of the first, and checks that their slowness agrees. A point becomes a
    /// hole if any of its copies is one.
    pub(in super::super) fn agree(&mut self) -> Result<(), SurfaceError> {
        let Some(glued) = self.glued.clone() else { return Ok(()) };
        for group in glued.groups.iter() {
            let present = group.iter().all(|&index| self.inputs.present[index as usize]);
            group.iter().for_each(|&index| self.inputs.present[index as usize] = present);
        }
        let (first, slowness) = (|[a, _]: [usize; 2]| a, self.inputs.slowness.as_deref());
        for pair in glued.groups.pairs().filter(|&pair| self.inputs.present[first(pair)]) {
            if let Some([a, b]) = slowness.map(|slowness| pair.map(|index| slowness[index]))
                && (a - b).abs() > SAME_SLOWNESS * a.max(b)
            {
                let places = pair.map(|index| self.chart.position(index));
                return Err(GluingError::Slowness { places, values: [a, b] }.into());
            }
        }
        if let Some(slowness) = &mut self.inputs.slowness {
            glued.groups.pairs().for_each(|[from, to]| slowness[to] = slowness[from]);
        }
        let mut from: Vec<_> = (0..self.chart.points()).map(Some).collect();
        glued.groups.pairs().for_each(|[first, other]| from[other] = Some(first));
        self.inputs.geometry = self.inputs.geometry.gathered(from.into_iter());
        Ok(())
    }
}
