//! Reads what GDAL stores beside a raster: world files, and its auxiliary metadata (PAM) in `FILE.aux.xml`.

use std::path::Path;

use roxmltree::{Document, Node};

use super::{CoordinateSystem, Georeference, IoError, extension, read_beside, with_suffix};
use geosweep_crs::c_number::c_number;

/// The metadata of a file `FILE.aux.xml`, which replace those in the raster itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Auxiliary {
    /// Location of the middles of the pixels.
    pub transform: Option<Georeference>,
    pub system: Option<CoordinateSystem>,
    /// Texts of the numbers for the first band.
    pub no_data: Option<String>,
    pub scale: Option<f64>,
    pub offset: Option<f64>,
    pub unit: Option<String>,
}

impl Auxiliary {
    /// Reads the file beside a raster, if there is one.
    pub fn beside(path: &Path) -> Result<Self, IoError> {
        let own = with_suffix(path, ".aux.xml");
        match read_beside(&own)? {
            None => Ok(Self::default()),
            Some(bytes) => Self::parse(&bytes).map_err(|reason| IoError::content(&own, reason)),
        }
    }

    fn parse(bytes: &[u8]) -> Result<Self, String> {
        let text = std::str::from_utf8(bytes).map_err(|_| "is not text".to_string())?;
        let document = Document::parse(text.trim_start_matches('\u{feff}').trim())
            .map_err(|error| format!("is no XML: {error}"))?;
        let root = document.root_element();
        let band = root.children().find(|node| {
            node.has_tag_name("PAMRasterBand")
                && node.attribute("band").is_none_or(|band| band == "1")
        });
        let of_band = |name: &str| band.and_then(|band| text_of(band, name));
        let number = |name: &str| of_band(name).map(|text| real(text, name)).transpose();
        Ok(Self {
            transform: text_of(root, "GeoTransform").map(transform).transpose()?,
            system: text_of(root, "SRS").map(system).transpose()?,
            no_data: of_band("NoDataValue").map(str::to_owned),
            scale: number("Scale")?,
            offset: number("Offset")?,
            unit: of_band("UnitType").map(str::to_owned),
        })
    }
}

/// Returns the extensions of world files, in the order in which GDAL looks for them. For `tif` these are `tfw`, `tifw`
/// and `wld`, and the same in capitals.
fn world_extensions(extension: &str) -> Vec<String> {
    let lower = extension.to_ascii_lowercase();
    let ends = lower.chars().next().into_iter().chain(lower.chars().last()).collect::<String>();
    let all = [format!("{ends}w"), format!("{lower}w"), "wld".into()];
    all.into_iter().flat_map(|of| [of.clone(), of.to_ascii_uppercase()]).collect()
}

/// Returns the location in a world file beside a raster, if there is one.
pub(super) fn world_file(path: &Path) -> Result<Option<Georeference>, IoError> {
    for extension in world_extensions(&extension(path)) {
        let own = path.with_extension(extension);
        if let Some(bytes) = read_beside(&own)? {
            let numbers = String::from_utf8_lossy(&bytes);
            let numbers: Vec<_> = numbers.split_ascii_whitespace().map(c_number).collect();
            return match numbers[..] {
                [Some(a), Some(d), Some(b), Some(e), Some(x), Some(y)] => {
                    located([x, y], [b, e], [a, d]).map(Some)
                }
                _ => Err("is no world file, which has six numbers".into()),
            }
            .map_err(|reason| IoError::content(&own, reason));
        }
    }
    Ok(None)
}

fn text_of<'a>(node: Node<'a, '_>, name: &str) -> Option<&'a str> {
    let found = node.children().find(|child| child.has_tag_name(name))?;
    found.text().map(str::trim).filter(|text| !text.is_empty())
}

fn real(text: &str, name: &str) -> Result<f64, String> {
    let number = c_number(text).filter(|number| number.is_finite());
    number.ok_or_else(|| format!("its {name} `{text}` is not a number"))
}

/// Interprets the six numbers of GDAL's transformation, from the corner of the first pixel.
fn transform(text: &str) -> Result<Georeference, String> {
    let numbers: Vec<_> = text.split(',').map(|number| c_number(number.trim())).collect();
    let [Some(x), Some(a), Some(b), Some(y), Some(d), Some(e)] = numbers[..] else {
        return Err("its GeoTransform has not six numbers".into());
    };
    located([x + 0.5 * (a + b), y + 0.5 * (d + e)], [b, e], [a, d])
}

