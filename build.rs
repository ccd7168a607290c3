//! Turns glsl/ into what the crate embeds: SPIR-V for each .comp, constants.glsl as Rust, and as
//! Rust what the SPIR-V says of each shader's bindings, constants and blocks.
//!
//! With the feature `shaderc` the shaders are compiled here; without it the SPIR-V committed in
//! glsl/spirv serves, as long as it was compiled from the same sources. To renew it after a
//! change of a shader: `GEOSWEEP_UPDATE_SPIRV=1 cargo build --features shaderc`.

#[path = "build/interface.rs"]
mod interface;
#[path = "build/names.rs"]
mod names;
#[path = "build/rust.rs"]
mod rust;

use std::path::{Path, PathBuf};
use std::{env, fs};

use interface::Interface;

const GLSL: &str = "glsl";
const COMMITTED: &str = "glsl/spirv";
/// Holds the fingerprint of the sources that the committed SPIR-V was compiled from.
const FINGERPRINT: &str = "glsl/spirv/sources.fnv";

fn main() {
    println!("cargo:rerun-if-changed={GLSL}");
    println!("cargo:rerun-if-changed=build");
    println!("cargo:rerun-if-env-changed=GEOSWEEP_UPDATE_SPIRV");
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    let sources = sources();
    write(&out.join("constants.rs"), constants(&read(Path::new("glsl/constants.glsl"))).as_bytes());

    let fingerprint = fingerprint(&sources);
    let mut shaders = Vec::new();
    for source in sources.iter().filter(|path| path.extension().is_some_and(|e| e == "comp")) {
        let stem = source.file_stem().expect("a source is a file").to_string_lossy().into_owned();
        let name = format!("{stem}.spv");
        let spirv = spirv(source, &Path::new(COMMITTED).join(&name), &fingerprint);
        let interface =
            Interface::of(&spirv).unwrap_or_else(|reason| panic!("{}: {reason}", source.display()));
        write(&out.join(&name), &spirv);
        shaders.push((stem, interface));
    }
    write(&out.join("shaders.rs"), rust::shaders(&shaders).as_bytes());
    if env::var_os("GEOSWEEP_UPDATE_SPIRV").is_some() {
        write(Path::new(FINGERPRINT), fingerprint.as_bytes());
    }
}

/// The shader sources, sorted so that nothing depends on the order of the folder's entries.
fn sources() -> Vec<PathBuf> {
    let mut sources: Vec<_> = fs::read_dir(GLSL)
        .unwrap_or_else(|error| panic!("cannot read the folder {GLSL}: {error}"))
        .map(|entry| entry.expect("the folder can be listed").path())
        .filter(|path| path.is_file())
        .collect();
    sources.sort();
    sources
}

/// FNV-1a over all sources' names and texts: tells whether committed SPIR-V is stale, and is no
/// protection against anything else.
fn fingerprint(sources: &[PathBuf]) -> String {
    let mut hash = 0xcbf2_9ce4_8422_2325u64;
    for source in sources {
        let name = source.file_name().expect("a source is a file").to_string_lossy();
        // A checkout may have changed the line ends.
        for byte in name.bytes().chain(read(source).replace('\r', "").bytes()) {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
    format!("{hash:016x}\n")
}

/// `#define NAME value` as Rust: values with a point or an exponent are f64, others u32.
fn constants(glsl: &str) -> String {
    let mut comment = String::new();
    let mut rust = String::new();
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
fn spirv(source: &Path, committed: &Path, _fingerprint: &str) -> Vec<u8> {
    use shaderc::{CompileOptions, Compiler, EnvVersion, OptimizationLevel, ShaderKind, TargetEnv};

    let compiler = Compiler::new().expect("glslang starts");
    let mut options = CompileOptions::new().expect("glslang starts");
    // Vulkan 1.1 is the oldest version that the engine runs on.
    options.set_target_env(TargetEnv::Vulkan, EnvVersion::Vulkan1_1 as u32);
    options.set_optimization_level(OptimizationLevel::Performance);
    options.set_warnings_as_errors();
    // Without it the optimizer takes all names out.
    options.set_generate_debug_info();
    options.set_include_callback(|name, _, _, _| {
        let resolved_name = format!("{GLSL}/{name}");
        let content = fs::read_to_string(&resolved_name)
            .map_err(|error| format!("cannot read {resolved_name}: {error}"))?;
        Ok(shaderc::ResolvedInclude { resolved_name, content })
    });
    let name = source.to_string_lossy();
    let artifact = compiler
        .compile_into_spirv(&read(source), ShaderKind::Compute, &name, "main", Some(&options))
        .unwrap_or_else(|error| panic!("{error}"));
    let spirv = names::keep_those_of_interfaces(artifact.as_binary());
    if env::var_os("GEOSWEEP_UPDATE_SPIRV").is_some() {
        fs::create_dir_all(COMMITTED).expect("the source folder can be written");
        write(committed, &spirv);
    }
    spirv
}

#[cfg(not(feature = "shaderc"))]
fn spirv(_source: &Path, committed: &Path, fingerprint: &str) -> Vec<u8> {
    assert!(
        fs::read_to_string(FINGERPRINT).is_ok_and(|compiled| compiled.trim() == fingerprint.trim()),
        "the shaders in {GLSL} have changed since {COMMITTED} was compiled: \
         build with --features shaderc (ci/setup prepares for it)"
    );
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
