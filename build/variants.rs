//! Modules of each shader. Large shaders that depend on the kind of front are compiled once for each kind, since
//! drivers would take time to read the code of other kinds and then leave it out. The text of this file is part of
//! the fingerprint of the committed SPIR-V.

/// Kinds of fronts, by their numbers in constants.glsl.
const WAVEFRONTS: [&str; 4] = ["planar", "circular", "curved", "anchored"];

/// Shaders that are compiled for each kind of front, and for how many kinds: the first ones of [`WAVEFRONTS`].
const BY_WAVEFRONT: [(&str, usize); 5] =
    [("pairwise_scan", 3), ("scan", 4), ("tiles", 4), ("tiles_points", 4), ("tiles_shuffled", 4)];

/// The specialization constant that a macro replaces: its number and name.
pub const WAVEFRONT: (u32, &str) = (2, "WAVEFRONT");

/// A module of a shader.
pub struct Module {
    /// Name of its file, without the extension.
    pub name: String,
    /// Number of the kind of front that the module serves, or `None` if it serves all.
    pub wavefront: Option<usize>,
}

/// Returns the modules of the shader `stem`.comp.
pub fn modules_of(stem: &str) -> Vec<Module> {
    match BY_WAVEFRONT.iter().find(|(name, _)| *name == stem) {
        None => vec![Module { name: stem.to_owned(), wavefront: None }],
        Some((_, count)) => (0..*count)
            .map(|wavefront| Module {
                name: format!("{stem}_{}", WAVEFRONTS[wavefront]),
                wavefront: Some(wavefront),
            })
            .collect(),
    }
}
