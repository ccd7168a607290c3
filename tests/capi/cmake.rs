//! The package that CMake installs, and a renderer in C++ that is built with it.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::build::{ROOT, library, profile, run, scratch, soname, validated_with};

fn cmake() -> Command {
    let mut cmake = Command::new("cmake");
    // All files of the package must come from the folder that is tested.
    cmake.env_remove("CMAKE_PREFIX_PATH");
    cmake
}

/// Installs the package in its own folder, with the library that the other tests use.
fn install() -> PathBuf {
    let (build, prefix) = (scratch("cmake/build"), scratch("cmake").join("prefix"));
    let _ = fs::remove_dir_all(&prefix);
    let target = library().parent().unwrap();
    run(
        cmake().args(["-S", ROOT, "-B"]).arg(&build).args([
            format!("-DGEOSWEEP_CARGO={}", env!("CARGO")),
            format!("-DGEOSWEEP_CARGO_PROFILE={}", profile().display()),
            format!("-DGEOSWEEP_CARGO_TARGET_DIR={}", target.display()),
            "-DGEOSWEEP_OFFLINE=ON".to_owned(),
            "-DCMAKE_INSTALL_LIBDIR=lib".to_owned(),
        ]),
        "configure the package (cmake comes with the package of that name)",
    );
    run(cmake().arg("--build").arg(&build), "build the package");
    run(cmake().arg("--install").arg(&build).arg("--prefix").arg(&prefix), "install the package");
    prefix
}

fn floats(file: &Path) -> Vec<f32> {
    let bytes = fs::read(file).unwrap();
    bytes.chunks_exact(4).map(|four| f32::from_ne_bytes(four.try_into().unwrap())).collect()
}

/// `examples/cpp` finds the package and runs with frames in flight, without messages of the validation
/// layers. Its map belongs to its source. The package is found after it was
/// moved, also by pkg-config.
#[test]
fn a_renderer_in_cpp_finds_the_package_and_has_the_map() {
    let prefix = install();
    let moved = prefix.with_file_name("moved");
    let _ = fs::remove_dir_all(&moved);
    fs::rename(&prefix, &moved).unwrap();
    let in_package = |file: &str| assert!(moved.join(file).exists(), "{file} is not installed");
    for file in [
        "include/geosweep.h",
        "include/geosweep.hpp",
        "lib/libgeosweep.so",
        "lib/libgeosweep.a",
        "lib/pkgconfig/geosweep.pc",
        "share/doc/geosweep/embedding.md",
        "share/doc/geosweep/c.md",
        "share/doc/geosweep/cpp.md",
        "share/doc/geosweep/LICENSE-MIT",
        "share/doc/geosweep/THIRD-PARTY.txt",
        "share/doc/geosweep/examples/embed.c",
        "share/doc/geosweep/examples/closed.c",
        "share/doc/geosweep/examples/host.h",
    ] {
        in_package(file);
    }
    let version = env!("CARGO_PKG_VERSION");
    in_package(&format!("lib/libgeosweep.so.{version}"));

    let guide = fs::read_to_string(moved.join("share/doc/geosweep/c.md")).unwrap();
    assert!(guide.contains("(examples/embed.c)") && !guide.contains("(../examples/"), "{guide}");

    let build = scratch("cmake/example");
    let _ = fs::remove_dir_all(&build);
    run(
        cmake()
            .arg("-S")
            .arg(moved.join("share/doc/geosweep/examples/cpp"))
            .arg("-B")
            .arg(&build)
            .arg(format!("-DCMAKE_PREFIX_PATH={}", moved.display()))
            .args([
                "-DCMAKE_BUILD_TYPE=Release",
                "-DCMAKE_CXX_FLAGS=-Wall -Wextra -Wpedantic -Werror",
            ]),
        "configure the example",
    );
    run(cmake().arg("--build").arg(&build), "build the example");
    let found = validated_with(&build.join("frame_graph"), &[build.as_os_str()]);
    assert_eq!(found.findings, Vec::<String>::new(), "{}", found.printed);

    let distances = floats(&build.join("distances.bin"));
    let nearest = (0..distances.len()).min_by(|&a, &b| distances[a].total_cmp(&distances[b]));
    // The source of the last of eight frames lies at row 19, between the columns 20 and 21.
    assert!(distances.len() == 60 * 72 && distances.iter().all(|distance| distance.is_finite()));
    assert!([19 * 72 + 20, 19 * 72 + 21].map(Some).contains(&nearest), "{nearest:?}");

    let asked = |options: &[&str]| {
        let mut command = Command::new("pkg-config");
        command.env("PKG_CONFIG_PATH", moved.join("lib/pkgconfig")).args(options).arg("geosweep");
        run(&mut command, "ask pkg-config")
    };
    assert_eq!(asked(&["--modversion"]).trim(), version);
    let include = format!("-I{}", moved.join("lib/pkgconfig/../../include").display());
    assert!(asked(&["--cflags"]).contains(&include));
    let flags = asked(&["--libs", "--static"]);
    for flag in ["-lgeosweep", "-lpthread", "-ldl", "-lm"] {
        assert!(flags.split_whitespace().any(|word| word == flag), "{flag}: {flags}");
    }
}

