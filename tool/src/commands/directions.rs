//! Writes the directions, nearest sources and log map of a distance map, and gives distances a sign.

use std::borrow::Cow;
use std::error::Error;
use std::path::{Path, PathBuf};

use clap::ValueEnum;
use geosweep::geometry::{
    BackDirections, LogMap, Nearest, signed_distances, signed_distances_by_mask,
};
use geosweep::io::{
    OutputFile, StagedFile, read_mask, write_bearings_tiff, write_labels_tiff, write_npy,
    write_vectors_tiff,
};
use geosweep::surface::{EdgeLengths, Real};
use geosweep::{DistanceMap, Sources};

use super::labels::has_extension;
use crate::output::{stage_picture, wanted_png};
use crate::picture::Arrows;
use crate::precision::Number;
use crate::problem::Scene;
use crate::terminal::Spinner;

/// The arguments for outputs beside the map.
#[derive(clap::Args)]
#[command(group = clap::ArgGroup::new("directions").multiple(true))]
pub struct DirectionArgs {
    /// Output file for the direction of the way back at each point: .npy or .tif, float32. It is 0 at the
    /// sources and -1 (no-data) where no source reaches
    #[arg(long, value_name = "FILE", group = "directions", help_heading = "Directions")]
    back_direction: Option<PathBuf>,
    /// Convention of --back-direction and --source-direction
    #[arg(long, value_enum, default_value_t, help_heading = "Directions")]
    direction_format: DirectionFormat,
    /// Output file for the next grid point on the way back: .npy or .tif, int32, with ArcGIS' codes. 0 is a
    /// source, 1 to 8 are the neighbours clockwise from east, -1 (no-data) is not reached
    #[arg(long, value_name = "FILE", group = "directions", help_heading = "Directions")]
    back_link: Option<PathBuf>,
    /// Output file for the index of the nearest source, in the order of `voronoi`: .npy or .tif, int32, with
    /// -1 (no-data) where no source reaches
    #[arg(long, value_name = "FILE", group = "directions", help_heading = "Directions")]
    nearest: Option<PathBuf>,
    /// Output file for the direction in which the way of each point leaves its source, which must be a point,
    /// in the format of --back-direction
    #[arg(long, value_name = "FILE", group = "directions", help_heading = "Directions")]
    source_direction: Option<PathBuf>,
    /// Output file for the log map of point sources: .npy (M, N, 2) or .tif of two bands, float32. It has u and v, the
    /// direction in which the way of each point leaves its source times the distance; u runs to larger columns at the
    /// source, v at a right angle to it, to larger rows. NaN where no source reaches. Takes nine maps in double
    /// precision on the CPU
    #[arg(long, value_name = "FILE", group = "directions", help_heading = "Directions")]
    log_map: Option<PathBuf>,
    /// Draw the way back at each point, as colours and arrows
    #[arg(long, value_name = "FILE.png", group = "directions", help_heading = "Directions")]
    direction_picture: Option<PathBuf>,
    #[command(flatten)]
    pub sign: SignArgs,
}

