//! Compares the CPU engine's times with those of an earlier commit, so that the cost of a change is seen
//! before it lands. Usage: `cargo bench --bench floor -- COMMIT`. With words after the commit, only the rows
//! whose names contain one of the words are run. `--pairs N` takes N pairs of runs per row instead of 9.
//! `--tools BEFORE AFTER` instead of a commit compares two tools that are already built.
//!
//! The tool of the commit is built once in `target/floor/`, from a work tree of its own. The present tool is
//! built from the work tree as it is. Both run alternately, and each runs first in half of the pairs. A pair
//! gives the ratio of the two tools' `solve_seconds`. For each row the median of this ratio over the pairs is
//! printed, with its quartiles. On a shared machine the ratio of two runs side by side is more reliable than a time.

use std::path::{Path, PathBuf};
use std::process::{Command, exit};

/// The rows: what the tool computes, and with which fronts.
const ROWS: [(&str, &[&str]); 8] = [
    ("distance builtin:sphere:1200x1200 --source 60,60", FRONTS),
    ("distance builtin:sphere:400x400 --source 20,20", FRONTS),
    ("distance builtin:peaks:1200x1200 --source 60,60", FRONTS),
    ("distance builtin:maze:1200x1200 --source 0,0", FRONTS),
    ("distance builtin:face:300x300 --source 150,150", FRONTS),
    ("distance builtin:sheared-plane:400x400 --source 20,20", FRONTS),
    ("pairwise builtin:peaks:64x64 --iterations 1", &["planar"]),
    ("pairwise builtin:peaks:64x64", FRONTS),
];

/// Names of wavefronts. All commits accept the name `point` for circular fronts.
const FRONTS: &[&str] = &["planar", "point", "curved"];

/// Options that both tools accept for a distance map or matrix.
const ENGINE: [&str; 3] = ["--engine", "cpu", "--json"];

struct Options {
    commit: String,
    tools: Option<[PathBuf; 2]>,
    pairs: usize,
    words: Vec<String>,
}

fn main() {
    let options = options().unwrap_or_else(|message| fail(&message));
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/floor");
    std::fs::create_dir_all(&folder).expect("the target folder is writable");
    let [before, after] = match &options.tools {
        Some(tools) => tools.clone(),
        None => [tool_of(&options.commit, &folder), tool_of_today()],
    };
    let matrix = folder.join("matrix.npy");
    let name = &options.commit;
    println!("| | ms, {name} | ms, now | now / {name} | quartiles |");
    println!("|---|---:|---:|---:|---|");
    for (row, fronts) in ROWS {
        for front in fronts {
            let name = format!("{row}, {front}");
            if !options.words.is_empty() && !options.words.iter().any(|word| name.contains(word)) {
                continue;
            }
            let mut args: Vec<_> = row.split(' ').chain(["--wavefront", front]).collect();
            args.extend(ENGINE);
            if args[0] == "pairwise" {
                args.extend(["-o", matrix.to_str().expect("a path in UTF-8")]);
            }
            let [old, new, ratios] = pairs([&before, &after], &args, options.pairs);
            let [low, _, high] = quartiles(&ratios);
            let [old, new, ratio] = [&old, &new, &ratios].map(|of| quartiles(of)[1]);
            let (old, new) = (1e3 * old, 1e3 * new);
            println!("| {name} | {old:.2} | {new:.2} | {ratio:.3} | {low:.3} to {high:.3} |");
        }
    }
    // Only a row that writes a matrix creates the file.
    let _ = std::fs::remove_file(matrix);
}

/// Parses the arguments that `cargo bench` passes on. Cargo adds the flag `--bench` to them.
fn options() -> Result<Options, String> {
    let mut args = std::env::args().skip(1).filter(|arg| arg != "--bench");
    let mut options = Options { commit: String::new(), tools: None, pairs: 9, words: Vec::new() };
    while let Some(arg) = args.next() {
        let mut next = || args.next().ok_or_else(|| format!("{arg} lacks a value"));
        match arg.as_str() {
            "--pairs" => {
                let pairs = next()?;
                options.pairs = pairs.parse().map_err(|_| format!("{pairs} is no number"))?;
            }
            "--tools" => {
                options.tools = Some([next()?.into(), next()?.into()]);
                options.commit = "before".into();
            }
            _ if options.commit.is_empty() => options.commit = arg,
            _ => options.words.push(arg),
        }
    }
    match options.commit.is_empty() || options.pairs == 0 {
        true => Err("usage: cargo bench --bench floor -- COMMIT [WORD..] [--pairs N]".into()),
        false => Ok(options),
    }
}

