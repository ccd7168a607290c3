//! Keeps what the maps of a surface share from one map to the next.

use std::sync::{Mutex, OnceLock, PoisonError};

use crate::cpu::{Order, RotatedScan};
use crate::solve::{Precision, in_precision};
use crate::surface::{Seam, Sources, Surface};
use crate::update::{SourceKind, Wavefront};
use crate::{DistanceMap, Engine, Error, Options};

/// A surface on which many maps are computed, one after another or at the same time. It keeps edges, the solver's memory
/// and the seams from one map to the next, so that a further map on the CPU takes only the time of its solve.
///
/// It keeps up to four solvers, one on grids of more than a million points; each takes about as much memory as a map
/// needs ([`RotatedScan`]).
///
/// ```
/// use geosweep::surface::builtin::Builtin;
/// use geosweep::{MapSolver, Options, Sources};
///
/// let solver = MapSolver::new(Builtin::Peaks.surface(65, 65)?);
/// for row in [10.0, 20.0, 30.0] {
///     let map = solver.distance_map(&Sources::point(row, 32.0), &Options::default())?;
///     assert_eq!(map.distance(row as usize, 32), 0.0);
/// }
/// # Ok::<(), geosweep::Error>(())
/// ```
#[derive(Debug)]
pub struct MapSolver {
    surface: Surface,
    single: Waiting<f32>,
    double: Waiting<f64>,
    seams: OnceLock<Vec<Seam>>,
    /// Kinds of fronts that were chosen before, for what was asked.
    wavefronts: Mutex<Vec<(Asked, Wavefront)>>,
}

/// The options, besides the surface, on which the choice of a kind of front depends.
type Asked = (Option<Wavefront>, bool, SourceKind);

/// The solvers of a precision that wait for their next map.
#[derive(Debug)]
pub(crate) struct Waiting<R>(Mutex<Vec<Kept<R>>>);

/// A solver that waits for its next map. The order of its scans suits the number of threads.
#[derive(Debug)]
struct Kept<R> {
    wavefront: Wavefront,
    /// The order that was asked for.
    order: Option<Order>,
    threads: usize,
    solver: RotatedScan<R>,
}

/// Number of solvers that wait at most, on grids up to [`SMALL`] points. On larger grids it is one.
const MOST: usize = 4;
const SMALL: usize = 1 << 20;
/// Number of choices of a kind of front that are kept.
const MOST_KINDS: usize = 16;

impl MapSolver {
    /// Makes a solver, which measures the surface for its first map.
    pub fn new(surface: Surface) -> Self {
        let (single, double) = (Waiting(Mutex::default()), Waiting(Mutex::default()));
        let (seams, wavefronts) = Default::default();
        Self { surface, single, double, seams, wavefronts }
    }

    /// Returns the surface.
    pub fn surface(&self) -> &Surface {
        &self.surface
    }

    /// Computes a map as [`crate::distance_map`] does.
    ///
    /// # Errors
    /// The errors of [`crate::distance_map`].
    pub fn distance_map(&self, sources: &Sources, options: &Options) -> Result<DistanceMap, Error> {
        in_precision(&self.surface, sources, options, Some(self))
    }

    /// Computes a map in double precision as [`crate::distance_map_f64`] does.
    ///
    /// # Errors
    /// The errors of [`crate::distance_map_f64`].
    pub fn distance_map_f64(
        &self,
        sources: &Sources,
        options: &Options,
    ) -> Result<DistanceMap<f64>, Error> {
        in_precision(&self.surface, sources, options, Some(self))
    }

    pub(crate) fn single(&self) -> &Waiting<f32> {
        &self.single
    }

    pub(crate) fn double(&self) -> &Waiting<f64> {
        &self.double
    }

    pub(crate) fn seams(&self) -> &[Seam] {
        self.seams.get_or_init(|| self.surface.seams())
    }

    /// Returns the kind of front for a map.
    pub(crate) fn wavefront(
        &self,
        sources: &Sources,
        options: &Options,
    ) -> Result<Wavefront, Error> {
        let is_marched = matches!(options.engine, Engine::FastMarching);
        let asked = (options.wavefront, is_marched, SourceKind::of(sources));
        let known = |chosen: &[(Asked, Wavefront)]| {
            chosen.iter().find(|(of, _)| *of == asked).map(|(_, wavefront)| *wavefront)
        };
        let chosen = || self.wavefronts.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(wavefront) = known(&chosen()) {
            return Ok(wavefront);
        }
        let wavefront = options.resolve_wavefront(&self.surface, sources)?;
        let mut chosen = chosen();
        // Sources inside cells are counted, so there may be as many kinds as maps.
        if chosen.len() == MOST_KINDS {
            chosen.clear();
        }
        chosen.push((asked, wavefront));
        Ok(wavefront)
    }

    /// Takes a solver for this kind of front and order, if one waits.
    pub(crate) fn take<R: Precision>(
        &self,
        wavefront: Wavefront,
        order: Option<Order>,
    ) -> Option<RotatedScan<R>> {
        let threads = rayon::current_num_threads();
        let mut kept = R::waiting(self).0.lock().unwrap_or_else(PoisonError::into_inner);
        let suits = |kept: &Kept<R>| {
            (kept.wavefront, kept.order, kept.threads) == (wavefront, order, threads)
        };
        let index = kept.iter().position(suits)?;
        Some(kept.swap_remove(index).solver)
    }

    /// Keeps a solver for the next map.
    pub(crate) fn keep<R: Precision>(
        &self,
        wavefront: Wavefront,
        order: Option<Order>,
        solver: RotatedScan<R>,
    ) {
        let threads = rayon::current_num_threads();
        let mut kept = R::waiting(self).0.lock().unwrap_or_else(PoisonError::into_inner);
        let most = if self.surface.chart().points() > SMALL { 1 } else { MOST };
        kept.push(Kept { wavefront, order, threads, solver });
        let surplus = kept.len().saturating_sub(most);
        // Solvers that have waited longest are dropped after the lock.
        let dropped: Vec<_> = kept.drain(..surplus).collect();
        drop(kept);
        drop(dropped);
    }
}
