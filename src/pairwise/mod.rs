//! Computes all-pairs matrices: the geodesic distances between all points of a surface (paper, sections 5.1
//! and 6.1), as a whole or row by row.
//!
//! ```
//! use geosweep::pairwise::Pairwise;
//! use geosweep::{Options, Spacing, Surface, Wavefront};
//!
//! // A flat square of 5 x 5 points.
//! let surface = Surface::from_heights(5, 5, vec![0.0; 25], Spacing::square(1.0))?;
//! let options = Options::default().with_wavefront(Wavefront::Circular);
//! let mut pairwise = Pairwise::new(&surface, &options)?;
//! let (matrix, report) = pairwise.matrix(|_| ())?;
//! assert!(report.converged());
//! assert!((matrix[24] - 32f32.sqrt()).abs() < 1e-5); // from the first point to the last
//!
//! // Rows as they are done: together they need not fit memory.
//! let mut farthest = Vec::new();
//! pairwise.rows(&[3, 12], |rows| {
//!     farthest.extend(rows.iter().map(|(_, row)| row.iter().copied().fold(0.0, f32::max)));
//!     Ok::<_, geosweep::Error>(())
//! })?;
//! assert!((farthest[1] - 8f32.sqrt()).abs() < 1e-6); // from the middle to a corner
//! # Ok::<(), geosweep::Error>(())
//! ```

mod batches;
mod engine;
mod lanes;
mod nearest;
#[cfg(feature = "vulkan")]
mod on_device;
mod report;
mod rows;
mod sparse;

use std::time::{Duration, Instant};

pub use crate::cpu::SparseRows;
use crate::surface::Surface;
use crate::{Convergence, Error, Options, Stop};
use engine::RowEngine;
pub use nearest::{NearPoint, nearest_points};
pub use report::PairwiseReport;
pub use rows::Rows;
pub use sparse::pairs_within;

/// Computes rows of the distance matrix of a surface. Data that all rows share is prepared once.
///
/// The matrix has one row and one column for each grid point, in row-major order of the grid. The row and
/// column of a hole are +infinity, and so are the distances between points that no path connects. The two
/// distances of a pair of points are computed independently and differ by the solver's error.
pub struct Pairwise<'a> {
    surface: &'a Surface,
    engine: RowEngine<'a>,
    stop: Stop,
}

impl<'a> Pairwise<'a> {
    /// Prepares a surface. Options have the same meaning as for a single map, with these exceptions.
    /// [`Options::schedule`] and [`Options::targets`] must not be set, since rows have neither. Distances beyond
    /// [`Options::radius`] are +infinity; [`pairs_within`] computes only the distances within the radius.
    /// [`Engine::Auto`](crate::Engine::Auto) means the CPU.
    ///
    /// The CPU computes sixteen maps at once in SIMD lanes ([`PairwiseScan`](crate::cpu::PairwiseScan)).
    /// Curved wavefronts are computed map by map ([`RotatedScan`](crate::cpu::RotatedScan)). All of rayon's
    /// threads are used.
    ///
    /// # Errors
    /// If an option is out of range or does not suit the surface, targets or a schedule are set, an edge of the
    /// surface is too long or too short for single precision, or the requested Vulkan device cannot be used.
    pub fn new(surface: &'a Surface, options: &Options) -> Result<Self, Error> {
        let stop = options.stop(surface, crate::DEFAULT_TOLERANCE)?;
        options.check_for_rows()?;
        let wavefront = options.wavefront_of_rows(surface)?;
        let engine = RowEngine::new(surface, wavefront, options)?;
        Ok(Self { surface, engine, stop })
    }

    /// Returns the number of grid points, which is the number of the matrix's rows and of its columns.
    pub fn points(&self) -> usize {
        self.surface.chart().points()
    }

    /// Returns the bytes of memory used while rows are computed, without the surface and a matrix in memory.
    pub fn bytes(&self) -> usize {
        let held = self.engine.bytes(rayon::current_num_threads());
        held + 2 * self.wave() * self.points() * size_of::<f32>()
    }

    /// Computes the whole matrix, row-major. `done` is called with the number of rows that have been added,
    /// from any thread.
    ///
    /// # Errors
    /// If there is too little memory, or the Vulkan device fails.
    pub fn matrix(
        &mut self,
        done: impl Fn(usize) + Sync,
    ) -> Result<(Vec<f32>, PairwiseReport), Error> {
        let sources: Vec<usize> = (0..self.points()).collect();
        let mut matrix = self.room_for_a_matrix()?;
        let start = Instant::now();
        let convergence = self.engine.solve(&sources, self.stop, &mut matrix, &done)?;
        self.engine.monitor.check()?;
        Ok((matrix, self.report(sources.len(), convergence, start.elapsed())))
    }