/// Returns the seconds of both tools in `count` pairs of runs, and the ratios of the second tool's seconds to
/// the first tool's. One more pair runs before these pairs and does not count.
fn pairs(tools: [&Path; 2], args: &[&str], count: usize) -> [Vec<f64>; 3] {
    let mut found = [(); 3].map(|()| Vec::with_capacity(count));
    for pair in 0..=count {
        let mut seconds = [0.0; 2];
        for at in if pair % 2 == 0 { [0, 1] } else { [1, 0] } {
            seconds[at] = solve_seconds(tools[at], args);
        }
        if pair > 0 {
            let [old, new] = seconds;
            found.iter_mut().zip([old, new, new / old]).for_each(|(to, value)| to.push(value));
        }
    }
    found
}

/// Returns the solving time that the tool reports.
fn solve_seconds(tool: &Path, args: &[&str]) -> f64 {
    let output = Command::new(tool).args(args).output();
    let output = output.unwrap_or_else(|error| fail(&format!("{}: {error}", tool.display())));
    let text = String::from_utf8_lossy(&output.stdout);
    let seconds = text
        .split("\"solve_seconds\":")
        .nth(1)
        .and_then(|rest| rest.split([',', '}']).next()?.trim().parse().ok());
    seconds.unwrap_or_else(|| {
        let error = String::from_utf8_lossy(&output.stderr);
        fail(&format!("{} {}: {error}", tool.display(), args.join(" ")))
    })
}

/// Returns the first quartile, the median and the third quartile.
fn quartiles(of: &[f64]) -> [f64; 3] {
    let mut sorted = of.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len() - 1;
    let at = |place: f64| {
        let (below, share) = (place as usize, place.fract());
        sorted[below] * (1.0 - share) + sorted[last.min(below + 1)] * share
    };
    [0.25, 0.5, 0.75].map(|part| at(part * last as f64))
}

/// Builds the tool of the present work tree.
fn tool_of_today() -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    build(root, &root.join("target"))
}

/// Builds the tool of a commit, in a work tree of its own that is reused if it exists.
fn tool_of(commit: &str, folder: &Path) -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let git = |args: &[&str]| {
        let output = Command::new("git").arg("-C").arg(root).args(args).output();
        let output = output.unwrap_or_else(|error| fail(&format!("git: {error}")));
        if !output.status.success() {
            fail(&String::from_utf8_lossy(&output.stderr));
        }
        String::from_utf8_lossy(&output.stdout).trim().to_string()
    };
    let hash = git(&["rev-parse", "--verify", &format!("{commit}^{{commit}}")]);
    let tree = folder.join(&hash);
    if !tree.exists() {
        git(&["worktree", "prune"]);
        git(&["worktree", "add", "--detach", tree.to_str().expect("a path in UTF-8"), &hash]);
    }
    build(&tree, &tree.join("target"))
}

/// Builds the tool of a work tree.
fn build(tree: &Path, target: &Path) -> PathBuf {
    // Early commits have the tool in the library's package, behind a feature.
    let tool: &[&str] = match tree.join("tool/Cargo.toml").exists() {
        true => &["-p", "geosweep-cli"],
        false => &["--features", "cli"],
    };
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let status = Command::new(cargo)
        .args(["build", "--release", "--bin", "geosweep"])
        .args(tool)
        .arg("--target-dir")
        .arg(target)
        .current_dir(tree)
        .status();
    if !status.is_ok_and(|status| status.success()) {
        fail(&format!("the tool in {} does not build", tree.display()));
    }
    target.join("release").join(format!("geosweep{}", std::env::consts::EXE_SUFFIX))
}

fn fail(message: &str) -> ! {
    eprintln!("{message}");
    exit(1)
}
