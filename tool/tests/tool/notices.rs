//! The notices of third parties in binaries: THIRD-PARTY.txt, generated from the packages themselves.
//!
//! `GEOSWEEP_UPDATE_NOTICES=1` writes it anew, for all the platforms in `PLATFORMS`. The test compares it
//! with the packages of the first platform only, since those of others may be missing here.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
const FILE: &str = "THIRD-PARTY.txt";
const PLATFORMS: [&str; 4] = [
    "x86_64-unknown-linux-gnu",
    "x86_64-pc-windows-gnu",
    "x86_64-pc-windows-msvc",
    "aarch64-apple-darwin",
];

/// A package that some binary contains.
struct Package {
    /// Name and version, as in `serde 1.0.0`.
    name: String,
    /// Licences as in its manifest.
    licences: String,
    authors: String,
    folder: PathBuf,
}

/// Returns the output of a cargo command, run without the network.
fn cargo(args: &[&str]) -> String {
    let output =
        Command::new(env!("CARGO")).args(args).arg("--offline").current_dir(ROOT).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    text
}

/// Returns all packages that are built for a platform, including those for tests and tools.
fn all_packages(platform: &str) -> Vec<Package> {
    let text = cargo(&["metadata", "--format-version", "1", "--filter-platform", platform]);
    let metadata: Value = serde_json::from_str(&text).unwrap();
    let built = metadata["resolve"]["nodes"].as_array().unwrap().iter().map(|node| &node["id"]);
    let built: Vec<_> = built.collect();
    let text_of = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    let authors = |list: &Value| {
        list.as_array().into_iter().flatten().map(text_of).collect::<Vec<_>>().join(", ")
    };
    let packages = metadata["packages"].as_array().unwrap().iter();
    let package = |package: &Value| Package {
        name: format!("{} {}", text_of(&package["name"]), text_of(&package["version"])),
        licences: text_of(&package["license"]),
        authors: authors(&package["authors"]),
        folder: Path::new(package["manifest_path"].as_str().unwrap()).parent().unwrap().into(),
    };
    packages.filter(|package| built.contains(&&package["id"])).map(package).collect()
}

/// Returns the packages in the tool, in the library for C and in the package for Python, for a platform. Packages that
/// only run during the build are not contained in them.
fn packages(platform: &str) -> Vec<Package> {
    let binaries = ["-p", "geosweep-cli", "-p", "geosweep-capi", "-p", "geosweep-python"];
    let ours = [&["tree", "-p", "geosweep", "--all-features"][..], &binaries].concat();
    let edges = ["--edges", "normal,no-proc-macro"];
    let looks = ["--prefix", "none", "--format", "{p}|", "--target", platform];
    let contained = cargo(&[&ours[..], &edges, &looks].concat()).replace(" v", " ");
    let all = all_packages(platform).into_iter();
    // For the workspace's own packages, the tree also prints the folders.
    let is_contained = |package: &Package| {
        contained.lines().any(|line| line.starts_with(&format!("{}|", package.name)))
    };
    let mut packages: Vec<_> = all.filter(is_contained).collect();
    packages.sort_by(|a, b| a.name.cmp(&b.name));
    packages
}

/// Returns the licences that deny.toml allows, in its order.
fn allowed() -> Vec<String> {
    let text = fs::read_to_string(Path::new(ROOT).join("deny.toml")).unwrap();
    let (_, list) = text.split_once("\nallow = [").unwrap();
    list.split_once(']').unwrap().0.split('"').skip(1).step_by(2).map(str::to_owned).collect()
}

impl Package {
    /// Returns the licence, among those offered, under which binaries contain the package.
    fn licence<'a>(&self, allowed: &'a [String]) -> &'a str {
        let licences = self.licences.replace('/', " OR ");
        let offered: Vec<_> = licences.split(" OR ").map(str::trim).collect();
        let first = allowed.iter().find(|licence| offered.contains(&licence.as_str()));
        first.unwrap_or_else(|| panic!("{}: deny.toml allows none of {licences}", self.name))
    }

    /// Returns the package's files whose names begin with one of some words, in lower case.
    fn files(&self, words: &[&str]) -> Vec<String> {
        let mut files: Vec<_> = fs::read_dir(&self.folder)
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .filter(|path| {
                let name = path.file_name().unwrap().to_string_lossy().to_lowercase();
                words.iter().any(|word| name.starts_with(word))
            })
            .collect();
        files.sort();
        files.iter().map(|path| fs::read_to_string(path).unwrap()).collect()
    }

    /// Returns the texts that are required in addition to the licence's name. These are the licence's text
    /// and notices of what the package itself contains. Apache's text has no line of copyright and is given
    /// once for all packages.
    fn texts(&self, licence: &str) -> Vec<String> {
        let mut texts = self.files(&["notice"]);
        if licence != "Apache-2.0" {
            let own = self.files(&["licen", "copying"]);
            if own.is_empty() {
                assert_eq!(licence, "MIT", "{} holds no text of its licence", self.name);
                let mit = fs::read_to_string(Path::new(ROOT).join("LICENSE-MIT")).unwrap();
                let (_, permission) = mit.split_once("\n\n").unwrap().1.split_once("\n\n").unwrap();
                texts.push(format!("Copyright (c) {}\n\n{permission}", self.authors));
            }
            texts.extend(own);
        }
        if self.name.starts_with("dejavu ") {
            let fonts = self.folder.join("assets/dejavu-fonts-ttf-2.37/LICENSE");
            texts.push(fs::read_to_string(fonts).unwrap());
        }
        texts.iter().map(|text| tidy(text)).collect()
    }
}