/// The library's own name is the one under which programs look for it.
#[test]
#[cfg(target_os = "linux")]
fn the_library_has_a_soname() {
    let library = fs::read(library().join("libgeosweep_capi.so")).unwrap();
    let soname = format!("\0{}\0", soname());
    let holds = library.windows(soname.len()).any(|bytes| bytes == soname.as_bytes());
    assert!(holds, "{:?}", OsStr::new(&soname));
}

/// `cmake/RustTarget.cmake` maps toolchains to Rust targets. A CMake script calls it, since a script needs no
/// compiler.
#[test]
fn toolchains_stand_for_rust_targets_or_fail() {
    let folder = scratch("cmake/targets");
    let script = folder.join("target.cmake");
    let text = format!(
        "set(ENV{{CARGO_HOME}} /nowhere)\nset(ENV{{HOME}} /nowhere)\nset(GEOSWEEP_RUSTC \"\")\n\
         include({ROOT}/cmake/RustTarget.cmake)\ngeosweep_rust_target(target)\n\
         message(\"target: ${{target}}.\")\n"
    );
    fs::write(&script, text).unwrap();
    let asked = |settings: &[&str]| {
        let mut command = cmake();
        command.args(settings.iter().map(|setting| format!("-D{setting}")));
        // No rustc is found, so that the result does not depend on the installed targets.
        let output = command.arg("-DGEOSWEEP_RUSTC=").arg("-P").arg(&script).output().unwrap();
        (output.status.success(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (linux, android) = ("CMAKE_SYSTEM_NAME=Linux", "CMAKE_SYSTEM_NAME=Android");
    let windows = ["WIN32=1", "CMAKE_SYSTEM_NAME=Windows", "CMAKE_SYSTEM_PROCESSOR=AMD64"];
    let abi = "CMAKE_ANDROID_ARCH_ABI=";
    for (settings, target) in [
        (&[linux, "CMAKE_SYSTEM_PROCESSOR=x86_64"][..], "x86_64-unknown-linux-gnu"),
        (&[linux, "CMAKE_SYSTEM_PROCESSOR=aarch64"], "aarch64-unknown-linux-gnu"),
        (&[linux, "CMAKE_SYSTEM_PROCESSOR=armv7l"], "armv7-unknown-linux-gnueabihf"),
        (
            &[linux, "CMAKE_SYSTEM_PROCESSOR=x86_64", "CMAKE_SIZEOF_VOID_P=4"],
            "i686-unknown-linux-gnu",
        ),
        (
            &[linux, "CMAKE_SYSTEM_PROCESSOR=x86_64", "CMAKE_C_COMPILER_TARGET=x86_64-linux-musl"],
            "x86_64-unknown-linux-musl",
        ),
        (&[android, "ANDROID=1", &format!("{abi}arm64-v8a")], "aarch64-linux-android"),
        (&[android, "ANDROID=1", &format!("{abi}armeabi-v7a")], "armv7-linux-androideabi"),
        (&[android, "ANDROID=1", &format!("{abi}x86_64")], "x86_64-linux-android"),
        (&[&windows[..], &["MSVC=1"]].concat(), "x86_64-pc-windows-msvc"),
        (&[&windows[..], &["CMAKE_C_COMPILER_ID=GNU"]].concat(), "x86_64-pc-windows-gnu"),
        (
            &["APPLE=1", "CMAKE_SYSTEM_NAME=Darwin", "CMAKE_OSX_ARCHITECTURES=arm64"],
            "aarch64-apple-darwin",
        ),
        (&["GEOSWEEP_RUST_TARGET=mine"], "mine"),
    ] {
        let (succeeds, said) = asked(settings);
        assert!(succeeds && said.contains(&format!("target: {target}.")), "{settings:?}: {said}");
    }
    for settings in [
        &[linux, "CMAKE_SYSTEM_PROCESSOR=sparc64"][..],
        &["CMAKE_SYSTEM_NAME=Haiku", "CMAKE_SYSTEM_PROCESSOR=x86_64"],
        &["APPLE=1", "CMAKE_SYSTEM_NAME=Darwin", "CMAKE_OSX_ARCHITECTURES=arm64;x86_64"],
    ] {
        let (succeeds, said) = asked(settings);
        assert!(!succeeds, "{settings:?}: {said}");
        assert!(said.contains("GEOSWEEP_RUST_TARGET") || said.contains("lipo"), "{said}");
    }
}