    /// Computes the whole matrix with the symmetric initialisation (paper, eq. 20).
    ///
    /// Rows are computed in generations. Distances to the points of earlier generations are copied from the
    /// rows of those points. So the matrix is symmetric except for the blocks on its diagonal, one for each
    /// generation. If `done` fails, no more rows are started.
    ///
    /// # Errors
    /// As for [`Self::matrix`]; if the wavefront is curved, since its start would need curvatures as well; if
    /// the engine does not support this initialisation; if the surface is glued; if the monitor of
    /// [`Options::with_monitor`] cancels the computation; and any error of `done`.
    pub fn matrix_by_symmetry<E: From<Error> + Send>(
        &mut self,
        done: impl Fn(usize) -> Result<(), E> + Sync,
    ) -> Result<(Vec<f32>, PairwiseReport), E> {
        let (lanes, grid) = self.engine.for_symmetry()?;
        let monitor = &self.engine.monitor;
        monitor.check().map_err(Error::from)?;
        let mut matrix = self.room_for_a_matrix()?;
        let done = |rows: usize| -> Result<(), E> {
            monitor.check().map_err(Error::from)?;
            done(rows)
        };
        let start = Instant::now();
        let convergence = lanes.solve_by_symmetry(grid, self.stop, &mut matrix, &done)?;
        Ok((matrix, self.report(self.points(), convergence, start.elapsed())))
    }

    /// Computes the distances among some points only: a k x k matrix for k points, row-major. Points are
    /// given by their grid indices. `done` is called with the number of rows that have been added.
    ///
    /// # Errors
    /// As for [`Self::rows`].
    pub fn among(
        &mut self,
        points: &[usize],
        done: impl Fn(usize) + Sync,
    ) -> Result<(Vec<f32>, PairwiseReport), Error> {
        let mut matrix = rows::room(points.len(), points.len())?;
        let mut left = matrix.as_mut_slice();
        let report = self.rows(points, |rows| {
            for (_, distances) in rows.iter() {
                let row = left.split_off_mut(..points.len()).expect("a row for each point");
                row.iter_mut().zip(points).for_each(|(to, &point)| *to = distances[point]);
            }
            done(rows.sources.len());
            Ok::<_, Error>(())
        })?;
        Ok((matrix, report))
    }

    /// Computes the rows of some sources, given by their grid indices, and passes them to `sink` in that
    /// order. `sink` gets several rows at a time, while the next rows are computed. An error of `sink` ends
    /// the computation.
    ///
    /// On the CPU, a row of consecutive sources is bit-identical to the row of the whole matrix.
    ///
    /// # Errors
    /// Any error of `sink`; if the monitor of [`Options::with_monitor`] cancels the computation, a source is
    /// outside the grid, there is too little memory, or the Vulkan device fails.
    pub fn rows<E: From<Error> + Send>(
        &mut self,
        sources: &[usize],
        sink: impl FnMut(Rows) -> Result<(), E> + Send,
    ) -> Result<PairwiseReport, E> {
        let points = self.points();
        if let Some(&outside) = sources.iter().find(|&&source| source >= points) {
            let message =
                format!("there is no point {outside}; the grid has points 0 to {}", points - 1);
            return Err(Error::Options(message).into());
        }
        let (wave, stop, engine) = (self.wave(), self.stop, &mut self.engine);
        // The work stays on rayon's own threads from the first wave to the last. Threads that are woken up
        // for each wave often end up on the same core.
        let (convergence, time) =
            rayon::scope(|_| rows::stream(engine, sources, points, wave, stop, sink))?;
        Ok(self.report(sources.len(), convergence, time))
    }

    /// Returns the number of rows that are computed and passed on together: enough to keep all threads busy.
    fn wave(&self) -> usize {
        const BYTES: usize = 16 << 20;
        let row = self.points() * size_of::<f32>();
        let least = self.engine.rows_at_once(rayon::current_num_threads());
        (BYTES / row).clamp(least, 4 * least)
    }

    fn room_for_a_matrix(&self) -> Result<Vec<f32>, Error> {
        let points = self.points();
        rows::room(points, points)
    }

    fn report(
        &self,
        rows: usize,
        convergence: Convergence,
        solve_time: Duration,
    ) -> PairwiseReport {
        PairwiseReport {
            engine: self.engine.used(),
            device: self.engine.device().map(Into::into),
            wavefront: self.engine.wavefront(),
            rows,
            points: self.points(),
            iterations: convergence.iterations,
            residual: convergence.residual,
            tolerance: self.stop.tolerance,
            solve_time,
        }
    }
}
