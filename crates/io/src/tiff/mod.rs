//! Reads TIFF rasters with the information of GeoTIFF and GDAL, and writes maps and fields of vectors.
//!
//! Files are read as GDAL reads them. An unsupported feature that changes values or locations is an error,
//! which contains the command that converts the file.

mod band;
mod compression;
mod cure;
mod directory;
mod gdal;
mod geo_spacing;
mod geo_tags;
mod layout;
mod write;

use std::path::Path;

use ::tiff::tags::{PhotometricInterpretation, Tag};

use band::read_band;
use cure::Cure;
use directory::{Directory, File};
use gdal::Metadata;
pub use geo_tags::GeoTags;
use layout::Layout;
pub(super) use write::{Pair32Float, encode};

use super::file_spacing::FileSpacing;
use super::limits::check_memory;
use super::sidecars::Auxiliary;
use super::{Georeference, Grid};
use geosweep_surface::Ellipsoid;

/// The values of a band. They are NaN where the file has no data.
pub(super) struct Raster {
    pub grid: Grid<f64>,
    pub spacing: FileSpacing,
    pub location: Location,
    /// Whether +infinity is the no-data value, as in maps that this crate writes.
    pub unreached: bool,
}

/// The location of a file's points, and the unit of its heights. Messages say what is missing.
#[derive(Clone, Debug)]
pub(super) struct Location {
    pub georeference: Result<Georeference, String>,
    pub geo_tags: Option<GeoTags>,
    /// The ellipsoid of longitudes and latitudes, if the file names it.
    pub ellipsoid: Result<Option<Ellipsoid>, String>,
    /// The length of the unit of heights in metres.
    pub metres: Result<f64, String>,
}

/// The purpose for which a raster is read.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    /// Measured numbers.
    Values,
    /// A mask, of which only zero and non-zero values are distinguished. Indices into a table of colours are accepted.
    Mask,
}

/// Bits of NewSubfileType: a smaller version of another picture, and a mask of another picture.
const REDUCED: u64 = 1;
const MASK: u64 = 4;

/// The metadata that GDAL stores beside a file.
pub(super) struct Beside<'a> {
    /// The content of `FILE.msk`.
    pub mask: Option<&'a [u8]>,
    /// The location in a world file, which counts if the file has none.
    pub world: Option<Georeference>,
    /// The metadata in `FILE.aux.xml`, which replace those in the file.
    pub auxiliary: Auxiliary,
}

/// Decodes the first picture of a file.
pub(super) fn decode(
    path: &Path,
    bytes: &[u8],
    beside: Beside,
    role: Role,
) -> Result<Raster, String> {
    let cure = Cure(path);
    let (file, first) = File::open(bytes)?;
    let directories = file.directories(first)?;
    let Some((main, others)) = directories.split_first() else {
        return Err("is not a usable TIFF file: it holds no picture".into());
    };
    let layout = Layout::read(main, &cure)?;
    if layout.photometric == PhotometricInterpretation::RGBPalette && role == Role::Values {
        return Err(format!(
            "holds indices into a table of colours; this makes grey levels of the colours: {}; \
             this takes the indices as values: gdal_calc.py -A {} --calc=A --outfile=plain.tif",
            cure.translate("-expand gray"),
            path.display()
        ));
    }
    check_memory::<[u64; 2]>(layout.rows * layout.cols)?;
    let metadata = Metadata::read(main, layout.sample)?;
    let metadata = metadata.replaced_by(&beside.auxiliary, layout.sample)?;
    let geo_tags = GeoTags::read(main)?.replaced_by(&beside);
    let mut values = values(&file, &layout, &metadata, &geo_tags)?;
    let mut hide = |point: usize, visible: bool| {
        if !visible {
            values[point] = f64::NAN;
        }
    };
    // As in GDAL, a no-data value takes precedence. The opacity then does not mark missing data.
    if let Some(alpha) = layout.alpha.filter(|_| !metadata.has_no_data()) {
        read_band(&file, &layout, alpha, |point, word| hide(point, word.is_some_and(|a| a != 0)))?;
    }
    for other in others {
        if other.integer(Tag::NewSubfileType)?.unwrap_or(0) & (REDUCED | MASK) == MASK {
            apply_mask(&file, other, (layout.rows, layout.cols), &cure, &mut hide)
                .map_err(|reason| format!("its mask: {reason}"))?;
        }
    }
    if let Some(bytes) = beside.mask {
        hide_by_mask(path, bytes, (layout.rows, layout.cols), |point| hide(point, false))?;
    }
    let grid = Grid::new(layout.rows, layout.cols, values);
    let unit = metadata.unit.as_deref();
    let (spacing, location) = (geo_tags.spacing(unit), geo_tags.location(unit));
    Ok(Raster {
        grid: Grid { georeference: location.georeference.as_ref().ok().copied(), ..grid },
        spacing,
        location,
        unreached: metadata.is_infinite(),
    })
}

