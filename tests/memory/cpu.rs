//! A solver that is used again allocates nothing on the heap for further maps.

use geosweep::Stop;
use geosweep::cpu::RotatedScan;
use geosweep::surface::{EdgeLengths, builtin::Builtin};
use geosweep::{Sources, Wavefront};

use crate::ALONE;
use crate::heap::allocations;

#[test]
fn further_maps_allocate_nothing() {
    let _alone = ALONE.lock();
    // The thread that counts must do all the work.
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    one.install(|| {
        let surface = Builtin::Maze.surface(150, 110).unwrap();
        let edges = EdgeLengths::<f32>::new(&surface).unwrap();
        let at = |row, col| Sources::point(row, col).seeds(&surface).unwrap();
        let stop = Stop::within(1e-6).or_after(1000);
        for wavefront in Wavefront::ALL {
            let before = allocations();
            let mut solver = RotatedScan::new(&edges, wavefront);
            assert!(allocations() > before, "counts");
            let sources = [at(0.0, 0.0), at(149.0, 0.0), at(120.0, 109.0), at(3.0, 50.5)];
            for (map, seeds) in sources.iter().enumerate() {
                let before = allocations();
                solver.solve(seeds, stop);
                solver.add(&sources[0], stop);
                assert_eq!(allocations() - before, 0, "map {map}, {wavefront}");
            }
        }
    });
}
