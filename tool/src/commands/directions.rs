//! Writes the directions, nearest sources and log map of a distance map, and gives distances a sign.

use std::borrow::Cow;
use std::error::Error;
use std::path::{Path, PathBuf};

use clap::ValueEnum;
use geosweep::DistanceMap;
use geosweep::geometry::{
    BackDirections, LogMap, Nearest, signed_distances, signed_distances_by_mask,
    signed_distances_to_polygons,
};
use geosweep::io::{Orientation, OutputFile, StagedFile, read_mask};
use geosweep::surface::{EdgeLengths, Real};

use super::labels::{Values, grid_output, stage_values};
use crate::output::{png_output, stage_picture};
use crate::picture::Arrows;
use crate::precision::Number;
use crate::problem::{GivenSources, Scene};
use crate::terminal::Spinner;

/// The arguments for outputs beside the map.
#[derive(clap::Args)]
#[command(group = clap::ArgGroup::new("directions").multiple(true))]
pub struct DirectionArgs {
    /// Output file for the direction of the way back at each point: .npy or .tif, float32. It is 0 at the
    /// sources and -1 (no-data) where no source reaches
    #[arg(long, value_name = "FILE", group = "directions", help_heading = "Directions")]
    back_direction: Option<PathBuf>,
    /// Convention of --back-direction and --source-direction. North and east are those of the map if SURFACE is
    /// georeferenced. Otherwise rows run to the south and columns to the east
    #[arg(long, value_enum, default_value_t, help_heading = "Directions")]
    direction_format: DirectionFormat,
    /// Output file for the next grid point on the way back: .npy or .tif, int32, with ArcGIS' codes. 0 is a
    /// source, 1 to 8 are the neighbours clockwise from east, -1 (no-data) is not reached
    #[arg(long, value_name = "FILE", group = "directions", help_heading = "Directions")]
    back_link: Option<PathBuf>,
    /// Output file for the index of the nearest source, in the order of `voronoi`: .npy or .tif, int32, with
    /// -1 (no-data) where no source reaches. If all sources are cells of rasters of whole numbers, the value of the
    /// nearest cell
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
    /// curves. The inside of a polygon is its own, whichever way its rings run. The inside of another curve is on its
    /// left: on the map if the curve is in map coordinates, otherwise with rows downwards
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

/// An output in addition to the map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    BackDirection,
    BackLink,
    Nearest,
    SourceDirection,
    LogMap,
    Picture,
}

/// The files to write. They are checked before the computation starts.
pub struct DirectionOutputs {
    format: DirectionFormat,
    files: Vec<(Kind, OutputFile)>,
}

impl DirectionArgs {
    /// Returns the requested outputs: the kind, the option, what is written, and the file.
    fn wanted(&self) -> impl Iterator<Item = (Kind, &'static str, &'static str, &PathBuf)> {
        [
            (Kind::BackDirection, "--back-direction", "directions are", &self.back_direction),
            (Kind::BackLink, "--back-link", "back links are", &self.back_link),
            (Kind::Nearest, "--nearest", "nearest sources are", &self.nearest),
            (Kind::SourceDirection, "--source-direction", "directions are", &self.source_direction),
            (Kind::LogMap, "--log-map", "a log map is", &self.log_map),
            (Kind::Picture, "--direction-picture", "a picture is", &self.direction_picture),
        ]
        .into_iter()
        .filter_map(|(kind, option, what, path)| Some((kind, option, what, path.as_ref()?)))
    }

    pub fn outputs(&self) -> Result<DirectionOutputs, Box<dyn Error>> {
        let format = self.direction_format;
        if format == DirectionFormat::Vector && self.source_direction.is_some() {
            return Err("--source-direction is in degrees; choose --direction-format compass or \
                        grass, or write --log-map, which has vectors"
                .into());
        }
        let file = |(kind, _, what, path): (_, _, _, &PathBuf)| {
            let file =
                if kind == Kind::Picture { png_output(path) } else { grid_output(path, what) };
            Ok((kind, file?))
        };
        Ok(DirectionOutputs {
            format,
            files: self.wanted().map(file).collect::<Result<_, Box<dyn Error>>>()?,
        })
    }