/// Returns the values of the band that is not the opacity.
fn values(
    file: &File,
    layout: &Layout,
    metadata: &Metadata,
    geo_tags: &GeoTags,
) -> Result<Vec<f64>, String> {
    let [scale, offset] = match (metadata.scale, metadata.offset, geo_tags.vertical()?) {
        (None, None, None) => [1.0, 0.0],
        (None, None, Some(vertical)) => vertical,
        (scale, offset, None) => [scale.unwrap_or(1.0), offset.unwrap_or(0.0)],
        (_, _, Some(_)) => {
            return Err("scales its values twice, by GDAL_METADATA and by ModelPixelScale; \
                        gdal_edit.py -unsetscale -unsetoffset takes the first out"
                .into());
        }
    };
    let unscaled = [scale, offset] == [1.0, 0.0];
    let mut values = vec![f64::NAN; layout.rows * layout.cols];
    let mut stored = false;
    let band = usize::from(layout.alpha == Some(0));
    read_band(file, layout, band, |point, word| {
        stored |= word.is_some();
        // Values that were never written are "no data", or 0 if there is no such value.
        let value = match word {
            Some(word) if metadata.is_no_data(word, layout.sample) => return,
            Some(word) => layout.sample.value(word),
            None if metadata.has_no_data() => return,
            None => 0.0,
        };
        values[point] = if unscaled { value } else { value * scale + offset };
    })?;
    match stored {
        true => Ok(values),
        false => Err("holds no values: all its strips or tiles are left out (SPARSE_OK)".into()),
    }
}

/// Calls `hide` with the index of each point that a mask in a file beside the raster hides: `FILE.msk`, a TIFF file.
pub(super) fn hide_by_mask(
    path: &Path,
    mask: &[u8],
    size: (usize, usize),
    mut hide: impl FnMut(usize),
) -> Result<(), String> {
    let mut apply = || {
        let (file, first) = File::open(mask)?;
        let directories = file.directories(first)?;
        let mask = directories.first().ok_or("holds no picture")?;
        let mut hide_unless = |point, visible: bool| {
            if !visible {
                hide(point);
            }
        };
        apply_mask(&file, mask, size, &Cure(path), &mut hide_unless)
    };
    apply().map_err(|reason| format!("its mask {}.msk: {reason}", path.display()))
}

/// Calls `hide` with the index of each grid point and whether the mask shows the point.
fn apply_mask(
    file: &File,
    directory: &Directory,
    size: (usize, usize),
    cure: &Cure,
    hide: &mut impl FnMut(usize, bool),
) -> Result<(), String> {
    let layout = Layout::read(directory, cure)?;
    if (layout.rows, layout.cols) != size {
        let (rows, cols) = size;
        return Err(format!(
            "has {} x {} points, the picture {rows} x {cols}",
            layout.rows, layout.cols
        ));
    }
    read_band(file, &layout, 0, |point, word| hide(point, word.is_some_and(|word| word != 0)))
}