/// The arguments for the sign of distances.
#[derive(clap::Args)]
pub struct SignArgs {
    /// Write distances with a sign, positive outside and negative inside of the sources, which must be closed
    /// curves. The inside is on the left of a curve, with rows downwards: a counter-clockwise curve surrounds
    /// it
    #[arg(long, requires = "output", help_heading = "Directions")]
    signed: bool,
    /// Mask of the inside, non-zero there, in place of the curves' directions; a mask as for --mask
    #[arg(long, value_name = "FILE", requires = "signed", help_heading = "Directions")]
    inside: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum DirectionFormat {
    /// Degrees clockwise from north, above 0 and up to 360: ArcGIS' back direction
    #[default]
    Compass,
    /// Degrees counter-clockwise from east, above 0 and up to 360: for r.path of GRASS
    Grass,
    /// Rows and columns of a step of length 1 in the grid: .npy (M, N, 2) or .tif of two bands, 0 at the sources
    /// and NaN (no-data) where no source reaches
    Vector,
}

/// The files to write. They are checked before the computation starts.
pub struct DirectionOutputs {
    format: DirectionFormat,
    back_direction: Option<OutputFile>,
    back_link: Option<OutputFile>,
    nearest: Option<OutputFile>,
    source_direction: Option<OutputFile>,
    log_map: Option<OutputFile>,
    picture: Option<OutputFile>,
}

impl DirectionArgs {
    pub fn outputs(&self) -> Result<DirectionOutputs, Box<dyn Error>> {
        let format = self.direction_format;
        let grid = |path: &Option<PathBuf>, what| {
            path.as_ref().map(|path| grid_output(path, what)).transpose()
        };
        if format == DirectionFormat::Vector && self.source_direction.is_some() {
            return Err("--source-direction is in degrees; choose --direction-format compass or \
                        grass, or write --log-map, which has vectors"
                .into());
        }
        Ok(DirectionOutputs {
            format,
            back_direction: grid(&self.back_direction, "directions are")?,
            back_link: grid(&self.back_link, "back links are")?,
            nearest: grid(&self.nearest, "nearest sources are")?,
            source_direction: grid(&self.source_direction, "directions are")?,
            log_map: grid(&self.log_map, "a log map is")?,
            picture: wanted_png(self.direction_picture.as_ref())?,
        })
    }

    /// Refuses directions on surfaces that have none.
    pub fn check(&self, scene: &Scene) -> Result<(), String> {
        let wanted = [
            ("--back-direction", self.back_direction.is_some()),
            ("--back-link", self.back_link.is_some()),
            ("--nearest", self.nearest.is_some()),
            ("--source-direction", self.source_direction.is_some()),
            ("--log-map", self.log_map.is_some()),
            ("--direction-picture", self.direction_picture.is_some()),
        ];
        let first = wanted.into_iter().find(|(_, is_wanted)| *is_wanted);
        first.map_or(Ok(()), |(what, _)| scene.refuse_directions(what))
    }

    /// Returns the input file of these arguments, the mask of the inside.
    pub fn input(&self) -> Option<&Path> {
        self.sign.inside.as_deref()
    }
}

impl SignArgs {
    /// Returns whether the sign depends on the sides of curves.
    fn needs_curves(&self) -> bool {
        self.signed && self.inside.is_none()
    }

    /// Returns the distances of the given points, of those of all points of the surface's grid, with a sign if that is
    /// wanted. `sources` lie on the surface's grid.
    pub fn of<'a, R: Real>(
        &self,
        scene: &Scene,
        sources: &Sources,
        distances: &'a [R],
    ) -> Result<Cow<'a, [R]>, Box<dyn Error>> {
        if self.needs_curves() {
            let signed = signed_distances(&scene.surface, sources, distances)?;
            return Ok(scene.crop(&signed).into_owned().into());
        }
        let (chart, distances) = (scene.chart(), scene.crop(distances));
        let Some(path) = &self.inside else { return Ok(distances) };
        let place = scene.georeference.as_ref().ok();
        let inside = read_mask(path)?.fit_surface(path, chart.rows, chart.cols, place)?;
        Ok(signed_distances_by_mask(chart, &distances, &inside)?.into())
    }
}

/// Returns the output file for numbers at each point.
fn grid_output(path: &Path, what: &str) -> Result<OutputFile, Box<dyn Error>> {
    if !has_extension(path, &["npy", "tif", "tiff"]) {
        let name = path.display();
        return Err(format!("{name}: {what} written as .npy or .tif; choose such a name").into());
    }
    Ok(OutputFile::new(path)?)
}

impl DirectionOutputs {
    pub fn files(&self) -> impl Iterator<Item = &OutputFile> {
        let Self { back_direction, back_link, nearest, source_direction, log_map, picture, .. } =
            self;
        [back_direction, back_link, nearest, source_direction, log_map, picture]
            .into_iter()
            .flatten()
    }