    /// Refuses directions on surfaces that have none.
    pub fn check(&self, scene: &Scene) -> Result<(), String> {
        for (kind, option, ..) in self.wanted() {
            scene.refuse_directions(option)?;
            let is_on_map = match kind {
                Kind::BackDirection | Kind::SourceDirection => {
                    self.direction_format != DirectionFormat::Vector
                }
                Kind::BackLink | Kind::Picture => true,
                Kind::Nearest | Kind::LogMap => false,
            };
            let orientation = if is_on_map { scene.orientation() } else { Ok(None) };
            let check = orientation.and_then(|orientation| match orientation {
                Some(orientation) if kind == Kind::BackLink => orientation.link(1).map(drop),
                _ => Ok(()),
            });
            check.map_err(|why| format!("{option}: {why}"))?;
        }
        Ok(())
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

    /// Returns the distances at the given points, selected from those at all points of the surface's grid, with a sign
    /// if requested. `sources` lie on the surface's grid.
    pub fn of<'a, R: Real>(
        &self,
        scene: &Scene,
        sources: &GivenSources,
        distances: &'a [R],
    ) -> Result<Cow<'a, [R]>, Box<dyn Error>> {
        if self.needs_curves() {
            let surface = &scene.surface;
            let signed = match sources.are_polygons {
                true => signed_distances_to_polygons(surface, sources, distances)?,
                false => signed_distances(surface, sources, distances)?,
            };
            return Ok(scene.crop(&signed).into_owned().into());
        }
        let (chart, distances) = (scene.chart(), scene.crop(distances));
        let Some(path) = &self.inside else { return Ok(distances) };
        let place = scene.georeference.as_ref().ok();
        let inside = read_mask(path)?.fit_surface(path, chart.rows, chart.cols, place)?;
        Ok(signed_distances_by_mask(chart, &distances, &inside)?.into())
    }
}

impl DirectionOutputs {
    pub fn files(&self) -> impl Iterator<Item = &OutputFile> {
        self.files.iter().map(|(_, file)| file)
    }

    /// Writes all files. They do not have their final names yet.
    pub fn stage<R: Number>(
        self,
        scene: &Scene,
        sources: &GivenSources,
        map: &DistanceMap<R>,
    ) -> Result<Vec<StagedFile>, Box<dyn Error>> {
        if self.files.is_empty() {
            return Ok(Vec::new());
        }
        let map = map.to_single();
        let surface = &scene.surface;
        // Directions are found on the grid. Here alone they are turned to those of the map.
        let orientation = scene.orientation().unwrap_or_default();
        let on_map = |turn: fn(&Orientation, f32) -> f32, angles: Vec<f32>| match &orientation {
            Some(orientation) => angles.into_iter().map(|angle| turn(orientation, angle)).collect(),
            None => angles,
        };
        let edges = EdgeLengths::new(surface)?;
        let spinner = Spinner::new("finding directions");
        let wants = |kinds: &[Kind]| self.files.iter().any(|(kind, _)| kinds.contains(kind));
        let ways = wants(&[Kind::BackDirection, Kind::BackLink, Kind::Picture])
            .then(|| BackDirections::new(surface, &edges, sources, &map.distances))
            .transpose()?;
        let ways = || ways.as_ref().expect("these outputs want it");
        let log_map = wants(&[Kind::SourceDirection, Kind::LogMap])
            .then(|| LogMap::new(surface, sources))
            .transpose()?;
        let log_map = log_map.map(|log_map| log_map.where_reached(&map.distances));
        let log_map = || log_map.as_ref().expect("these outputs want it");
        drop(spinner);
        let stage = |(kind, output): (Kind, OutputFile)| {
            let (compass, grass) = (Orientation::compass, Orientation::grass);
            let angles = match (kind, self.format) {
                (Kind::BackDirection, DirectionFormat::Compass) => {
                    on_map(compass, ways().compass())
                }
                (Kind::BackDirection, DirectionFormat::Grass) => on_map(grass, ways().grass()),
                (Kind::SourceDirection, DirectionFormat::Grass) => {
                    on_map(grass, log_map().source_grass(surface))
                }
                (Kind::SourceDirection, _) => on_map(compass, log_map().source_compass(surface)),
                _ => Vec::new(),
            };
            let (labels, vectors);
            let values = match kind {
                Kind::BackDirection if self.format == DirectionFormat::Vector => {
                    vectors = ways().in_chart();
                    Values::Vectors(&vectors)
                }
                Kind::BackDirection | Kind::SourceDirection => Values::Bearings(&angles),
                Kind::BackLink => {
                    let links = ways().links().into_iter().map(i32::from);
                    let on_map = |link| match &orientation {
                        Some(orientation) => orientation.link(link),
                        None => Ok(link),
                    };
                    labels = links.map(on_map).collect::<Result<Vec<_>, _>>()?;
                    Values::Labels(&labels)
                }
                Kind::Nearest => {
                    let nearest = Nearest::new(surface, &edges, sources, &map.distances)?.sources;
                    let label = |source: i32| {
                        usize::try_from(source).map_or(source, |at| sources.label(at))
                    };
                    labels = nearest.into_iter().map(label).collect::<Vec<_>>();
                    Values::Labels(&labels)
                }
                Kind::LogMap => Values::Vectors(&log_map().coordinates),
                Kind::Picture => {
                    let picture = Arrows {
                        surface,
                        shape: scene.shape(),
                        sources,
                        values: &map.distances,
                        directions: &ways().in_chart(),
                        bearings: &on_map(compass, ways().compass()),
                    };
                    return Ok(stage_picture(output, || picture.draw())?);
                }
            };
            Ok(stage_values(output, scene, values)?)
        };
        self.files.into_iter().map(stage).collect()
    }
}
