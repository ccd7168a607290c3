//! Tells the units of length that files of rasters use, by their numbers in the EPSG register.

pub const METRE: u16 = 9001;
const FOOT: u16 = 9002;
const US_SURVEY_FOOT: u16 = 9003;

/// Returns the length of a unit in metres, if the unit is known here.
pub fn metres(unit: u16) -> Option<f64> {
    match unit {
        METRE => Some(1.0),
        FOOT => Some(0.3048),
        US_SURVEY_FOOT => Some(1200.0 / 3937.0),
        _ => None,
    }
}

/// Returns the name of a unit, if the unit is known here.
pub fn name(unit: u16) -> Option<&'static str> {
    match unit {
        METRE => Some("m"),
        FOOT => Some("ft"),
        US_SURVEY_FOOT => Some("US ft"),
        _ => None,
    }
}

/// Returns the number of a unit that GDAL writes as text.
pub fn of_text(text: &str) -> Option<u16> {
    match &text.trim().to_ascii_lowercase()[..] {
        "m" | "metre" | "meter" | "metres" | "meters" => Some(METRE),
        "ft" | "foot" | "feet" | "international foot" => Some(FOOT),
        "us survey foot" | "us survey feet" | "us ft" | "ftus" | "us-ft" | "foot_us" | "sft" => {
            Some(US_SURVEY_FOOT)
        }
        _ => None,
    }
}

/// Returns the length in metres of a unit that GDAL writes as text, if the unit is known here.
pub fn metres_of_text(text: &str) -> Option<f64> {
    metres(of_text(text)?)
}
