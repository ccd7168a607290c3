//! Generates the parts of the crate that come from glsl/: SPIR-V for each .comp, constants.glsl as Rust, and
//! each shader's bindings, constants and blocks as Rust, read from the SPIR-V.
//!
//! With the feature `shaderc`, this compiles the shaders. Without it, the SPIR-V committed in glsl/spirv is
//! used, if it was compiled from the same sources in the same way. To renew it after a change of a shader:
//! `GEOSWEEP_UPDATE_SPIRV=1 cargo build --features shaderc`.

#[path = "compile.rs"]
mod compile;
#[path = "interface.rs"]
mod interface;
#[path = "names.rs"]
mod names;
#[path = "rust.rs"]
mod rust;
#[path = "variants.rs"]
mod variants;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::{env, fs};

use interface::Interface;

const GLSL: &str = "glsl";
/// Folders of shader sources in glsl/: passes, what several passes share, and the update of a triangle.
const FOLDERS: [&str; 3] = ["passes", "shared", "update"];
const COMMITTED: &str = "glsl/spirv";
/// File of these constants in Rust, for all crates.
const CONSTANTS: &str = "crates/surface/src/constants.rs";
/// File with the fingerprint of the sources of the committed SPIR-V, and of the way in which it was compiled.
const OF_SOURCES: &str = "glsl/spirv/sources.fnv";
/// File with the fingerprint of the committed SPIR-V itself.
const OF_MODULES: &str = "glsl/spirv/modules.fnv";

/// Generates the parts of the crate.
pub fn build() {
    println!("cargo:rerun-if-changed={GLSL}");
    println!("cargo:rerun-if-changed=build");
    println!("cargo:rerun-if-env-changed=GEOSWEEP_UPDATE_SPIRV");
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    let sources = sources();
    share_constants(&constants(&read(Path::new("glsl/shared/constants.glsl"))));

    let of_sources = fingerprint(compiled_from(&sources));
    if !cfg!(feature = "shaderc") {
        let cure = "build with --features shaderc (ci/setup prepares for it)";
        check(
            OF_SOURCES,
            &of_sources,
            &format!("{GLSL}, or how it is compiled, has changed since {COMMITTED}: {cure}"),
        );
    }
    remove_modules(&out);
    let passes: Vec<_> = (sources.iter())
        .filter(|path| path.extension().is_some_and(|extension| extension == "comp"))
        .map(|path| (path, path.file_stem().expect("a source is a file").to_string_lossy()))
        .collect();
    let compiled = in_parallel(&passes, |(source, stem)| {
        let module =
            |module: &variants::Module| spirv(source, module.wavefront, &committed(&module.name));
        variants::modules_of(stem).iter().map(module).collect::<Vec<_>>()
    });
    let (mut shaders, mut modules) = (Vec::new(), Vec::new());
    for ((source, stem), compiled) in passes.iter().zip(compiled) {
        let mut interface = Interface::default();
        let mut names = Vec::new();
        for (module, spirv) in variants::modules_of(stem).into_iter().zip(compiled) {
            let name = format!("{}.spv", module.name);
            let of_module = Interface::of(&spirv)
                .unwrap_or_else(|reason| panic!("{}: {reason}", source.display()));
            interface.add(of_module);
            if module.wavefront.is_some() {
                interface.add_constant(variants::WAVEFRONT);
            }
            write(&out.join(&name), &spirv);
            names.push(module.name);
            modules.push((name, spirv));
        }
        shaders.push(rust::Shader { name: stem.to_string(), modules: names, interface });
    }
    let of_modules = fingerprint(modules);
    if !cfg!(feature = "shaderc") {
        let what =
            "is not what was compiled: a module is damaged or from elsewhere; check it out anew";
        check(OF_MODULES, &of_modules, &format!("{COMMITTED} {what}"));
    }
    write(&out.join("shaders.rs"), rust::shaders(&shaders).as_bytes());
    if env::var_os("GEOSWEEP_UPDATE_SPIRV").is_some() {
        write(Path::new(OF_SOURCES), of_sources.as_bytes());
        write(Path::new(OF_MODULES), of_modules.as_bytes());
    }
}

/// Returns the path of a committed module.
fn committed(name: &str) -> PathBuf {
    Path::new(COMMITTED).join(format!("{name}.spv"))
}

/// Applies a function to all items on all processors, since glslang takes a second or more for each shader.
fn in_parallel<T: Sync, U: Send>(items: &[T], of: impl Fn(&T) -> U + Sync) -> Vec<U> {
    let next = AtomicUsize::new(0);
    let work = || {
        let numbers = std::iter::repeat_with(|| next.fetch_add(1, Ordering::Relaxed));
        let items = numbers.map_while(|number| Some((number, items.get(number)?)));
        items.map(|(number, item)| (number, of(item))).collect::<Vec<_>>()
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let mut done: Vec<_> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        let done = workers.into_iter().map(|worker| worker.join());
        done.flat_map(|done| done.unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
            .collect()
    });
    done.sort_by_key(|&(number, _)| number);
    done.into_iter().map(|(_, result)| result).collect()
}

