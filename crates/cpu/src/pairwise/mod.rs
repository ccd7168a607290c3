//! Computes the distances of all pairs: maps of neighbouring sources share an instruction stream, each in a SIMD lane
//! (paper, section 5.1, Algorithm 4).

mod circular;
mod farther;
mod kernel;
mod maps;
mod marks;
mod outward;
mod parts;
mod pending;
mod planar;
mod reach;
mod scans;
mod stage;

use super::Instructions;
use super::behind::Behind;
use super::scan::Scan;
use circular::Circular;
use geosweep_surface::update::Wavefront;
use geosweep_surface::{Chart, Direction, EdgeLengths, Real};
use geosweep_surface::{Convergence, Stop};
use kernel::{Fan, LANES};
use maps::Known;
use planar::Planar;
use scans::{BatchSolver, Scans};

/// A solver for batches of maps of one surface. Any number of threads may use it.
///
/// The maps of a batch lie side by side in memory, point by point. They are updated together, with coefficients that
/// all of them share and that are computed once for a surface. The scans are those of the shaders' twin `scan_outward`,
/// in the same order. A scan visits a point only if a map of the batch has changed beside it since the scan last
/// passed. So the sources of a batch should be neighbours.
pub struct PairwiseScan {
    chart: Chart,
    scans: Box<dyn BatchSolver>,
    instructions: Instructions,
}

impl PairwiseScan {
    /// Number of maps in a batch.
    pub const LANES: usize = LANES;

    /// Computes the coefficients of a surface. Uses the best instructions that are available. Returns `None`
    /// for a wavefront whose maps have no update in common, because its fronts carry more than their arrival
    /// time: [`Wavefront::Curved`] and [`Wavefront::Anchored`]. These are computed map by map, by
    /// [`RotatedScan`](super::RotatedScan). So are maps over an uneven slowness, on
    /// glued surfaces, or on surfaces with too many
    /// obtuse triangles for their parts to be stored.
    pub fn new(edges: &EdgeLengths<f32>, wavefront: Wavefront) -> Option<Self> {
        if edges.copies().is_some() {
            return None;
        }
        let has_parts = edges.parts_on_side(Direction::North).is_some();
        if edges.slowness().is_some() || (edges.has_obtuse_triangles() && !has_parts) {
            return None;
        }
        let scans: Box<dyn BatchSolver> = match wavefront {
            Wavefront::Planar if edges.has_obtuse_triangles() || has_wide_angles(edges) => {
                Box::new(Scans::<Planar<true>>::new(edges))
            }
            Wavefront::Planar => Box::new(Scans::<Planar<false>>::new(edges)),
            Wavefront::Circular if edges.front_meets_itself() => {
                Box::new(Scans::<Circular<true>>::new(edges))
            }
            Wavefront::Circular => Box::new(Scans::<Circular<false>>::new(edges)),
            Wavefront::Curved | Wavefront::Anchored | Wavefront::Rays => return None,
        };
        Some(Self { chart: edges.chart(), scans, instructions: Instructions::best() })
    }

    /// Sets the instructions. The maps do not depend on them.
    ///
    /// # Panics
    /// If this machine does not have the instructions; see [`Instructions::available`].
    pub fn with_instructions(mut self, instructions: Instructions) -> Self {
        assert!(
            Instructions::available().contains(&instructions),
            "this machine does not have {instructions}"
        );
        self.instructions = instructions;
        self
    }

    /// Returns the memory in bytes: for the surface, and for each batch that is computed at the same time.
    pub fn bytes(&self) -> (usize, usize) {
        self.scans.bytes()
    }

    /// Computes the distances from at most [`Self::LANES`] grid points, given by their index, to all points. `into` has
    /// a row for each source. Distances are +infinity at unreached points. A source of `None` (use it for holes) gives
    /// a row of +infinity.
    ///
    /// # Panics
    /// If there are more than [`Self::LANES`] sources, or if `into` does not have one row of all grid points for each
    /// source.
    pub fn solve(&self, sources: &[Option<usize>], stop: Stop, into: &mut [f32]) -> Convergence {
        self.solve_from(sources, Known::NOTHING, stop, &mut self.rows(into))
    }

    /// Computes the rows of [`Self::solve`] anywhere in memory, and only for the sources that have a row.
    ///
    /// # Panics
    /// As [`Self::solve`].
    pub fn solve_rows(
        &self,
        sources: &[Option<usize>],
        stop: Stop,
        into: &mut [Option<&mut [f32]>],
    ) -> Convergence {
        self.solve_from(sources, Known::NOTHING, stop, into)
    }

    /// Computes the rows of [`Self::solve`] for successive sources from `first` on, with the symmetric initialisation
    /// (paper, eq. 20). `rows` are the distances from the first points to all points. The distances from the sources to
    /// these first points are taken from `rows` and are not computed again.
    ///
    /// # Panics
    /// As [`Self::solve`]; and if `rows` is not a whole number of rows or has more than `first` rows, or if `sources`
    /// do not follow one another from `first` on.
    pub fn solve_below(
        &self,
        rows: &[f32],
        first: usize,
        sources: &[Option<usize>],
        stop: Stop,
        into: &mut [f32],
    ) -> Convergence {
        let count = rows.len() / self.chart.points();
        assert!(
            rows.len().is_multiple_of(self.chart.points()) && count <= first,
            "`rows` must be whole rows, at most `first` of them"
        );
        let follow = |(lane, source): (usize, &Option<usize>)| {
            source.is_none_or(|source| source == first + lane)
        };
        assert!(
            sources.iter().enumerate().all(follow),
            "sources must follow one another from `first` on"
        );
        self.solve_from(sources, Known { rows, count, column: first }, stop, &mut self.rows(into))
    }

    fn rows<'a>(&self, matrix: &'a mut [f32]) -> Vec<Option<&'a mut [f32]>> {
        let points = self.chart.points();
        assert!(matrix.len().is_multiple_of(points), "the matrix must consist of whole rows");
        matrix.chunks_exact_mut(points).map(Some).collect()
    }

    fn solve_from(
        &self,
        sources: &[Option<usize>],
        known: Known,
        stop: Stop,
        into: &mut [Option<&mut [f32]>],
    ) -> Convergence {
        assert!(sources.len() <= LANES, "a batch has at most {LANES} sources");
        assert_eq!(into.len(), sources.len(), "there must be one row for each source");
        let points = self.chart.points();
        assert!(into.iter().flatten().all(|row| row.len() == points), "rows of {points} points");
        self.scans.solve(sources, known, stop, self.instructions, into)
    }
}

/// Returns whether some angle between two successive edges around a point is slightly wider than a right angle, but
/// does not count as obtuse.
fn has_wide_angles(edges: &EdgeLengths<f32>) -> bool {
    let fans = Scan::ALL.map(|scan| Behind::of(edges.chart(), scan));
    edges.chart().places().any(|(row, col)| {
        let point = edges.chart().bordered(row, col);
        fans.iter().any(|behind| Fan::of(behind, edges, point).triangles().into_iter().any(is_wide))
    })
}

fn is_wide([l1, l2, c]: [f32; 3]) -> bool {
    c < f32::FAR && l1 * l1 + l2 * l2 < c * c
}
