//! Reads the fields that GDAL adds to GeoTIFF: the no-data value, scale and offset, and units.

use ::tiff::tags::{SampleFormat, Tag};
use roxmltree::Document;

use super::directory::Directory;
use super::layout::Sample;
use crate::no_data::{Held, means_no_data};
use crate::sidecars::Auxiliary;
use geosweep_crs::c_number::c_number;

const GDAL_METADATA: Tag = Tag::Unknown(42112);

/// GDAL's metadata of a band.
#[derive(Default)]
pub struct Metadata {
    /// Stored values that mean "no data".
    pub no_data: Vec<NoData>,
    /// Factor by which stored values are multiplied.
    pub scale: Option<f64>,
    /// Offset that is added to stored values after the scale.
    pub offset: Option<f64>,
    /// The unit of the values.
    pub unit: Option<String>,
}

/// A value that means "no data".
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NoData {
    /// The bits of an integer.
    Integer(u64),
    Float(f64),
}

impl Metadata {
    /// Reads the fields 42112 and 42113 of a picture with one band and perhaps an opacity channel.
    pub fn read(directory: &Directory, sample: Sample) -> Result<Self, String> {
        let mut metadata = Self::default();
        if let Some(text) = directory.text(Tag::GdalNodata)? {
            metadata.add_no_data(&text, sample)?;
        }
        let Some(text) = directory.text(GDAL_METADATA)? else { return Ok(metadata) };
        if text.trim().is_empty() {
            return Ok(metadata);
        }
        let document = Document::parse(text.trim())
            .map_err(|error| format!("its GDAL_METADATA (field 42112) is no XML: {error}"))?;
        let items = document.root_element().children();
        for item in items.filter(|item| item.tag_name().name().eq_ignore_ascii_case("Item")) {
            let attribute = |wanted: &str| {
                let found =
                    item.attributes().find(|found| found.name().eq_ignore_ascii_case(wanted));
                found.map(|found| found.value()).unwrap_or_default()
            };
            let Some(value) = item.text() else { continue };
            let role = attribute("role").to_ascii_lowercase();
            let is_first = attribute("sample").trim() == "0";
            match &role[..] {
                _ if attribute("domain").eq_ignore_ascii_case("IMAGE_STRUCTURE") => {}
                "scale" if is_first => metadata.scale = Some(real(value, "scale")?),
                "offset" if is_first => metadata.offset = Some(real(value, "offset")?),
                "unittype" if is_first => metadata.unit = Some(value.trim().to_owned()),
                _ if attribute("name") == "NODATA_VALUES" && attribute("sample").is_empty() => {
                    metadata
                        .add_no_data(value.split_whitespace().next().unwrap_or_default(), sample)?;
                }
                _ => {}
            }
        }
        if metadata.scale == Some(0.0) {
            return Err("its scale (GDAL_METADATA) is 0, which makes all its values equal; \
                        gdal_edit.py -unsetscale -unsetoffset takes it out"
                .into());
        }
        Ok(metadata)
    }

    /// Replaces metadata by those that are given in a file beside the picture.
    pub fn replaced_by(mut self, other: &Auxiliary, sample: Sample) -> Result<Self, String> {
        if let Some(text) = &other.no_data {
            self.no_data.clear();
            self.add_no_data(text, sample)?;
        }
        self.scale = other.scale.or(self.scale);
        self.offset = other.offset.or(self.offset);
        if other.unit.is_some() {
            self.unit.clone_from(&other.unit);
        }
        Ok(self)
    }

    fn add_no_data(&mut self, text: &str, sample: Sample) -> Result<(), String> {
        let text = text.trim();
        if text.is_empty() {
            return Ok(());
        }
        let value = c_number(text).ok_or_else(|| {
            format!(
                "its no-data value `{text}` is not a number; gdal_edit.py -a_nodata sets another"
            )
        })?;
        let exact = text.parse().ok();
        let no_data = match sample.format {
            SampleFormat::IEEEFP => Some(NoData::Float(value)),
            // GDAL drops the fraction, and ignores values beyond the range of the type.
            _ => {
                let (from, to) = sample.range();
                let whole = exact.unwrap_or(value as i128);
                let fits = !value.is_nan() && value >= from as f64 && (from..=to).contains(&whole);
                fits.then_some(NoData::Integer(whole as u64 & sample.mask()))
            }
        };
        self.no_data.extend(no_data);
        Ok(())
    }

    /// Returns whether the bits of a sample mean "no data".
    pub fn is_no_data(&self, word: u64, sample: Sample) -> bool {
        self.no_data.iter().any(|no_data| match *no_data {
            NoData::Integer(bits) => bits == word,
            NoData::Float(value) => {
                let held = if sample.bits == 64 { Held::Double } else { Held::Single };
                means_no_data(sample.value(word), value, held)
            }
        })
    }

    /// Returns whether +infinity means "no data".
    pub fn is_infinite(&self) -> bool {
        self.no_data.contains(&NoData::Float(f64::INFINITY))
    }

    /// Returns whether there is a no-data value. Points of sparse chunks, which are not stored, then have no
    /// data.
    pub fn has_no_data(&self) -> bool {
        !self.no_data.is_empty()
    }
}

impl Sample {
    fn mask(self) -> u64 {
        u64::MAX >> (64 - self.bits)
    }

    /// Returns the least and the greatest integer that a sample can hold.
    fn range(self) -> (i128, i128) {
        match self.format {
            SampleFormat::Int => (-(1 << (self.bits - 1)), (1 << (self.bits - 1)) - 1),
            _ => (0, i128::from(self.mask())),
        }
    }
}

fn real(text: &str, what: &str) -> Result<f64, String> {
    c_number(text.trim())
        .filter(|value| value.is_finite())
        .ok_or_else(|| format!("its {what} (GDAL_METADATA) `{}` is not a number", text.trim()))
}
