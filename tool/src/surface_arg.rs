//! Parses the surface argument: a file, or a built-in surface with its size.

use std::ffi::OsString;
use std::path::PathBuf;
use std::str::FromStr;

use geosweep::Surface;
use geosweep::io::checked_points;
use geosweep::shown::excerpt;
use geosweep::surface::SurfaceError;
use geosweep::surface::builtin::{Builtin, Closed};

/// A file or `builtin:NAME:ROWSxCOLS`.
#[derive(Clone, Debug)]
pub enum SurfaceArg {
    File(PathBuf),
    Builtin(SizedBuiltin),
}

impl SurfaceArg {
    /// Parses an argument. Only built-in names must be valid UTF-8; a file name may have any bytes.
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
    shape: Shape,
    rows: usize,
    cols: usize,
}

impl SizedBuiltin {
    const PREFIX: &str = "builtin:";

    pub fn surface(&self) -> Result<Surface, SurfaceError> {
        match self.shape {
            Shape::Open(builtin) => builtin.surface(self.rows, self.cols),
            Shape::Closed(closed) => closed.surface(self.rows, self.cols),
        }
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
        Ok(Self { shape: name.parse()?, rows, cols })
    }
}

/// A built-in surface without its size.
#[derive(Clone, Copy, Debug)]
enum Shape {
    Open(Builtin),
    Closed(Closed),
}

impl FromStr for Shape {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        if let Some(closed) = Closed::parse(name) {
            return Ok(Self::Closed(closed));
        }
        let is_known = |builtin: Builtin| name.split('@').next() == Some(builtin.name());
        Builtin::parse(name).map(Self::Open).map_err(|error| {
            match Builtin::ALL.into_iter().any(is_known) {
                true => error,
                false => format!("{error}, and the closed ones {}", Closed::names()),
            }
        })
    }
}

/// Returns a list of all built-in surfaces for help texts.
pub fn builtin_names() -> String {
    format!(
        "{}; sheared-plane@DEGREES sets the angle.\n  Closed ones: {}.",
        Builtin::names(),
        Closed::names()
    )
}
