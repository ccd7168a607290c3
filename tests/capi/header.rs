//! The header is the one that cbindgen generates from `crates/capi/src`.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

const HEADER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/crates/capi/src/geosweep.h");
const SOURCES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/crates/capi/src");

/// Files in the order of the header.
const FILES: [&str; 19] = [
    "status",
    "requirements",
    "choices",
    "memory",
    "solver",
    "points",
    "surface_info",
    "surface",
    "plan",
    "frame",
    "record",
    "curves",
    "contours",
    "paths",
    "regions",
    "directions",
    "log_map",
    "cpu_map",
    "profile",
];
/// Files that declare nothing for C.
const INTERNAL: [&str; 7] = ["arguments", "lib", "loader", "objects", "outputs", "shared", "users"];

/// Returns a source file with its macro `calls!` expanded, which cbindgen cannot do.
fn expanded(source: &str) -> String {
    let (mut expanded, mut is_inside, mut is_signature) = (String::new(), false, false);
    for line in source.lines() {
        match line {
            "calls! {" => is_inside = true,
            "}" if is_inside => is_inside = false,
            _ => {
                let name = line.strip_prefix("    fn ").filter(|_| is_inside);
                is_signature |= name.is_some();
                let line = name.map_or(line.to_owned(), |name| {
                    format!("#[unsafe(no_mangle)]\npub unsafe extern \"C\" fn {name}")
                });
                let body = line.strip_suffix(") {").filter(|_| is_signature);
                is_signature &= body.is_none();
                let line = body.map_or(line.clone(), |it| format!("{it}) -> GeosweepStatus {{"));
                expanded += &format!("{line}\n");
            }
        }
    }
    expanded
}

fn generated() -> String {
    let config = cbindgen::Config::from_file(format!("{SOURCES}/cbindgen.toml")).unwrap();
    let builder = cbindgen::Builder::new().with_config(config);
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("header");
    fs::create_dir_all(&folder).unwrap();
    let builder = FILES.iter().fold(builder, |builder, file| {
        let source = fs::read_to_string(format!("{SOURCES}/{file}.rs")).unwrap();
        let path = folder.join(format!("{file}.rs"));
        fs::write(&path, expanded(&source)).unwrap();
        builder.with_src(path)
    });
    let mut header = Vec::new();
    builder.generate().unwrap().write(&mut header);
    String::from_utf8(header).unwrap()
}

/// If `GEOSWEEP_UPDATE_HEADER` is set, the test writes the header anew.
#[test]
fn the_header_is_that_of_the_sources() {
    let generated = generated();
    if std::env::var_os("GEOSWEEP_UPDATE_HEADER").is_some() {
        fs::write(HEADER, &generated).unwrap();
    }
    let committed = fs::read_to_string(HEADER).unwrap_or_default();
    assert!(
        committed == generated,
        "crates/capi/src/geosweep.h is not that of crates/capi/src/*.rs; renew it, look at it and commit it:\n    \
         GEOSWEEP_UPDATE_HEADER=1 cargo test --release --all-features --test capi header\n\
         first lines that differ: {:#?}",
        committed.lines().zip(generated.lines()).find(|(a, b)| a != b)
    );
}

#[test]
fn no_source_file_is_forgotten() {
    let here = fs::read_dir(SOURCES).unwrap().filter_map(|entry| {
        let name = entry.unwrap().file_name().into_string().unwrap();
        name.strip_suffix(".rs").map(str::to_owned)
    });
    let named = FILES.iter().chain(&INTERNAL).map(|&file| file.to_owned());
    assert_eq!(here.collect::<BTreeSet<_>>(), named.collect());
}
