//! Builds the library as its documentation describes. Compiles programs in C against it and runs them under
//! the validation layers.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use std::{env, fs};

pub const ROOT: &str = env!("CARGO_MANIFEST_DIR");
/// Compiler options that enable warnings and make them errors.
const STRICT: [&str; 4] = ["-Wall", "-Wextra", "-Werror", "-pedantic"];
/// System libraries that the static library needs on Linux.
const SYSTEM: [&str; 3] = ["-lpthread", "-ldl", "-lm"];

/// The library with which a program is linked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Linkage {
    Shared,
    Static,
}

/// Returns the folder with the library, which is built once. The artifacts that cargo has built for the tests
/// are reused, so that this compiles only this crate.
pub fn library() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap();
        let mut cargo = Command::new(env!("CARGO"));
        cargo.current_dir(ROOT).args(["rustc", "-p", "geosweep-capi", "--lib", "--offline"]);
        cargo.args(["--crate-type", "cdylib,staticlib"]).arg("--target-dir").arg(target);
        let profile = profile();
        cargo.arg("--profile").arg(&profile);
        // CMakeLists.txt does the same, so that both build the same library.
        if cfg!(target_os = "linux") {
            cargo.arg("--").arg(format!("-Clink-arg=-Wl,-soname,{}", soname()));
        }
        run(&mut cargo, "build the library");
        let folder = target.join(if profile == "dev" { "debug".into() } else { profile });
        // Programs look for the library under this name.
        let by_soname = folder.join(soname());
        if !by_soname.exists() {
            std::os::unix::fs::symlink("libgeosweep_capi.so", by_soname).unwrap();
        }
        folder
    })
}

/// Returns the name under which programs look for the shared library. It contains the header's version.
pub fn soname() -> String {
    let [major, minor] = [env!("CARGO_PKG_VERSION_MAJOR"), env!("CARGO_PKG_VERSION_MINOR")];
    format!("libgeosweep.so.{major}.{minor}.h{}", geosweep_capi::GEOSWEEP_HEADER_VERSION)
}

/// Returns the profile of this test. Its executable is in target/PROFILE/deps; the profile dev is in
/// target/debug.
pub fn profile() -> OsString {
    let test = env::current_exe().unwrap();
    let folder = test.ancestors().nth(2).and_then(Path::file_name).unwrap();
    if folder == "debug" { "dev".into() } else { folder.to_owned() }
}

/// Returns a C compiler (`CC`, otherwise `cc`) or a C++ compiler (`CXX`, otherwise `c++`) that can include
/// geosweep.h.
fn compiler(variable: &str, usual: &str) -> Command {
    let program = env::var(variable).unwrap_or_else(|_| usual.into());
    let probe = format!("{ROOT}/tests/capi/probe.c");
    let found = Command::new(&program).arg("-fsyntax-only").arg(probe).output();
    let found = found.unwrap_or_else(|error| {
        panic!(
            "there is no compiler called {program} ({error}): install one (g++ on Debian and \
             Ubuntu brings cc and c++), or name it in {variable}"
        )
    });
    assert!(
        found.status.success(),
        "{program} does not compile Vulkan's headers: install them (libvulkan-dev on Debian and \
         Ubuntu)\n{}",
        String::from_utf8_lossy(&found.stderr)
    );
    let mut compiler = Command::new(program);
    compiler.args(STRICT).arg("-I").arg(format!("{ROOT}/crates/capi/src"));
    compiler
}

/// Returns the folder `name`, which only one test uses.
pub fn scratch(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("capi").join(name);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// Checks that a source file in C or C++ compiles under a standard such as c99.
pub fn check_syntax(file: &Path, standard: &str) {
    let (variable, usual) = match file.extension().and_then(OsStr::to_str) {
        Some("c") => ("CC", "cc"),
        _ => ("CXX", "c++"),
    };
    let mut compiler = compiler(variable, usual);
    compiler.arg(format!("-std={standard}")).arg("-fsyntax-only");
    if standard == "c++20" {
        // Designated initializers leave members out on purpose.
        compiler.arg("-Wno-missing-field-initializers");
    }
    run(compiler.arg(file), "compile");
}

/// Compiles a program and links it.
pub fn compile(source: &Path, program: &Path, linkage: Linkage) {
    let library = library();
    let is_cpp = source.extension() == Some(OsStr::new("cpp"));
    let (variable, usual, standard) =
        if is_cpp { ("CXX", "c++", "-std=c++17") } else { ("CC", "cc", "-std=c99") };
    let mut compiler = compiler(variable, usual);
    for folder in ["examples", "examples/cpp"] {
        compiler.args(["-I", &format!("{ROOT}/{folder}")]);
    }
    compiler.args([standard, "-O1", "-g", "-o"]).arg(program).arg(source);
    match linkage {
        Linkage::Shared => {
            compiler.arg("-L").arg(library).arg("-lgeosweep_capi");
            compiler.arg(format!("-Wl,-rpath,{}", library.display()));
        }
        Linkage::Static => {
            compiler.arg(library.join("libgeosweep_capi.a")).args(SYSTEM);
        }
    }
    let what = "compile and link (libvulkan.so comes with libvulkan-dev on Debian and Ubuntu)";
    run(compiler.args(["-lvulkan", "-lm"]), what);
}

/// Output of a program and messages of the validation layers.
pub struct Run {
    pub printed: String,
    pub findings: Vec<String>,
}

/// Runs a program on the tests' device, under the validation layers with synchronization validation.
pub fn validated(program: &Path) -> Run {
    validated_with(program, &[])
}

/// Runs a program as [`validated`] does, with more arguments after the device.
pub fn validated_with(program: &Path, arguments: &[&OsStr]) -> Run {
    let folder = program.with_extension("layers");
    fs::create_dir_all(&folder).unwrap();
    let log = folder.join("log.txt");
    let _ = fs::remove_file(&log);
    // Older and newer layers have different names for synchronization validation.
    let settings = format!(
        "khronos_validation.debug_action = VK_DBG_LAYER_ACTION_LOG_MSG\n\
         khronos_validation.log_filename = {}\n\
         khronos_validation.report_flags = error,warn\n\
         khronos_validation.enables = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT\n\
         khronos_validation.validate_sync = true\n\
         khronos_validation.syncval_shader_accesses_heuristic = true\n",
        log.display()
    );
    fs::write(folder.join("vk_layer_settings.txt"), settings).unwrap();
    let mut command = Command::new(program);
    command
        .arg(env::var("GEOSWEEP_TEST_DEVICE").unwrap_or_default())
        .args(arguments)
        .env("VK_INSTANCE_LAYERS", "VK_LAYER_KHRONOS_validation")
        .env("VK_LAYER_SETTINGS_PATH", &folder);
    let printed = run(&mut command, "run");
    let said = fs::read_to_string(&log).unwrap_or_default();
    // Messages of the layers about their own settings are not findings.
    let is_finding = |line: &&str| {
        ["SYNC-HAZARD", "VUID-", "UNASSIGNED-"].iter().any(|word| line.contains(word))
    };
    Run { printed, findings: said.lines().filter(is_finding).map(str::to_owned).collect() }
}

/// Runs a command that must succeed. Returns its standard output.
pub fn run(command: &mut Command, what: &str) -> String {
    let output = command.output().unwrap_or_else(|error| panic!("{what}: {command:?}: {error}"));
    let [printed, said] =
        [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes).into_owned());
    assert!(output.status.success(), "{what}: {command:?}: {}\n{printed}{said}", output.status);
    printed
}
