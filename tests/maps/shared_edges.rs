//! Tasks of a thread pool that need the same result of a surface at the same moment, on its first use. Each task has to
//! end, although a thread that waits for another one takes up further tasks meanwhile.

use std::sync::mpsc;
use std::thread;
use std::time::Duration;

use geosweep::cpu::RotatedScan;
use geosweep::surface::builtin::{Builtin, Closed};
use geosweep::surface::{EdgeLengths, Gluing, MetricTensor};
use geosweep::{Spacing, Surface, Wavefront};
use rayon::prelude::*;

/// Time after which a job counts as hanging. Each takes a few seconds at most.
const HANGS: Duration = Duration::from_secs(300);

/// Number of fresh surfaces. Without the precaution, tasks wait for each other within the first hundred.
const ROUNDS: usize = 200;

/// Runs four to six of a task at once on each fresh surface, in a pool with more threads than this machine may have cores.
fn run_at_once<T: Sync + 'static>(new: impl Fn() -> T + Send + 'static, task: fn(&T)) {
    let (sender, receiver) = mpsc::channel();
    thread::spawn(move || {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(8).build().unwrap();
        for round in 0..ROUNDS {
            let shared = new();
            let tasks = (0..4 + round % 3).into_par_iter().with_max_len(1);
            pool.install(|| tasks.for_each(|_| task(&shared)));
        }
        sender.send(()).unwrap();
    });
    assert!(receiver.recv_timeout(HANGS).is_ok(), "tasks wait for each other");
}

fn make_solver(edges: &EdgeLengths<f32>) {
    RotatedScan::new(edges, Wavefront::Curved);
}

#[test]
fn tasks_make_solvers_of_the_same_edges() {
    let peaks = Builtin::Peaks.surface(201, 201).unwrap();
    run_at_once(move || EdgeLengths::new(&peaks).unwrap(), make_solver);
}

#[test]
fn tasks_make_solvers_of_the_same_closed_surface() {
    let torus = Closed::Torus.surface(101, 101).unwrap();
    run_at_once(move || EdgeLengths::new(&torus).unwrap(), make_solver);
    let tensor = MetricTensor { rr: 1.0, rc: 0.0, cc: 2.0 };
    let flat = Surface::from_metric(101, 101, vec![tensor; 101 * 101]).unwrap();
    let flat = flat.with_gluing(Gluing::both()).unwrap();
    run_at_once(move || EdgeLengths::new(&flat).unwrap(), make_solver);
}

#[test]
fn tasks_ask_whether_the_same_surface_is_a_floor_plan() {
    let spacing = Spacing { dx: 1.0, dy: 1.0 };
    let floor = move || Surface::from_heights(301, 301, vec![0.0; 301 * 301], spacing).unwrap();
    run_at_once(floor, |floor| assert!(floor.is_floor_plan()));
}
