//! Records the inputs of an unfinished matrix, and its progress.

use std::collections::BTreeMap;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::MatrixLayout;
use crate::npy::shape_text;
use crate::{IoError, OutputFile, with_suffix};
use geosweep_surface::{EdgeLengths, Surface, SurfaceError};

/// The inputs on which the numbers of a matrix depend, as readable names and values. An unfinished matrix is
/// resumed only with inputs that would give the same bytes.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Provenance(BTreeMap<String, String>);

impl Provenance {
    /// Returns an empty record.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a name and its value.
    pub fn with(mut self, name: &str, value: impl ToString) -> Self {
        self.0.insert(name.into(), value.to_string());
        self
    }
}

/// Returns a checksum of a surface's edge lengths, which are the only data of the surface that solvers use. With it, a
/// matrix of another surface is not resumed by mistake.
///
/// # Errors
/// If an edge is too long or too short for single precision.
pub fn surface_checksum(surface: &Surface) -> Result<String, SurfaceError> {
    let edges = EdgeLengths::<f32>::new(surface)?;
    let mut checksum = crc32fast::Hasher::new();
    for plane in edges.planes() {
        checksum.update(bytemuck::cast_slice(plane));
    }
    Ok(format!("{:08x}", checksum.finalize()))
}

/// The content of the file beside an unfinished matrix.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Checkpoint {
    geosweep: String,
    made_from: Provenance,
    /// Number of rows that are safely on disk.
    pub rows: usize,
}

impl Checkpoint {
    pub fn new(made_from: Provenance, layout: MatrixLayout) -> Self {
        let geosweep = env!("CARGO_PKG_VERSION").into();
        Self { geosweep, made_from: described(made_from, layout), rows: 0 }
    }

    pub fn read(part: &Path) -> Result<Self, IoError> {
        let path = path(part);
        let text = fs::read(&path).map_err(|source| match source.kind() {
            io::ErrorKind::NotFound => IoError::content(
                part,
                format!(
                    "is an unfinished matrix without its checkpoint {}; remove it to begin anew",
                    path.display()
                ),
            ),
            _ => IoError::Read { path: path.clone(), source },
        })?;
        serde_json::from_slice(&text)
            .map_err(|error| IoError::content(&path, format!("is no checkpoint: {error}")))
    }

    /// Checks that the matrix is the expected one.
    pub fn check(
        &self,
        part: &Path,
        made_from: &Provenance,
        layout: MatrixLayout,
    ) -> Result<(), IoError> {
        let wanted = Self::new(made_from.clone(), layout);
        let refuse = |what: &str, found: &str, wanted: &str| {
            let reason = format!(
                "was begun with {what} {found}, not {wanted}; resume with the same value, or remove it to \
                 begin anew"
            );
            Err(IoError::content(part, reason))
        };
        if self.geosweep != wanted.geosweep {
            return refuse("geosweep", &self.geosweep, &wanted.geosweep);
        }
        let [found, wanted] = [&self.made_from.0, &wanted.made_from.0];
        let none = String::from("none");
        for what in found.keys().chain(wanted.keys()) {
            let [found, wanted] = [found, wanted].map(|all| all.get(what).unwrap_or(&none));
            if found != wanted {
                return refuse(what, found, wanted);
            }
        }
        if self.rows > layout.rows {
            let reason = format!(
                "has {} rows by its checkpoint, more than the {} of the matrix; remove it to begin anew",
                self.rows, layout.rows
            );
            return Err(IoError::content(part, reason));
        }
        Ok(())
    }

    pub fn write(&self, part: &Path) -> Result<(), IoError> {
        let output = OutputFile::new(&path(part))?;
        let text = serde_json::to_vec_pretty(self).expect("names and numbers are JSON");
        output.stage(|writer| writer.write_all(&text))?.commit()
    }

    /// Removes the file. An error is ignored, since a remaining checkpoint does no harm.
    pub fn remove(part: &Path) {
        let _ = fs::remove_file(path(part));
    }
}

fn path(part: &Path) -> PathBuf {
    with_suffix(part, ".json")
}

fn described(made_from: Provenance, layout: MatrixLayout) -> Provenance {
    let MatrixLayout { rows, cols, element, upper, .. } = layout;
    made_from
        .with("shape", shape_text(&[rows, cols]))
        .with("numbers", element.name())
        .with("part", if upper { "upper triangle" } else { "whole" })
}
