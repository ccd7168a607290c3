//! Implements `geosweep-lab figure canonical`: the paper's figure 8.

use std::error::Error;
use std::f64::consts::PI;
use std::path::PathBuf;
use std::process::ExitCode;

use geosweep::geometry::canonical::{Distances, FormOptions, align, canonical_form};
use geosweep::glam::DVec3;
use geosweep::pairwise::Pairwise;
use geosweep::surface::builtin::Builtin;
use geosweep::{Options, Surface, Wavefront};
use serde_json::json;

use geosweep_cli::numbers::whole;
use geosweep_cli::output::{commit, done, png_output, stage_picture};
use geosweep_cli::picture::{FormPicture, Tile, tiled};
use geosweep_cli::terminal::{List, Outcome, print_json, progress};

/// The arguments of `geosweep-lab figure canonical`.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Output file for the picture
    #[arg(short, long, value_name = "FILE.png")]
    output: PathBuf,
    /// Columns of each grid; the face has a quarter more rows
    #[arg(long, value_name = "N", default_value_t = 54, value_parser = whole("columns", 9..=110))]
    size: usize,
    /// Print one JSON object; docs/json.md and docs/geosweep.schema.json describe it
    #[arg(long)]
    json: bool,
}

const EXAMPLES: &str = "\
The upper row shows a face and three surfaces that bend into one another without
stretching: a helicoid, a catenoid and one between them. The lower row shows their
canonical forms, by least-squares scaling of all geodesic distances. Forms are rotated
so that they differ least. The three bendings have the same form, apart from errors of
the distances. The number under a form is its distance from the form of the helicoid,
as a fraction of its size (root mean squares).

Examples:
  geosweep-lab figure canonical -o canonical.png
  geosweep-lab figure canonical --size 33 --json -o canonical.png";

/// The width and height of a panel, in pixels.
const PANEL: [usize; 2] = [520, 460];
/// The angles of the bendings from helicoid (0) to catenoid (90), in degrees, with their titles.
const BENDINGS: [(f64, &str); 3] = [(0.0, "helicoid"), (45.0, "between both"), (90.0, "catenoid")];

/// A surface and its canonical form as the figure shows them.
struct Study {
    title: &'static str,
    surface: Surface,
    positions: Vec<DVec3>,
    form: Vec<DVec3>,
    stress_1: f64,
    deviation: Option<f64>,
    /// The directions from surface and form to the viewer.
    toward: [DVec3; 2],
    up: DVec3,
}

pub fn run(args: &Args) -> Outcome {
    let output = png_output(&args.output)?;
    let bar = progress(1 + BENDINGS.len());
    let face = Builtin::Face.surface(args.size * 5 / 4, args.size)?;
    bar.set_message("face");
    let mut studies = vec![Study::new("a face", face, None)?];
    studies[0].toward = [DVec3::new(0.5, -0.35, 1.0); 2];
    studies[0].up = -DVec3::Y;
    for (degrees, title) in BENDINGS {
        bar.inc(1);
        bar.set_message(title);
        let first = studies.get(1).map(|first| first.form.clone());
        studies.push(Study::new(title, bending(args.size, degrees)?, first.as_deref())?);
    }
    bar.finish_and_clear();

    let drawing = || {
        let rows: (Vec<_>, Vec<_>) = studies.iter().map(Study::tiles).unzip();
        tiled(&<[_; 2]>::from(rows))
    };
    done([], &commit([stage_picture(output, drawing)?])?);
    if args.json {
        let row = |study: &Study| {
            json!({
                "title": study.title,
                "points": study.surface.points(),
                "stress_1": study.stress_1,
                "deviation": study.deviation,
            })
        };
        let surfaces: Vec<_> = studies.iter().map(row).collect();
        print_json("figure canonical", &List("surfaces", &surfaces))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Returns a surface of Bonnet's bending from the helicoid to the catenoid, over three quarters of a turn.
fn bending(size: usize, degrees: f64) -> Result<Surface, geosweep::Error> {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let along = |k: usize| k as f64 / (size - 1) as f64 - 0.5;
    let position = |index: usize| {
        let (u, v) = (2.4 * along(index % size), 1.5 * PI * along(index / size));
        let helicoid = DVec3::new(u.sinh() * v.sin(), -u.sinh() * v.cos(), v);
        let catenoid = DVec3::new(u.cosh() * v.cos(), u.cosh() * v.sin(), u);
        cos * helicoid + sin * catenoid
    };
    Ok(Surface::from_positions(size, size, (0..size * size).map(position).collect())?)
}

impl Study {
    /// Computes a surface's form and aligns it with a given form, or else with the surface.
    fn new(
        title: &'static str,
        surface: Surface,
        onto: Option<&[DVec3]>,
    ) -> Result<Self, Box<dyn Error>> {
        let chart = surface.chart();
        let all: Vec<usize> = (0..chart.points()).collect();
        let positions: Vec<DVec3> = all
            .iter()
            .map(|&index| {
                let (row, col) = chart.position(index);
                surface.position(row, col).unwrap_or(DVec3::NAN)
            })
            .collect();
        let options = Options::default().with_wavefront(Wavefront::Curved);
        let (matrix, _) = Pairwise::new(&surface, &options)?.matrix(|_| ())?;
        let (distances, kept) = Distances::of_largest_piece(all.len(), matrix)?;
        let options = FormOptions::default().with_tolerance(1e-6);
        let form = canonical_form(&distances, &options)?;
        let fixed = onto.unwrap_or(&positions);
        let fixed: Vec<f64> = kept.iter().flat_map(|&index| fixed[index].to_array()).collect();
        let aligned = align(&form.coordinates, &fixed, form.dimensions);
        let mut placed = vec![DVec3::NAN; all.len()];
        for (&index, place) in kept.iter().zip(aligned.moved.as_chunks().0) {
            placed[index] = DVec3::from_array(*place);
        }
        Ok(Self {
            title,
            surface,
            positions,
            form: placed,
            stress_1: form.stress_1(),
            deviation: onto.map(|_| aligned.deviation),
            toward: [DVec3::new(1.0, -0.5, 0.55), DVec3::new(-1.0, 0.5, 0.55)],
            up: DVec3::Z,
        })
    }

    /// Draws the surface and its form, with their titles.
    fn tiles(&self) -> (Tile, Tile) {
        let tile = |title, heading, positions: &[DVec3], toward| Tile {
            title,
            heading,
            picture: FormPicture {
                positions: positions.to_vec().into(),
                chart: Some(self.surface.chart()),
                toward,
                up: self.up,
                size: PANEL,
            }
            .draw(),
        };
        let subtitle = match self.deviation {
            None => "its canonical form".into(),
            Some(deviation) => format!("its form, {deviation:.0e} of its size away"),
        };
        let [surface, form] = self.toward;
        (
            tile(self.title.into(), true, &self.positions, surface),
            tile(subtitle, false, &self.form, form),
        )
    }
}
