//! What the tests of the tool share: running it, and what it must not leave behind.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use assert_cmd::cargo::cargo_bin_cmd;
use geosweep::io::{read_map, write_npy};
use serde_json::Value;
use tempfile::TempDir;

/// A folder of inputs and one of outputs, in which only what was asked for may appear.
pub struct Workbench {
    pub inputs: TempDir,
    pub outputs: TempDir,
}

impl Workbench {
    pub fn new() -> Self {
        Self { inputs: tempfile::tempdir().unwrap(), outputs: tempfile::tempdir().unwrap() }
    }

    pub fn input(&self, name: &str, bytes: impl AsRef<[u8]>) -> String {
        let path = self.inputs.path().join(name);
        fs::write(&path, bytes).unwrap();
        path.to_str().unwrap().to_owned()
    }

    pub fn array(&self, name: &str, shape: &[usize], values: &[f64]) -> String {
        let mut bytes = Vec::new();
        write_npy(&mut bytes, shape, values).unwrap();
        self.input(name, bytes)
    }

    pub fn flat(&self, rows: usize, cols: usize) -> String {
        self.array("flat.npy", &[rows, cols], &vec![0.0; rows * cols])
    }

    pub fn output(&self, name: &str) -> PathBuf {
        self.outputs.path().join(name)
    }

    /// Runs the tool in the folder of outputs.
    pub fn run(&self, args: impl IntoIterator<Item = impl AsRef<OsStr>>) -> Output {
        cargo_bin_cmd!("geosweep").current_dir(self.outputs.path()).args(args).output().unwrap()
    }

    /// Runs `geosweep distance` on the CPU with the words of a command line.
    pub fn distance(&self, surface: &str, words: &str) -> Output {
        let words = words.split_whitespace();
        self.run(["distance", surface, "--engine", "cpu"].into_iter().chain(words))
    }

    pub fn outputs(&self) -> Vec<String> {
        let entries = fs::read_dir(self.outputs.path()).unwrap();
        let mut names: Vec<_> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// The tool must refuse, in one message with all these parts, and leave nothing behind.
    pub fn refuses(&self, output: &Output, parts: &[&str]) {
        let stderr = stderr(output);
        assert_eq!(output.status.code(), Some(2), "{stderr}");
        assert_eq!(stderr.matches("geosweep: error: ").count(), 1, "{stderr}");
        for part in parts {
            assert!(stderr.contains(part), "`{part}` is missing in: {stderr}");
        }
        assert!(output.stdout.is_empty(), "{}", String::from_utf8_lossy(&output.stdout));
        assert_eq!(self.outputs(), [""; 0], "{stderr}");
    }
}

pub fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// The distances of a map.
pub fn map(path: &Path) -> Vec<f64> {
    read_map(path).unwrap().values
}

pub fn json(output: &Output) -> Value {
    assert!(output.status.success(), "{}", stderr(output));
    serde_json::from_slice(&output.stdout).unwrap()
}
