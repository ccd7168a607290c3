//! Provides the surfaces of benchmarks: built-in surfaces, real terrain, and the user's own files.

use std::error::Error;
use std::fmt::{self, Display, Formatter};
use std::path::PathBuf;

use geosweep::io::SurfaceFile;
use geosweep::shown::excerpt;
use geosweep::surface::builtin::Builtin;
use geosweep::{Spacing, Surface};

/// A surface that can be made at any size, or a file of a fixed size.
#[derive(Clone, Debug, PartialEq)]
pub enum BenchSurface {
    Builtin(Builtin),
    /// The elevation model in examples/data. Its roughness from point to point is the same at every size: a
    /// small surface is the north-western corner of the model, and a surface larger than the model mirrors
    /// the model at its borders.
    Terrain,
    File(PathBuf),
}

const TERRAIN: &str = "terrain";
const ELEVATIONS: &[u8] = include_bytes!("../../../../examples/data/jacksboro.png");
/// The spacing of the elevation model; see examples/data/README.md.
const ELEVATION_SPACING: Spacing = Spacing { dx: 74.573, dy: 92.475 };

impl BenchSurface {
    pub fn default_set() -> Vec<Self> {
        let builtins = [Builtin::Plane, Builtin::Sphere, Builtin::Peaks, Builtin::Maze];
        builtins.map(Self::Builtin).into_iter().chain([Self::Terrain]).collect()
    }

    pub fn quick_set() -> Vec<Self> {
        [Builtin::Sphere, Builtin::Maze].map(Self::Builtin).to_vec()
    }

    pub fn names() -> String {
        format!("{}, {TERRAIN}", Builtin::names())
    }

    /// Parses a name or the path of an existing file.
    pub fn parse(text: &str) -> Result<Self, String> {
        if text == TERRAIN {
            return Ok(Self::Terrain);
        }
        match text.parse() {
            Ok(builtin) => Ok(Self::Builtin(builtin)),
            Err(_) if PathBuf::from(text).is_file() => Ok(Self::File(text.into())),
            Err(_) => Err(format!(
                "`{}` is neither a file nor one of the surfaces {}",
                excerpt(text),
                Self::names()
            )),
        }
    }

    /// Returns the sizes to solve at: the requested ones, or the size of the file.
    pub fn sizes(&self, asked: &[usize]) -> Vec<Option<usize>> {
        match self {
            Self::File(_) => vec![None],
            _ => asked.iter().copied().map(Some).collect(),
        }
    }

    /// Returns the surface with `side` points per side. `None` stands for a file's own size.
    pub fn surface(&self, side: Option<usize>) -> Result<Surface, Box<dyn Error>> {
        match (self, side) {
            (Self::Builtin(builtin), Some(side)) => Ok(builtin.surface(side, side)?),
            (Self::Terrain, Some(side)) => terrain(side),
            (Self::File(path), _) => Ok(SurfaceFile::read(path)?.into_surface(None)?),
            (_, None) => unreachable!("only files have a size of their own"),
        }
    }

    /// Returns the row and column of the source. It lies near a corner, so that the wavefront crosses the
    /// whole grid. In the maze it lies at the beginning of the corridor.
    pub fn source(&self, surface: &Surface) -> (usize, usize) {
        let wanted = match self {
            Self::Builtin(Builtin::Maze) => (0, 0),
            _ => (surface.rows() / 20, surface.cols() / 20),
        };
        let chart = surface.chart();
        let first = chart.index(wanted.0, wanted.1);
        let mut from_there = (first..chart.points()).chain(0..first);
        let there = from_there.find(|&index| surface.present()[index]);
        chart.position(there.expect("a surface has a point"))
    }
}

impl Display for BenchSurface {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Builtin(builtin) => builtin.fmt(f),
            Self::Terrain => f.write_str(TERRAIN),
            Self::File(path) => path.display().fmt(f),
        }
    }
}

fn terrain(side: usize) -> Result<Surface, Box<dyn Error>> {
    let mut reader = png::Decoder::new(std::io::Cursor::new(ELEVATIONS)).read_info()?;
    let mut bytes = vec![0; reader.output_buffer_size().ok_or("the picture is too large")?];
    let picture = reader.next_frame(&mut bytes)?;
    let (rows, cols) = (picture.height as usize, picture.width as usize);
    let elevations: Vec<_> = bytes.as_chunks().0.iter().map(|b| u16::from_be_bytes(*b)).collect();
    let heights = (0..side * side).map(|index| {
        let (row, col) = (mirrored(index / side, rows), mirrored(index % side, cols));
        elevations[row * cols + col].into()
    });
    Ok(Surface::from_heights(side, side, heights.collect(), ELEVATION_SPACING)?)
}

/// Returns the index below `count` to which an index is reflected by mirrors at 0 and at the last index.
fn mirrored(index: usize, count: usize) -> usize {
    let last = count - 1;
    last.abs_diff((index + last) % (2 * last))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mirrors_leave_no_step() {
        let seen: Vec<_> = (0..10).map(|index| mirrored(index, 4)).collect();
        assert_eq!(seen, [0, 1, 2, 3, 2, 1, 0, 1, 2, 3]);
    }

    #[test]
    fn terrain_is_the_elevation_model() {
        let surface = terrain(410).unwrap();
        let height = |row, col| surface.position(row, col).unwrap().z;
        let heights =
            |rows, cols| (0..rows).flat_map(move |row| (0..cols).map(move |col| (row, col)));
        let highest = heights(344, 403).map(|(row, col)| height(row, col)).fold(0.0, f64::max);
        assert_eq!(highest, 1076.0);
        assert_eq!(height(350, 400), height(336, 400));
        assert_eq!(height(100, 409), height(100, 395));
    }
}
