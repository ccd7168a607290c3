//! Reads rasters of numbers with a location: GeoTIFF, ESRI ASCII grids and grey PNG pictures.

use std::path::Path;

use super::file_spacing::FileSpacing;
use super::sidecars::{Auxiliary, world_file};
use super::tiff::{self, Beside, Location, Raster, Role};
use super::{
    GeoTags, Grid, IoError, ascii_grid, extension, png, read_beside, read_bytes, with_suffix,
};
use geosweep_crs::c_number::c_number;
use geosweep_crs::units::metres_of_text;

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
        "png" => {
            let mask = read_beside(&with_suffix(path, ".msk"))?;
            let beside = Beside { mask: mask.as_deref(), world: world_file(path)?, auxiliary };
            picture(path, &bytes, beside, role)
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

/// Decodes a grey picture. What GDAL stores beside it places it and says which of its values mean that there is none.
fn picture(path: &Path, bytes: &[u8], beside: Beside, role: Role) -> Result<Raster, String> {
    let png::GreyPicture { mut grid, bits } = png::decode(bytes)?;
    match role {
        Role::Values if bits < 8 => {
            return Err(format!("has {bits} bits a pixel; heights need 8 or 16"));
        }
        Role::Mask if bits > 8 => {
            return Err("a mask is an 8-bit grey picture; this one has 16 bits".into());
        }
        _ => {}
    }
    let geo_tags = GeoTags::default().replaced_by(&beside);
    let Beside { mask, auxiliary: Auxiliary { no_data, scale, offset, unit, .. }, .. } = beside;
    let no_data = no_data.map(|text| {
        c_number(&text).ok_or_else(|| format!("its no-data value `{text}` is not a number"))
    });
    let no_data = no_data.transpose()?;
    let (scale, offset) = (scale.unwrap_or(1.0), offset.unwrap_or(0.0));
    for value in &mut grid.values {
        *value = if Some(*value) == no_data { f64::NAN } else { *value * scale + offset };
    }
    if let Some(mask) = mask {
        let size = (grid.rows, grid.cols);
        tiff::hide_by_mask(path, mask, size, |point| grid.values[point] = f64::NAN)?;
    }
    let spacing = geo_tags.spacing(unit.as_deref());
    let is_placed = geo_tags.is_placed();
    let mut location = geo_tags.location(unit.as_deref());
    if !is_placed {
        const NOWHERE: &str =
            "a PNG picture says where it lies only by a world file (.pgw) or an .aux.xml beside it";
        location = Location { georeference: Err(NOWHERE.into()), geo_tags: None, ..location };
    }
    Ok(Raster {
        grid: Grid { georeference: location.georeference.as_ref().ok().copied(), ..grid },
        spacing,
        location,
        unreached: false,
    })
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
    let (spacing, metres) = match auxiliary.unit.as_deref().map(|unit| (unit, metres_of_text(unit)))
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
