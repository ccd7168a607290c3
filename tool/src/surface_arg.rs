//! Parses the surface argument: a file, or a built-in surface with its size.

use std::ffi::OsString;
use std::path::PathBuf;
use std::str::FromStr;

use geosweep::Surface;
use geosweep::io::checked_points;
use geosweep::shown::excerpt;
use geosweep::surface::SurfaceError;
use geosweep::surface::builtin::Builtin;

/// A file or `builtin:NAME:ROWSxCOLS`.
#[derive(Clone, Debug)]
pub enum SurfaceArg {
    File(PathBuf),
    Builtin(SizedBuiltin),
}

impl SurfaceArg {
    /// Parses an argument. Only built-in names must be valid text; a file name may be arbitrary.
    pub fn parse(arg: OsString) -> Result<Self, String> {
        match arg.to_str() {
            Some(text) if text.starts_with(SizedBuiltin::PREFIX) => text.parse().map(Self::Builtin),
            _ => Ok(Self::File(arg.into())),
        }
    }
}

/// A built-in surface at a given size.
#[derive(Clone, Debug)]
pub struct SizedBuiltin {
    builtin: Builtin,
    rows: usize,
    cols: usize,
}

impl SizedBuiltin {
    const PREFIX: &str = "builtin:";

    pub fn surface(&self) -> Result<Surface, SurfaceError> {
        self.builtin.surface(self.rows, self.cols)
    }
}

impl FromStr for SizedBuiltin {
    type Err = String;

    /// Parses `NAME:ROWSxCOLS`, with or without `builtin:` before it.
    fn from_str(text: &str) -> Result<Self, String> {
        let text = text.strip_prefix(Self::PREFIX).unwrap_or(text);
        let form = || {
            format!("`{}` is not of the form NAME:ROWSxCOLS, such as plane:257x257", excerpt(text))
        };
        let (name, size) = text.rsplit_once(':').ok_or_else(form)?;
        let (rows, cols) = size.split_once('x').ok_or_else(form)?;
        let number = |text: &str| text.parse().map_err(|_| form());
        let (rows, cols) = (number(rows)?, number(cols)?);
        checked_points(rows, cols)?;
        Ok(Self { builtin: Builtin::parse(name)?, rows, cols })
    }
}