fn located(origin: [f64; 2], down: [f64; 2], right: [f64; 2]) -> Result<Georeference, String> {
    let is_finite = [origin, down, right].as_flattened().iter().all(|number| number.is_finite());
    match is_finite && right[0] * down[1] != right[1] * down[0] {
        true => Ok(Georeference { origin, down, right, system: None }),
        false => Err("its transformation has no inverse".into()),
    }
}

/// Returns the coordinate reference system that a text names by its number in the EPSG register.
fn system(text: &str) -> Result<CoordinateSystem, String> {
    let upper = text.to_ascii_uppercase();
    // The authority of the whole system comes last: AUTHORITY["EPSG","32633"]] or ID["EPSG",32633]].
    let parts = upper.trim_end_matches([']', ' ', '\n']).rsplit_once(',');
    let parts = parts.filter(|(before, _)| before.trim_end_matches(['"', ' ']).ends_with("EPSG"));
    let code = parts.and_then(|(_, code)| code.trim_matches(['"', ' ']).parse::<u16>().ok());
    let is_projected = upper.starts_with("PROJC");
    match code {
        Some(code) if is_projected => Ok(CoordinateSystem::Projected(code)),
        Some(code) if upper.starts_with("GEOG") => Ok(CoordinateSystem::Geographic(code)),
        _ => Err("names a coordinate system without a number of the EPSG register; gdal_translate writes it into the \
                  raster itself"
            .into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn world_files_have_the_extensions_of_gdal() {
        let of = |extension| world_extensions(extension).join(" ");
        assert_eq!(of("tif"), "tfw TFW tifw TIFW wld WLD");
        assert_eq!(of("TIFF"), "tfw TFW tiffw TIFFW wld WLD");
        assert_eq!(of("png"), "pgw PGW pngw PNGW wld WLD");
    }

    #[test]
    fn auxiliary_metadata_are_read() {
        let srs = r#"PROJCS["UTM 33N",GEOGCS["WGS 84",AUTHORITY["EPSG","4326"]],UNIT["metre",1],AUTHORITY["EPSG","32633"]]"#;
        let text = format!(
            "<PAMDataset><SRS dataAxisToSRSAxisMapping=\"1,2\">{srs}</SRS>
             <GeoTransform> 5.0e+05,  2.0e+01,  0.0, 5.0e+06,  0.0, -2.0e+01</GeoTransform>
             <PAMRasterBand band=\"2\"><NoDataValue>1</NoDataValue></PAMRasterBand>
             <PAMRasterBand band=\"1\"><NoDataValue>-9999</NoDataValue><Offset>7</Offset><Scale>0.5</Scale>
             <UnitType>ft</UnitType></PAMRasterBand></PAMDataset>"
        );
        let found = Auxiliary::parse(text.as_bytes()).unwrap();
        let place = found.transform.unwrap();
        assert_eq!(
            [place.origin, place.down, place.right],
            [[500_010.0, 4_999_990.0], [0.0, -20.0], [20.0, 0.0]]
        );
        assert_eq!(found.system, Some(CoordinateSystem::Projected(32633)));
        assert_eq!((found.scale, found.offset), (Some(0.5), Some(7.0)));
        assert_eq!([found.no_data.unwrap(), found.unit.unwrap()], ["-9999", "ft"]);

        let none = Auxiliary::parse(b"<PAMDataset><Metadata/></PAMDataset>").unwrap();
        assert_eq!(none, Auxiliary::default());
        let nameless = text
            .replace(r#","AUTHORITY["EPSG","32633"]"#, "")
            .replace(r#",AUTHORITY["EPSG","32633"]"#, "");
        assert!(Auxiliary::parse(nameless.as_bytes()).unwrap_err().contains("without a number"));
        assert!(
            Auxiliary::parse(text.replace("5.0e+06", "x").as_bytes())
                .unwrap_err()
                .contains("six numbers")
        );
        assert!(
            Auxiliary::parse(text.replace("0.5", "x").as_bytes()).unwrap_err().contains("Scale")
        );
        assert!(Auxiliary::parse(b"nonsense").is_err());
    }
}