    /// Writes all files. They do not have their final names yet.
    pub fn stage<R: Number>(
        self,
        scene: &Scene,
        sources: &Sources,
        map: &DistanceMap<R>,
    ) -> Result<Vec<StagedFile>, Box<dyn Error>> {
        let mut staged = Vec::new();
        if self.files().next().is_none() {
            return Ok(staged);
        }
        let map = map.to_single();
        let surface = &scene.surface;
        let edges = EdgeLengths::new(surface)?;
        let spinner = Spinner::new("finding directions");
        let is_back = self.back_direction.is_some() || self.back_link.is_some();
        let ways = (is_back || self.picture.is_some())
            .then(|| BackDirections::new(surface, &edges, sources, &map.distances))
            .transpose()?;
        let is_log = self.log_map.is_some() || self.source_direction.is_some();
        let log_map = is_log.then(|| LogMap::new(surface, sources)).transpose()?;
        let log_map = log_map.map(|log_map| log_map.where_reached(&map.distances));
        drop(spinner);
        let write = Write { scene };
        if let Some((output, ways)) = self.back_direction.zip(ways.as_ref()) {
            staged.push(match self.format {
                DirectionFormat::Compass => write.bearings(output, &ways.compass())?,
                DirectionFormat::Grass => write.bearings(output, &ways.grass())?,
                DirectionFormat::Vector => write.vectors(output, &ways.in_chart())?,
            });
        }
        if let Some((output, ways)) = self.back_link.zip(ways.as_ref()) {
            let links: Vec<i32> = ways.links().into_iter().map(i32::from).collect();
            staged.push(write.labels(output, &links)?);
        }
        if let Some(output) = self.nearest {
            let nearest = Nearest::new(surface, &edges, sources, &map.distances)?;
            staged.push(write.labels(output, &nearest.sources)?);
        }
        if let Some((output, log_map)) = self.source_direction.zip(log_map.as_ref()) {
            staged.push(match self.format {
                DirectionFormat::Grass => write.bearings(output, &log_map.source_grass(surface))?,
                _ => write.bearings(output, &log_map.source_compass(surface))?,
            });
        }
        if let Some((output, log_map)) = self.log_map.zip(log_map.as_ref()) {
            staged.push(write.vectors(output, &log_map.coordinates)?);
        }
        if let Some((output, ways)) = self.picture.zip(ways.as_ref()) {
            let picture = Arrows {
                surface,
                shape: scene.shape(),
                sources,
                values: &map.distances,
                directions: &ways.in_chart(),
                bearings: &ways.compass(),
            };
            staged.push(stage_picture(output, || picture.draw())?);
        }
        Ok(staged)
    }
}

/// A writer of values at the given points. Its methods take values at all points of a map.
struct Write<'a> {
    scene: &'a Scene,
}

impl Write<'_> {
    fn shape(&self) -> [usize; 2] {
        [self.scene.chart().rows, self.scene.chart().cols]
    }

    fn bearings(&self, output: OutputFile, bearings: &[f32]) -> Result<StagedFile, Box<dyn Error>> {
        let ([rows, cols], bearings) = (self.shape(), &self.scene.crop(bearings));
        let is_array = has_extension(output.path(), &["npy"]);
        Ok(output.stage(|writer| match is_array {
            true => write_npy(writer, &[rows, cols], bearings),
            false => {
                write_bearings_tiff(writer, rows, cols, bearings, self.scene.geo_tags.as_ref())
            }
        })?)
    }

    fn labels(&self, output: OutputFile, labels: &[i32]) -> Result<StagedFile, Box<dyn Error>> {
        let ([rows, cols], labels) = (self.shape(), &self.scene.crop(labels));
        let is_array = has_extension(output.path(), &["npy"]);
        Ok(output.stage(|writer| match is_array {
            true => write_npy(writer, &[rows, cols], labels),
            false => write_labels_tiff(writer, rows, cols, labels, self.scene.geo_tags.as_ref()),
        })?)
    }

    fn vectors(
        &self,
        output: OutputFile,
        vectors: &[[f32; 2]],
    ) -> Result<StagedFile, Box<dyn Error>> {
        let ([rows, cols], vectors) = (self.shape(), &self.scene.crop(vectors));
        let is_array = has_extension(output.path(), &["npy"]);
        Ok(output.stage(|writer| match is_array {
            true => write_npy(writer, &[rows, cols, 2], vectors.as_flattened()),
            false => write_vectors_tiff(writer, rows, cols, vectors, self.scene.geo_tags.as_ref()),
        })?)
    }
}
