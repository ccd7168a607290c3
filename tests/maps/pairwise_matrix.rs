//! The matrix of all distances is the same from every engine, in whole or in part.

use geosweep::accuracy::Errors;
use geosweep::pairwise::Pairwise;
use geosweep::surface::Seed;
use geosweep::surface::builtin::Builtin;
use geosweep::{Engine, Error, Options, Spacing, Surface, Wavefront};

use crate::common::{CONVERGED, device_choice, difference, on_cpu};

const STRAIGHT: [Wavefront; 2] = [Wavefront::Planar, Wavefront::Circular];

fn options(engine: Engine, wavefront: Wavefront) -> Options {
    Options::default().with_engine(engine).with_wavefront(wavefront)
}

fn on_lanes(wavefront: Wavefront) -> Options {
    options(Engine::Cpu, wavefront)
}

/// Returns hills with holes, some of which cut a corner off. The number of points is no multiple of the number
/// of lanes.
fn hills() -> Surface {
    let (rows, cols) = (13, 19);
    let height = |i: usize| (i as f64 * 0.41).sin() + (i / cols) as f64 * 0.2;
    let heights = (0..rows * cols).map(height).collect();
    let hole = |i: usize| [2, cols + 1, 2 * cols, cols + 2, 2 * cols + 1, 100, 101].contains(&i);
    let mask: Vec<bool> = (0..rows * cols).map(|i| !hole(i)).collect();
    Surface::from_heights(rows, cols, heights, Spacing::square(1.0))
        .and_then(|surface| surface.with_mask(&mask))
        .unwrap()
}

fn matrix(surface: &Surface, options: &Options) -> Vec<f32> {
    let mut pairwise = Pairwise::new(surface, options).unwrap();
    let (matrix, report) = pairwise.matrix(|_| ()).unwrap();
    let points = surface.chart().points();
    assert_eq!((matrix.len(), report.rows, report.points), (points * points, points, points));
    assert!(report.converged(), "{report:?}");
    matrix
}

/// The project requires engines to agree within 1e-5 of the largest distance.
#[test]
fn every_engine_gives_the_same_matrix() {
    let device = device_choice();
    let surface = hills();
    let chart = surface.chart();
    for wavefront in Wavefront::FOR_ANY_SURFACE {
        let rows = matrix(&surface, &on_lanes(wavefront));
        for (source, row) in rows.chunks(chart.points()).enumerate() {
            let (r, c) = chart.position(source);
            if surface.has(r, c) {
                let seeds = [Seed::at_source(r, c, 0.0)];
                let map = on_cpu(&surface, &seeds, wavefront, CONVERGED);
                let apart = difference(row, &map);
                assert!(apart < 1e-5, "{wavefront} {source}: {apart:e}");
            } else {
                assert!(row.iter().all(|distance| *distance == f32::INFINITY));
            }
        }
        // On steep hills the order of updates decides which of two circular or curved fronts a point keeps.
        let marching = (wavefront == Wavefront::Planar).then_some(Engine::FastMarching);
        for engine in [Engine::Vulkan(device.clone())].into_iter().chain(marching) {
            let others = matrix(&surface, &options(engine.clone(), wavefront));
            let apart = difference(&rows, &others);
            println!("{wavefront}, {engine}: {apart:.1e}");
            assert!(apart < 1e-5, "{wavefront}: {engine} is off by {apart:e}");
        }
    }
}

#[test]
fn rows_in_part_are_those_of_the_whole_to_the_bit() {
    let surface = hills();
    let points = surface.chart().points();
    for wavefront in Wavefront::FOR_ANY_SURFACE {
        let mut pairwise = Pairwise::new(&surface, &on_lanes(wavefront)).unwrap();
        let (whole, _) = pairwise.matrix(|_| ()).unwrap();
        for range in [0..points, 5..6, 17..100, 240..points] {
            let sources: Vec<usize> = range.clone().collect();
            let mut rows = Vec::new();
            let report = pairwise.rows(&sources, |part| {
                assert_eq!(part.sources, &sources[rows.len() / points..][..part.sources.len()]);
                rows.extend_from_slice(part.distances);
                Ok::<_, Error>(())
            });
            assert_eq!(report.unwrap().rows, range.len());
            assert!(
                rows == whole[range.start * points..range.end * points],
                "{wavefront} {range:?}"
            );
        }
        // Rows come in the order of the list, whichever rows share a batch.
        let list = [200, 3, 3, 100, 16, 17];
        let (among, _) = pairwise.among(&list, |_| ()).unwrap();
        for (i, from) in list.into_iter().enumerate() {
            for (j, to) in list.into_iter().enumerate() {
                let (found, expected) = (among[i * list.len() + j], whole[from * points + to]);
                let close = found == expected || (found - expected).abs() < 1e-5 * expected;
                assert!(close, "{wavefront}, {from} to {to}: {found} and {expected}");
            }
        }
    }
}

#[test]
fn the_matrix_does_not_depend_on_threads() {
    let surface = hills();
    for wavefront in Wavefront::FOR_ANY_SURFACE {
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut pairwise = Pairwise::new(&surface, &on_lanes(wavefront)).unwrap();
                let plain = pairwise.matrix(|_| ()).unwrap().0;
                let symmetric =
                    pairwise.matrix_by_symmetry(|_| Ok::<_, Error>(())).ok().map(|both| both.0);
                (plain, symmetric)
            })
        };
        assert!(with(1) == with(3), "{wavefront}");
    }
}

