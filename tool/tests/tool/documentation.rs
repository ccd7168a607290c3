//! Runs the commands in README and docs, and compares their output with the pages.
//!
//! A block of the language `console` is a session. Lines after `$ ` are run, in the order of the page and in
//! one folder with the repository's examples. The lines after them are the expected output on both streams.
//! Times may differ; `[..]` stands for anything within a line and `...` for any lines. Commands in blocks of
//! the language `sh` are not run here: they install, build, or need something that tests do not have.

use std::env;
use std::ffi::OsString;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;

use assert_cmd::cargo::cargo_bin;
use geosweep::io::write_npy;
use snapbox::{Assert, Data};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

/// Returns the pages for users.
fn pages() -> Vec<String> {
    let docs = fs::read_dir(Path::new(ROOT).join("docs")).unwrap();
    let names = docs.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut pages: Vec<_> =
        names.filter(|name| name.ends_with(".md")).map(|name| format!("docs/{name}")).collect();
    pages.extend(["README.md".into(), "CONTRIBUTING.md".into(), "benches/peers/README.md".into()]);
    pages.sort();
    pages
}

/// Returns the lines of a page's blocks in a language.
fn blocks(page: &str, language: &str) -> Vec<String> {
    let text = fs::read_to_string(Path::new(ROOT).join(page)).unwrap();
    let fences = text.split("```").skip(1).step_by(2);
    let blocks = fences.filter_map(|block| block.strip_prefix(language)?.strip_prefix('\n'));
    blocks.map(str::to_owned).collect()
}

/// A command and its expected output.
struct Step {
    command: String,
    printed: String,
}

fn steps(page: &str) -> Vec<Step> {
    let mut steps: Vec<Step> = Vec::new();
    for block in blocks(page, "console") {
        let mut is_continued = false;
        for line in block.lines() {
            if let Some(command) = line.strip_prefix("$ ") {
                steps.push(Step { command: format!("{command}\n"), printed: String::new() });
            } else {
                let step = steps.last_mut().unwrap_or_else(|| panic!("{page}: no command yet"));
                let text = if is_continued { &mut step.command } else { &mut step.printed };
                text.push_str(line);
                text.push('\n');
            }
            let of_command = line.starts_with("$ ") || is_continued;
            is_continued = of_command && line.ends_with('\\');
        }
    }
    steps
}

/// Replaces times by wildcards: `12.3 ms;` becomes `[..]s;`.
fn with_any_time(text: &str) -> String {
    let line = |line: &str| {
        let mut words: Vec<String> = Vec::new();
        for word in line.split(' ') {
            let unit = word.trim_end_matches([';', ',', '.']);
            let is_time = ["s", "ms"].contains(&unit)
                && words.last().is_some_and(|number| number.parse::<f64>().is_ok());
            match words.last_mut() {
                Some(last) if is_time => *last = format!("[..]s{}", &word[unit.len()..]),
                _ => words.push(word.into()),
            }
        }
        words.join(" ") + "\n"
    };
    text.lines().map(line).collect()
}

/// Returns the file that README creates with three lines of Python.
fn hills() -> Vec<u8> {
    let x = |index: usize| 6.0 * index as f64 / 299.0;
    let height = |index: usize| x(index / 300).sin() * x(index % 300).cos();
    let mut bytes = Vec::new();
    write_npy(&mut bytes, &[300, 300], &(0..300 * 300).map(height).collect::<Vec<_>>()).unwrap();
    bytes
}

/// Runs the sessions of a page.
fn run(page: &str) {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("hills.npy"), hills()).unwrap();
    symlink(
        Path::new(ROOT).canonicalize().unwrap().join("examples"),
        folder.path().join("examples"),
    )
    .unwrap();
    let tool = cargo_bin("geosweep");
    let folders = env::split_paths(&env::var_os("PATH").unwrap_or_default()).collect::<Vec<_>>();
    let path: OsString =
        env::join_paths([tool.parent().unwrap().to_owned()].into_iter().chain(folders)).unwrap();
    for Step { command, printed } in steps(page) {
        let output = Command::new("bash")
            .args(["-c", &format!("exec 2>&1; {command}")])
            .current_dir(folder.path())
            .env("PATH", &path)
            .output()
            .unwrap();
        let found = String::from_utf8(output.stdout).unwrap();
        assert!(output.status.success(), "{page}: {command}{found}");
        let expected = Data::text(with_any_time(&printed));
        if let Err(error) = Assert::new().try_eq(Some(&command), Data::text(found), expected) {
            panic!("{page}: {error}");
        }
    }
}

#[test]
fn the_commands_of_readme_and_maps_run() {
    ["README.md", "docs/closed.md", "docs/maps.md", "docs/errors.md", "docs/limits.md"]
        .iter()
        .for_each(|page| run(page));
}

#[test]
fn the_commands_on_what_one_does_with_maps_run() {
    ["docs/geometry.md", "docs/directions.md", "docs/pairwise.md", "docs/gallery.md"]
        .iter()
        .for_each(|page| run(page));
}

#[test]
fn the_commands_on_time_and_profiles_run() {
    ["docs/profiling.md", "docs/speed.md"].iter().for_each(|page| run(page));
}

/// No page is missing above, and no command of the tool is in a block that is not run.
#[test]
fn every_command_of_the_documentation_is_run() {
    let run = [
        "README.md",
        "docs/closed.md",
        "docs/directions.md",
        "docs/errors.md",
        "docs/gallery.md",
        "docs/geometry.md",
        "docs/limits.md",
        "docs/maps.md",
        "docs/pairwise.md",
        "docs/profiling.md",
        "docs/speed.md",
    ];
    let (mut commands, mut others) = (0, Vec::new());
    for page in pages() {
        let here = steps(&page).len();
        assert!(here == 0 || run.contains(&page.as_str()), "{page} is not run");
        commands += here;
        let lines = blocks(&page, "sh").concat();
        others.extend(lines.lines().map(|line| format!("{page}: {line}")));
    }
    assert!(commands >= 15, "{commands} commands are few");
    // Not every machine has RenderDoc's launcher.
    let not_run = others.iter().filter(|line| {
        line.contains(": geosweep ") && !line.contains("RENDERDOC") && !line.contains("--renderdoc")
    });
    assert_eq!(not_run.collect::<Vec<_>>(), Vec::<&String>::new(), "these are not run");
}
