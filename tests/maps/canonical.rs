//! Canonical forms: known points are recovered, the stress agrees with that of another implementation, and bendings
//! of a surface share a form.

use std::f64::consts::{FRAC_PI_2, PI};

use geosweep::geometry::canonical::{
    CanonicalError, Distances, FormOptions, Start, align, canonical_form,
};
use geosweep::glam::DVec3;
use geosweep::pairwise::Pairwise;
use geosweep::{Options, Surface, Wavefront};

/// Returns straight distances between points with row-major coordinates.
fn straight(points: &[f64], dimensions: usize) -> Distances {
    let count = points.len() / dimensions;
    let at = |point: usize| &points[point * dimensions..][..dimensions];
    let distance = |index: usize| {
        let pairs = at(index / count).iter().zip(at(index % count));
        pairs.map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt() as f32
    };
    Distances::new(count, (0..count * count).map(distance).collect()).unwrap()
}

/// Returns numbers from 0 to 1 without structure.
fn scattered(count: usize) -> Vec<f64> {
    let hash = |k: u64| (k + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(31);
    (0..count as u64)
        .map(|k| (hash(k).wrapping_mul(hash(k)) >> 11) as f64 / 2f64.powi(53))
        .collect()
}

fn options(dimensions: usize) -> FormOptions {
    FormOptions::default().with_dimensions(dimensions)
}

#[test]
fn points_of_space_come_back() {
    for (dimensions, count) in [(1, 40), (2, 300), (3, 333), (5, 200)] {
        let points = scattered(count * dimensions);
        let distances = straight(&points, dimensions);
        let form = canonical_form(&distances, &options(dimensions)).unwrap();
        // Distances are rounded to seven digits.
        assert!(form.stress_1() < 1e-6, "{dimensions}: {}", form.stress_1());
        let deviation = align(&form.coordinates, &points, dimensions).deviation;
        assert!(deviation < 1e-6, "{dimensions}: {deviation}");
    }
}

#[test]
fn points_of_space_come_back_from_far_away() {
    // Majorisation finds the points from a disturbed start, without classical scaling.
    let points = scattered(3 * 150);
    let distances = straight(&points, 3);
    let disturbed = points.iter().zip(scattered(2 * 450).split_off(450));
    let start = disturbed.map(|(a, b)| a + 0.6 * (b - 0.5)).collect();
    for extrapolate in [false, true] {
        let start = Start::Form(Vec::clone(&start));
        let options =
            options(3).with_start(start).with_extrapolation(extrapolate).with_tolerance(0.0);
        let form = canonical_form(&distances, &options).unwrap();
        assert!(form.stresses[0] > 1e-3 * f64::from(150 * 149 / 2));
        assert!(form.stress_1() < 2e-6, "{}", form.stress_1());
        assert!(align(&form.coordinates, &points, 3).deviation < 2e-6);
    }
}

#[test]
fn in_fewer_dimensions_the_widest_remain() {
    // The points fill a box of 9 x 3 x 0.01. The best form in the plane is close to the box without its thin side.
    let points: Vec<f64> =
        scattered(3 * 200).chunks(3).flat_map(|x| [9.0 * x[0], 3.0 * x[1], 0.01 * x[2]]).collect();
    let form = canonical_form(&straight(&points, 3), &options(2)).unwrap();
    let flat: Vec<f64> = points.chunks(3).flat_map(|x| [x[0], x[1]]).collect();
    assert!(align(&form.coordinates, &flat, 2).deviation < 1e-3);
}

/// Returns great-circle distances of the grid in benches/peers/smacof.py.
fn sphere() -> Distances {
    let (rows, cols) = (12, 15);
    let direction = |index: usize| {
        let along = |k: usize, count: usize| 2.0 * k as f64 / (count - 1) as f64 - 1.0;
        let latitude = (60.0 * along(index / cols, rows)).to_radians();
        let longitude = (100.0 * along(index % cols, cols)).to_radians();
        let (sin, cos) = longitude.sin_cos();
        DVec3::new(latitude.cos() * cos, latitude.cos() * sin, latitude.sin())
    };
    let points = rows * cols;
    let distance = |index: usize| {
        let (a, b) = (direction(index / points), direction(index % points));
        a.cross(b).length().atan2(a.dot(b)) as f32
    };
    Distances::new(points, (0..points * points).map(distance).collect()).unwrap()
}

/// Output of benches/peers/smacof.py with scikit-learn 1.9.1: the raw stress of the start, after one, two and
/// ten Guttman transforms, and at the end.
const SCIKIT_LEARN: [(usize, [f64; 5]); 2] = [
    (2, [14177.561915, 12235.919947, 11382.300841, 10074.939812, 283.456502]),
    (3, [15171.916765, 10523.632288, 9775.243902, 8401.970669, 200.532883]),
];

#[test]
fn stress_agrees_with_scikit_learns() {
    let distances = sphere();
    for (dimensions, expected) in SCIKIT_LEARN {
        let points = distances.points();
        let coordinate = |index: usize| {
            let (point, axis) = ((index / dimensions) as f64, (index % dimensions) as f64);
            (point * (axis + 1.0) + axis).sin()
        };
        let start = Start::Form((0..points * dimensions).map(coordinate).collect());
        let plain =
            options(dimensions).with_start(start).with_extrapolation(false).with_tolerance(0.0);
        let form = canonical_form(&distances, &plain).unwrap();
        for (iteration, expected) in [0, 1, 2, 10].into_iter().zip(expected) {
            let found = form.stresses[iteration];
            approx::assert_relative_eq!(found, expected, max_relative = 1e-5);
        }
        approx::assert_relative_eq!(form.raw_stress(), expected[4], max_relative = 1e-3);

        // The accelerated iteration from the same start ends in an equally low minimum.
        let fast = plain.with_extrapolation(true);
        let form = canonical_form(&distances, &fast).unwrap();
        assert!(form.raw_stress() < 1.001 * expected[4], "{dimensions}: {}", form.raw_stress());
    }
}

#[test]
fn stress_never_rises_and_extrapolation_takes_fewer_iterations() {
    let distances = sphere();
    for dimensions in [2, 3] {
        let form = |extrapolate| {
            let options = options(dimensions).with_extrapolation(extrapolate).with_tolerance(1e-7);
            canonical_form(&distances, &options).unwrap()
        };
        let (plain, fast) = (form(false), form(true));
        for form in [&plain, &fast] {
            assert!(form.converged);
            assert!(form.stresses.is_sorted_by(|before, after| before > after));
        }
        assert!(2 * fast.iterations() < plain.iterations());
        assert!(fast.raw_stress() < 1.0001 * plain.raw_stress());
    }
}

const SIDE: usize = 25;

fn surface(position: impl Fn(f64, f64) -> DVec3) -> Surface {
    let along = |k: usize| k as f64 / (SIDE - 1) as f64;
    let positions =
        (0..SIDE * SIDE).map(|index| position(along(index % SIDE), along(index / SIDE)));
    Surface::from_positions(SIDE, SIDE, positions.collect()).unwrap()
}

fn form_of(surface: &Surface) -> Vec<f64> {
    let options = Options::default().with_wavefront(Wavefront::Curved);
    let (matrix, _) = Pairwise::new(surface, &options).unwrap().matrix(|_| ()).unwrap();
    let distances = Distances::new(surface.chart().points(), matrix).unwrap();
    let options = FormOptions::default().with_tolerance(1e-7);
    canonical_form(&distances, &options).unwrap().coordinates
}

/// Returns the bending of the catenoid (90 degrees) to the helicoid (0). All bendings are isometric to each
/// other. u is within a radian of the waist, and v spans three quarters of a turn.
fn catenoid_family(degrees: f64) -> Surface {
    let (sin, cos) = degrees.to_radians().sin_cos();
    surface(|u, v| {
        let (u, v) = (2.0 * u - 1.0, 1.5 * PI * (v - 0.5));
        let helicoid = DVec3::new(u.sinh() * v.sin(), -u.sinh() * v.cos(), v);
        let catenoid = DVec3::new(u.cosh() * v.cos(), u.cosh() * v.sin(), u);
        cos * helicoid + sin * catenoid
    })
}

/// Returns a bent sheet of 3 x 2. `direction` is its direction in radians at a fraction of its length.
fn sheet(direction: impl Fn(f64) -> f64) -> Surface {
    // The integral is computed by Simpson's rule on many short pieces.
    let point = |u: f64| {
        let pieces = 200;
        let step = u / f64::from(pieces);
        let (mut x, mut z) = (0.0, 0.0);
        for piece in 0..pieces {
            for (at, weight) in [(0.0, 1.0), (0.5, 4.0), (1.0, 1.0)] {
                let (sin, cos) = direction((f64::from(piece) + at) * step).sin_cos();
                (x, z) = (x + weight * cos * step / 6.0, z + weight * sin * step / 6.0);
            }
        }
        (3.0 * x, 3.0 * z)
    };
    surface(|u, v| {
        let (x, z) = point(u);
        DVec3::new(x, 2.0 * v, z)
    })
}

fn deviation(a: &[f64], b: &[f64]) -> f64 {
    align(a, b, 3).deviation
}

#[test]
fn bendings_share_a_form_and_other_surfaces_do_not() {
    let flat = sheet(|_| 0.0);
    let sheets = [
        flat,
        // Half a cylinder, an S, and a roll that tightens.
        sheet(|u| PI * u),
        sheet(|u| 1.2 * (2.0 * PI * u).sin()),
        sheet(|u| 4.0 * u * u),
    ]
    .map(|surface| form_of(&surface));
    let family = [0.0, 35.0, 90.0].map(|degrees| form_of(&catenoid_family(degrees)));
    let sphere = form_of(&surface(|u, v| {
        let (sin, cos) = (FRAC_PI_2 * (2.0 * u - 1.0)).sin_cos();
        let (sin_v, cos_v) = (v - 0.5).sin_cos();
        1.5 * DVec3::new(cos * cos_v, sin * cos_v, sin_v)
    }));

    let mut alike = 0.0f64;
    for (bendings, name) in [(&sheets[..], "sheet"), (&family[..], "catenoid")] {
        for (index, form) in bendings.iter().enumerate().skip(1) {
            let deviation = deviation(form, &bendings[0]);
            println!("{name} {index}: {deviation:.2e}");
            alike = alike.max(deviation);
        }
    }
    let mut different = f64::INFINITY;
    for (a, b) in [(&sheets[0], &family[0]), (&sheets[0], &sphere), (&family[0], &sphere)] {
        // Sizes are not compared: one form is scaled to the other's size.
        let size = |form: &[f64]| form.iter().map(|x| x * x).sum::<f64>().sqrt();
        let scale = size(b) / size(a);
        let scaled: Vec<f64> = a.iter().map(|x| scale * x).collect();
        let deviation = deviation(&scaled, b);
        println!("different: {deviation:.2e}");
        different = different.min(deviation);
    }
    // Measured: at most 2.8e-3 between bendings, due to the coarse grid's errors of the distances, and at
    // least 0.28 between different surfaces.
    assert!(different > 50.0 * alike, "alike {alike}, different {different}");
}

#[test]
fn the_same_to_the_bit_for_any_number_of_threads() {
    let distances = sphere();
    let form = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| canonical_form(&distances, &options(3)).unwrap())
    };
    assert_eq!(form(1), form(3));
}

#[test]
fn options_out_of_range_are_refused() {
    let distances = straight(&scattered(3 * 4), 3);
    let refused = |options: FormOptions| canonical_form(&distances, &options).unwrap_err();
    let few = CanonicalError::TooFewPoints { points: 4, dimensions: 4 };
    assert_eq!(refused(options(4)), few);
    assert!(refused(options(0)).to_string().contains("at least one dimension"));
    for tolerance in [-0.1, 1.0, f64::NAN] {
        let error = refused(options(2).with_tolerance(tolerance));
        assert!(error.to_string().contains("not in the range"), "{error}");
    }
    let start = |start: Vec<f64>| options(2).with_start(Start::Form(start));
    let size = CanonicalError::StartSize { found: 7, points: 4, dimensions: 2 };
    assert_eq!(refused(start(vec![0.0; 7])), size);
    let mut coordinates = vec![0.0; 8];
    coordinates[5] = f64::NAN;
    assert_eq!(refused(start(coordinates)), CanonicalError::StartNotFinite { point: 2, axis: 1 });
}