/// Removes differences of line ends and of trailing white space.
fn tidy(text: &str) -> String {
    let lines =
        text.trim_start_matches('\u{feff}').lines().map(|line| line.trim_end().to_owned() + "\n");
    lines.collect::<String>().trim_matches('\n').to_owned() + "\n"
}

fn line(package: &Package, licence: &str) -> String {
    format!("{:<36} {licence}\n", package.name)
}

/// Returns the whole file.
fn notices(packages: &[Package], allowed: &[String]) -> String {
    let mut text = String::from(
        "Notices of third parties\n\n\
         The tool geosweep, the library for C and the package for Python contain packages of this list, and the\n\
         standard library of Rust (https://rust-lang.org), which is under MIT or Apache-2.0. The right column\n\
         says under which licence. Apache's is at the end; before it are the others, and notices.\n\n",
    );
    let mut texts: BTreeMap<String, Vec<&str>> = BTreeMap::new();
    for package in packages {
        let licence = package.licence(allowed);
        text += &line(package, licence);
        package
            .texts(licence)
            .into_iter()
            .for_each(|text| texts.entry(text).or_default().push(&package.name));
    }
    let mut texts: Vec<_> =
        texts.into_iter().map(|(text, names)| (names.join(", "), text)).collect();
    texts.sort();
    let apache = fs::read_to_string(Path::new(ROOT).join("LICENSE-APACHE")).unwrap();
    texts.push(("Apache-2.0".into(), tidy(&apache)));
    let rule = "-".repeat(100);
    texts.iter().for_each(|(names, body)| write!(text, "\n{rule}\n{names}\n\n{body}").unwrap());
    text
}

/// The test is equivalent to `cargo deny check licenses`, and does not need it.
#[test]
fn licences_of_all_packages_are_allowed() {
    let allowed = allowed();
    let config = fs::read_to_string(Path::new(ROOT).join("deny.toml")).unwrap();
    let packages = all_packages(PLATFORMS[0]);
    assert!(packages.len() > 150, "{} packages are few", packages.len());
    for Package { name, licences, .. } in &packages {
        let exception = |licence: &str| {
            let crate_name = name.split(' ').next().unwrap();
            config.contains(&format!("crate = \"{crate_name}\", allow = [\"{licence}\"]"))
        };
        let is_allowed =
            |licence: &str| allowed.iter().any(|other| other == licence) || exception(licence);
        let licences = licences.replace('/', " OR ");
        let mut parts = licences.split(" AND ").map(|part| part.trim_matches(['(', ')']));
        let one_of = |part: &str| part.split(" OR ").any(|licence| is_allowed(licence.trim()));
        assert!(parts.all(one_of), "{name}: deny.toml does not allow {licences}");
    }
}

#[test]
fn notices_of_third_parties_are_those_of_the_packages() {
    let (path, allowed) = (Path::new(ROOT).join(FILE), allowed());
    if std::env::var_os("GEOSWEEP_UPDATE_NOTICES").is_some() {
        let all = PLATFORMS.into_iter().flat_map(packages);
        let all: BTreeMap<_, _> = all.map(|package| (package.name.clone(), package)).collect();
        let others = all.into_values().filter(|package| !package.name.starts_with("geosweep"));
        fs::write(&path, notices(&others.collect::<Vec<_>>(), &allowed)).unwrap();
    }
    let committed = fs::read_to_string(path).unwrap();
    let found = packages(PLATFORMS[0]);
    assert!(found.len() > 60, "{} packages are few", found.len());
    let cure = "GEOSWEEP_UPDATE_NOTICES=1 cargo test -p geosweep-cli notices";
    for package in found.iter().filter(|package| !package.name.starts_with("geosweep")) {
        let licence = package.licence(&allowed);
        let name = &package.name;
        assert!(committed.contains(&line(package, licence)), "{FILE} lacks {name}: {cure}");
        let is_there = |text: &String| committed.contains(text);
        assert!(
            package.texts(licence).iter().all(is_there),
            "{FILE} lacks a text of {name}: {cure}"
        );
    }
    let lock = fs::read_to_string(Path::new(ROOT).join("Cargo.lock")).unwrap();
    let (list, _) = committed.split_once("\n\n---").unwrap();
    for line in list.lines().skip_while(|line| !line.is_empty()).skip(6) {
        let mut words = line.split_whitespace();
        let [name, version] = [words.next().unwrap(), words.next().unwrap()];
        let entry = format!("name = \"{name}\"\nversion = \"{version}\"\n");
        assert!(lock.contains(&entry), "{FILE} has {name} {version}, Cargo.lock does not: {cure}");
    }
}
