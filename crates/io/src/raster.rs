//! Reads rasters of numbers with a location: GeoTIFF and ESRI ASCII grids.

use std::path::Path;

use super::file_spacing::FileSpacing;
use super::sidecars::{Auxiliary, world_file};
use super::tiff::{self, Beside, Location, Raster, Role};
use super::{GeoTags, Grid, IoError, ascii_grid, extension, read_beside, read_bytes, with_suffix};

/// Reads numbers. They are NaN where the file has no data.
pub(super) fn read_values(path: &Path) -> Result<Raster, IoError> {
    read(path, Role::Values)
}

/// Reads a mask as numbers. Indices into a table of colours are accepted, since only zero matters.
pub(super) fn read_mask(path: &Path) -> Result<Grid<f64>, IoError> {
    read(path, Role::Mask).map(|raster| raster.grid)
}

fn read(path: &Path, role: Role) -> Result<Raster, IoError> {
    let bytes = read_bytes(path)?;
    let auxiliary = Auxiliary::beside(path)?;
    let raster = match extension(path).as_str() {
        "asc" => {
            let projection = read_beside(&path.with_extension("prj"))?;
            ascii_grid(&bytes, projection.as_deref(), &auxiliary)
        }
        _ => {
            // GDAL stores masks in a file of this name if they are not in the raster's own file.
            let mask = read_beside(&with_suffix(path, ".msk"))?;
            let beside = Beside { mask: mask.as_deref(), world: world_file(path)?, auxiliary };
            tiff::decode(path, &bytes, beside, role)
        }
    };
    raster.map_err(|reason| IoError::content(path, reason))
}

/// Decodes a grid. As in GDAL, auxiliary metadata scale its values and name their unit, but do not place it.
fn ascii_grid(
    bytes: &[u8],
    projection: Option<&[u8]>,
    auxiliary: &Auxiliary,
) -> Result<Raster, String> {
    let projection = projection.map(String::from_utf8_lossy);
    let ascii_grid::AsciiGrid { grid, spacing, georeference, ellipsoid, metres } =
        ascii_grid::decode(bytes, projection.as_deref())?;
    let (scale, offset) = (auxiliary.scale.unwrap_or(1.0), auxiliary.offset.unwrap_or(0.0));
    let grid = grid.map(|value| value * scale + offset);
    let (spacing, metres) = match auxiliary
        .unit
        .as_deref()
        .map(|unit| (unit, tiff::metres_of_unit(unit)))
    {
        None | Some((_, Some(1.0))) => (spacing, Ok(metres)),
        Some((unit, length)) => {
            let why = format!("its .aux.xml gives its values in the unit {unit}");
            let metres = length.ok_or_else(|| format!("{why}, which is not known"));
            (FileSpacing::Unusable(format!("{why}, and its cell size may be in another")), metres)
        }
    };
    Ok(Raster {
        grid: Grid { georeference: georeference.as_ref().ok().copied(), ..grid },
        spacing,
        location: Location {
            geo_tags: Some(georeference.as_ref().map(GeoTags::new).unwrap_or_default()),
            georeference,
            ellipsoid,
            metres,
        },
        unreached: false,
    })
}
