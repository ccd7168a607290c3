//! Maps and matrices are cancelled by their monitor.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use geosweep::pairwise::Pairwise;
use geosweep::{
    Engine, Error, Monitor, Options, Sources, Spacing, Surface, Wavefront, distance_map,
    distance_map_f64,
};

/// A corridor that winds through the grid, so that a front takes one iteration for each of its turns.
fn winding(side: usize) -> Surface {
    let is_open = |row: usize, col: usize| {
        let end = if row % 4 == 1 { side - 1 } else { 0 };
        row.is_multiple_of(2) || col == end
    };
    let mask: Vec<_> = (0..side * side).map(|at| is_open(at / side, at % side)).collect();
    let heights = vec![0.0; side * side];
    Surface::from_heights(side, side, heights, Spacing::square(1.0))
        .and_then(|surface| surface.with_mask(&mask))
        .expect("a flat surface")
}

#[test]
fn a_map_is_cancelled_while_it_is_computed() {
    let (surface, monitor) = (winding(401), Monitor::default());
    let options = Options::default().with_engine(Engine::Cpu).with_monitor(monitor.clone());
    let result = thread::scope(|scope| {
        let map = scope.spawn(|| distance_map(&surface, &Sources::point(0.0, 0.0), &options));
        while monitor.progress().iterations < 3 {
            thread::yield_now();
        }
        monitor.cancel();
        map.join().unwrap()
    });
    assert!(matches!(result, Err(Error::Cancelled)), "{result:?}");
    assert!(monitor.progress().iterations < 100);
}

#[test]
fn no_engine_starts_with_a_cancelled_monitor() {
    let (surface, monitor, source) = (winding(9), Monitor::default(), Sources::point(0.0, 0.0));
    monitor.cancel();
    for engine in [Engine::FastMarching, Engine::Cpu, Engine::Auto] {
        let options = Options::default().with_engine(engine.clone());
        let options = options.with_wavefront(Wavefront::Planar).with_monitor(monitor.clone());
        let single = distance_map(&surface, &source, &options);
        assert!(matches!(single, Err(Error::Cancelled)), "{engine:?}: {single:?}");
        let double = distance_map_f64(&surface, &source, &options);
        assert!(matches!(double, Err(Error::Cancelled)), "{engine:?}: {double:?}");
    }
}

/// The matrix has 625 rows. So the batches of its first generation, of 256 rows, cannot be all.
#[test]
fn a_symmetric_matrix_is_cancelled() {
    let (surface, monitor) = (winding(25), Monitor::default());
    let options = Options::default().with_wavefront(Wavefront::Planar);
    let options = options.with_monitor(monitor.clone());
    let mut pairwise = Pairwise::new(&surface, &options).unwrap();
    let seen = AtomicUsize::new(0);
    let mut matrix = || {
        pairwise.matrix_by_symmetry(|rows| {
            seen.fetch_add(rows, Ordering::Relaxed);
            monitor.cancel();
            Ok::<_, Error>(())
        })
    };
    let result = matrix();
    let rows = seen.load(Ordering::Relaxed);
    assert!(matches!(result, Err(Error::Cancelled)) && (1..=256).contains(&rows), "{rows}");
    assert!(matches!(matrix(), Err(Error::Cancelled)), "it does not start");
    assert_eq!(seen.load(Ordering::Relaxed), rows);
}

#[test]
fn rows_of_a_matrix_are_cancelled() {
    let (surface, monitor) = (winding(25), Monitor::default());
    let options = Options::default().with_monitor(monitor.clone());
    let mut pairwise = Pairwise::new(&surface, &options).unwrap();
    let sources: Vec<usize> = (0..surface.chart().points()).collect();
    let mut seen = 0;
    let result = pairwise.rows(&sources, |rows| {
        seen += rows.sources.len();
        monitor.cancel();
        Ok::<_, Error>(())
    });
    assert!(matches!(result, Err(Error::Cancelled)) && seen < sources.len(), "{seen}");
}