/// The symmetric start (paper, eq. 20) takes distances from earlier rows. Measured: the mean error is 0.99 to
/// 1.01 times the error without the symmetric start. Outside of blocks of 256 rows, the matrix equals its
/// transpose.
#[test]
fn the_symmetric_start_is_as_accurate() {
    let side = 25;
    let points = side * side;
    let surface = Builtin::Sphere.surface(side, side).unwrap();
    let mean_error = |matrix: &[f32]| {
        let of = |source: usize| {
            let place = [(source / side) as f64, (source % side) as f64];
            let exact = Builtin::Sphere.exact_distances(side, side, place).unwrap();
            Errors::of(&matrix[source * points..][..points], &exact).mean_relative
        };
        (0..points).step_by(31).map(of).sum::<f64>()
    };
    for wavefront in STRAIGHT {
        let mut pairwise = Pairwise::new(&surface, &on_lanes(wavefront)).unwrap();
        let (plain, _) = pairwise.matrix(|_| ()).unwrap();
        let (symmetric, _) = pairwise.matrix_by_symmetry(|_| Ok::<_, Error>(())).unwrap();
        let (before, after) = (mean_error(&plain), mean_error(&symmetric));
        println!("{wavefront}: {:.3} times the error", after / before);
        assert!(after < 1.05 * before, "{wavefront}: {after:e} after {before:e}");
        for (i, j) in (256..points).flat_map(|i| (0..256).map(move |j| (i, j))) {
            assert_eq!(symmetric[i * points + j], symmetric[j * points + i], "{wavefront} {i} {j}");
        }
    }
    let mut curved = Pairwise::new(&surface, &on_lanes(Wavefront::Curved)).unwrap();
    let message = curved.matrix_by_symmetry(|_| Ok::<_, Error>(())).unwrap_err().to_string();
    assert!(message.contains("planar"), "{message}");
}

/// Sources are single points of the grid. Over floor plans, too, fronts are curved by default.
#[test]
fn the_report_names_the_wavefront_of_all_rows() {
    let plan = Builtin::Plane.surface(5, 6).unwrap();
    let slow = plan.clone().with_slowness(vec![1.5; 30]).unwrap();
    let of = |surface: &Surface, engine: Engine, wavefront| {
        let options = Options::default().with_engine(engine).with_wavefront(wavefront);
        let mut pairwise = Pairwise::new(surface, &options)?;
        pairwise.rows(&[3], |_| Ok::<_, Error>(())).map(|report| report.wavefront)
    };
    for (surface, engine, wanted, found) in [
        (&plan, Engine::Auto, None, Wavefront::Curved),
        (&plan, Engine::Cpu, None, Wavefront::Curved),
        (&slow, Engine::Cpu, None, Wavefront::Curved),
        (&plan, Engine::FastMarching, None, Wavefront::Planar),
        (&slow, Engine::FastMarching, None, Wavefront::Planar),
        (&plan, Engine::Cpu, Some(Wavefront::Anchored), Wavefront::Anchored),
        (&plan, Engine::FastMarching, Some(Wavefront::Anchored), Wavefront::Anchored),
        (&slow, Engine::Cpu, Some(Wavefront::Planar), Wavefront::Planar),
    ] {
        assert_eq!(of(surface, engine.clone(), wanted).unwrap(), found, "{engine:?} {wanted:?}");
    }
    let refused = of(&slow, Engine::Cpu, Some(Wavefront::Anchored)).unwrap_err().to_string();
    assert!(refused.contains("floor plans"), "{refused}");
}

#[test]
fn an_error_of_the_sink_ends_the_work() {
    #[derive(Debug)]
    enum Stopped {
        Enough,
        Failed(#[allow(dead_code, reason = "it is shown if the test fails")] Error),
    }
    impl From<Error> for Stopped {
        fn from(error: Error) -> Self {
            Self::Failed(error)
        }
    }
    let surface = Builtin::Plane.surface(60, 60).unwrap();
    let mut pairwise = Pairwise::new(&surface, &on_lanes(Wavefront::Planar)).unwrap();
    let all: Vec<usize> = (0..3600).collect();
    let mut rows = 0;
    let stopped = pairwise.rows(&all, |part| {
        rows += part.sources.len();
        Err(Stopped::Enough)
    });
    assert!(matches!(stopped, Err(Stopped::Enough)), "{stopped:?}");
    assert!(rows > 0 && rows < 3600, "{rows}");

    let message = pairwise.among(&[3600], |_| ()).unwrap_err().to_string();
    assert!(message.contains("3600") && message.contains("3599"), "{message}");
    assert!(pairwise.among(&[], |_| ()).unwrap().0.is_empty());
}

/// The project allows at most 64 MB in addition to the matrix for 4,096 points.
#[test]
fn memory_beside_the_matrix_is_bounded() {
    let surface = Builtin::Sphere.surface(64, 64).unwrap();
    for wavefront in Wavefront::FOR_ANY_SURFACE {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
        let bytes = pool.install(|| Pairwise::new(&surface, &on_lanes(wavefront)).unwrap().bytes());
        println!("{wavefront}: {:.1} MB", bytes as f64 * 1e-6);
        assert!(bytes < 64_000_000, "{wavefront}: {bytes}");
    }
}
