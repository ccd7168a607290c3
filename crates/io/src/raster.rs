//! Reads rasters of numbers with a location: GeoTIFF and ESRI ASCII grids.

use std::path::Path;

use super::tiff::{self, Location, Raster, Role};
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
    let raster = match extension(path).as_str() {
        "asc" => ascii_grid(&bytes, read_beside(&path.with_extension("prj"))?.as_deref()),
        _ => {
            // GDAL stores masks in a file of this name if they are not in the raster's own file.
            let mask = read_beside(&with_suffix(path, ".msk"))?;
            tiff::decode(path, &bytes, mask.as_deref(), role)
        }
    };
    raster.map_err(|reason| IoError::content(path, reason))
}

fn ascii_grid(bytes: &[u8], projection: Option<&[u8]>) -> Result<Raster, String> {
    let projection = projection.map(String::from_utf8_lossy);
    let ascii_grid::AsciiGrid { grid, spacing, georeference } =
        ascii_grid::decode(bytes, projection.as_deref())?;
    Ok(Raster {
        grid: Grid { georeference: georeference.as_ref().ok().copied(), ..grid },
        spacing,
        location: Location {
            geo_tags: Some(georeference.as_ref().map(GeoTags::of_transform).unwrap_or_default()),
            georeference,
            metres: Ok(1.0),
        },
        unreached: false,
    })
}
