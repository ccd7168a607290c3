//! Names a surface in debugging tools, and labels its recordings.

use std::ffi::{CStr, CString};
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// Kind of a recording that has a label of its own.
#[derive(Clone, Copy, Debug)]
pub(super) enum Labelled {
    Frame,
    Contours,
    Paths,
    Regions,
    Directions,
    LogMap,
}

impl Labelled {
    const ALL: [(Self, &'static str); 6] = [
        (Self::Frame, "frame"),
        (Self::Contours, "contours"),
        (Self::Paths, "paths"),
        (Self::Regions, "regions"),
        (Self::Directions, "directions"),
        (Self::LogMap, "log map"),
    ];
}

/// Labels of the recordings of a surface, made when the surface is: recording allocates nothing.
#[derive(Debug)]
pub(super) struct SurfaceLabels([CString; Labelled::ALL.len()]);

impl SurfaceLabels {
    /// Returns the labels of a surface with this name, which contains no zero byte.
    pub(super) fn new(name: &str) -> Self {
        let label = |(_, kind)| CString::new(format!("geosweep: {kind} of {name}"));
        Self(Labelled::ALL.map(|kind| label(kind).unwrap_or_default()))
    }

    pub(super) fn label(&self, of: Labelled) -> &CStr {
        &self.0[of as usize]
    }
}

/// Returns the name of a surface: the host's, or one with a number that no other surface of this process has.
pub(super) fn name_of_surface(given: Option<&str>) -> String {
    static SURFACES: AtomicU32 = AtomicU32::new(0);
    match given {
        Some(name) if !name.is_empty() => name.replace('\0', " "),
        _ => format!("surface {}", SURFACES.fetch_add(1, Relaxed)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_name_the_kind_and_the_surface() {
        assert!(Labelled::ALL.iter().enumerate().all(|(at, (kind, _))| *kind as usize == at));
        let labels = SurfaceLabels::new(&name_of_surface(Some("left\0arm")));
        assert_eq!(labels.label(Labelled::LogMap), c"geosweep: log map of left arm");
        let [first, second] = [None, Some("")].map(name_of_surface);
        assert!(first.starts_with("surface ") && first != second, "{first}, {second}");
    }
}