/// Removes the modules of an earlier build. Some may belong to shaders that no longer exist.
fn remove_modules(folder: &Path) {
    let entries = fs::read_dir(folder)
        .unwrap_or_else(|error| panic!("cannot read the folder {}: {error}", folder.display()));
    let paths = entries.map(|entry| entry.expect("the folder can be listed").path());
    for path in paths.filter(|path| path.extension().is_some_and(|e| e == "spv")) {
        fs::remove_file(&path)
            .unwrap_or_else(|error| panic!("cannot remove {}: {error}", path.display()));
    }
}

/// Returns the shader sources, sorted so that nothing depends on the order of the folders' entries.
fn sources() -> Vec<PathBuf> {
    let folder = |name: &&str| {
        let path = Path::new(GLSL).join(name);
        let entries = fs::read_dir(&path)
            .unwrap_or_else(|error| panic!("cannot read the folder {}: {error}", path.display()));
        entries.map(|entry| entry.expect("the folder can be listed").path())
    };
    let mut sources: Vec<_> = FOLDERS.iter().flat_map(folder).collect();
    sources.sort();
    sources
}

/// Returns names and contents of everything that determines the SPIR-V, except the compiler.
fn compiled_from(sources: &[PathBuf]) -> Vec<(String, Vec<u8>)> {
    let how = ["build/compile.rs", "build/names.rs", "build/variants.rs"].map(PathBuf::from);
    let text = |path: &PathBuf| {
        let name = path.file_name().expect("a source is a file").to_string_lossy().into_owned();
        // A checkout may have changed the line ends.
        (name, read(path).replace('\r', "").into_bytes())
    };
    sources.iter().chain(&how).map(text).collect()
}

/// Computes FNV-1a over names and contents. It shows whether committed SPIR-V is stale or damaged, and
/// protects against nothing else.
fn fingerprint(files: Vec<(String, Vec<u8>)>) -> String {
    let mut hash = 0xcbf2_9ce4_8422_2325u64;
    for byte in
        files.into_iter().flat_map(|(name, content)| name.into_bytes().into_iter().chain(content))
    {
        hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    }
    format!("{hash:016x}\n")
}

fn check(path: &str, fingerprint: &str, otherwise: &str) {
    let is_that = fs::read_to_string(path).is_ok_and(|old| old.trim() == fingerprint.trim());
    assert!(is_that, "{otherwise}");
}

/// Writes the constants for the crates below this one, or checks that they are those of the shaders. The package of this
/// crate alone does not have the file.
fn share_constants(rust: &str) {
    let path = Path::new(CONSTANTS);
    println!("cargo:rerun-if-changed={CONSTANTS}");
    if env::var_os("GEOSWEEP_UPDATE_SPIRV").is_some() {
        write(path, rust.as_bytes());
    } else if path.exists() {
        let is_that = read(path).replace('\r', "") == rust;
        assert!(
            is_that,
            "{CONSTANTS} is not glsl/shared/constants.glsl: build with GEOSWEEP_UPDATE_SPIRV=1"
        );
    }
}

/// Translates `#define NAME value` to Rust: values with a point or an exponent are f64, others u32.
fn constants(glsl: &str) -> String {
    let mut comment = String::new();
    let mut rust = String::from(
        "//! Constants shared with the shaders, generated from `glsl/shared/constants.glsl` by `build.rs`.\n\n",
    );
    for line in glsl.lines() {
        if let Some(text) = line.strip_prefix("// ") {
            comment += &format!("/// {text}\n");
        } else if let Some(definition) = line.strip_prefix("#define ") {
            let (name, value) = definition.split_once(' ').expect("#define NAME value");
            let is_float = value.contains(['.', 'e']);
            let kind = if is_float { "f64" } else { "u32" };
            rust += &format!("{comment}pub const {name}: {kind} = {value};\n");
            comment.clear();
        } else {
            comment.clear();
        }
    }
    rust
}

#[cfg(feature = "shaderc")]
fn spirv(source: &Path, wavefront: Option<usize>, committed: &Path) -> Vec<u8> {
    let definition = wavefront.map(|number| (variants::WAVEFRONT.1, number.to_string()));
    let spirv = compile::spirv(&read(source), &source.to_string_lossy(), GLSL, definition);
    if env::var_os("GEOSWEEP_UPDATE_SPIRV").is_some() {
        fs::create_dir_all(COMMITTED).expect("the source folder can be written");
        write(committed, &spirv);
    }
    spirv
}

#[cfg(not(feature = "shaderc"))]
fn spirv(_source: &Path, _wavefront: Option<usize>, committed: &Path) -> Vec<u8> {
    fs::read(committed)
        .unwrap_or_else(|error| panic!("cannot read {}: {error}", committed.display()))
}

fn read(path: &Path) -> String {
    fs::read_to_string(path)
        .unwrap_or_else(|error| panic!("cannot read {}: {error}", path.display()))
}

fn write(path: &Path, content: &[u8]) {
    fs::write(path, content)
        .unwrap_or_else(|error| panic!("cannot write {}: {error}", path.display()));
}
