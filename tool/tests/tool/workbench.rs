//! Shared parts of the tool's tests: they run the tool, and check what it leaves behind.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;
use std::sync::LazyLock;

use assert_cmd::Command;
use geosweep::io::{read_map, write_npy};
use jsonschema::Validator;
use serde_json::Value;
use tempfile::TempDir;

/// A folder of inputs and one of outputs, in which only requested files may appear.
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

    /// Writes a tube of 9 x 33 points whose last column repeats its first.
    pub fn tube(&self) -> String {
        let angle = |col: usize| std::f64::consts::TAU * (col % 32) as f64 / 32.0;
        let point = |index: usize| {
            let (row, col) = (index / 33, index % 33);
            [angle(col).cos(), angle(col).sin(), 0.3 * row as f64]
        };
        self.array("tube.npy", &[9, 33, 3], &(0..9 * 33).flat_map(point).collect::<Vec<_>>())
    }

    pub fn output(&self, name: &str) -> PathBuf {
        self.outputs.path().join(name)
    }

    /// Returns a command that runs the tool in the folder of outputs.
    pub fn command(&self) -> Command {
        let mut command = Command::new(crate::TOOL);
        command.current_dir(self.outputs.path());
        command
    }

    /// Runs the tool.
    pub fn run_args(&self, args: impl IntoIterator<Item = impl AsRef<OsStr>>) -> Output {
        self.command().args(args).output().unwrap()
    }

    /// Runs the tool with the words of a command line.
    pub fn run(&self, line: impl AsRef<str>) -> Output {
        self.run_args(line.as_ref().split_whitespace())
    }

    /// Runs a command line that must succeed.
    pub fn done(&self, line: impl AsRef<str>) -> Output {
        let output = self.run(line.as_ref());
        assert!(output.status.success(), "{}: {}", line.as_ref(), stderr(&output));
        output
    }

    /// Returns the JSON output of a command line that must succeed.
    pub fn json(&self, line: impl AsRef<str>) -> Value {
        json(&self.run(line))
    }

    /// Asserts that the tool refuses a command line, as [`Self::refuses`] does.
    pub fn refuse(&self, line: impl AsRef<str>, parts: &[&str]) {
        self.refuses(&self.run(line), parts);
    }

    /// Returns the contents of an output file.
    pub fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.output(name)).unwrap()
    }

    /// Returns an output file as text.
    pub fn text(&self, name: &str) -> String {
        String::from_utf8(self.read(name)).unwrap()
    }

    /// Returns the distances of a map that was written.
    pub fn map(&self, name: &str) -> Vec<f64> {
        map(&self.output(name))
    }

    /// Returns the rows of a float64 array (K, 5) that was written, split where they are NaN.
    pub fn curves(&self, name: &str) -> Vec<Vec<[f64; 5]>> {
        curves(&self.read(name))
    }

    /// Runs `geosweep distance` on the CPU with the words of a command line.
    pub fn distance(&self, surface: &str, words: &str) -> Output {
        self.run(format!("distance {surface} --engine cpu {words}"))
    }

    pub fn outputs(&self) -> Vec<String> {
        let entries = fs::read_dir(self.outputs.path()).unwrap();
        let mut names: Vec<_> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// Asserts that the tool has failed, with one message that has all these parts, and has left nothing
    /// behind.
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

/// Returns all messages except the line that says what was done.
pub fn notes(output: &Output) -> String {
    let said = stderr(output);
    let notes = said.lines().filter(|line| !line.starts_with("geosweep: done: "));
    notes.map(|line| format!("{line}\n")).collect()
}

/// Returns the distances of a map.
pub fn map(path: &Path) -> Vec<f64> {
    read_map(path).unwrap().values
}

/// Returns the JSON output of a command that has succeeded.
pub fn json(output: &Output) -> Value {
    assert!(output.status.success(), "{}", stderr(output));
    printed_json(output)
}

/// Returns the JSON output, which is one line and satisfies docs/geosweep.schema.json.
pub fn printed_json(output: &Output) -> Value {
    static SCHEMA: LazyLock<Validator> = LazyLock::new(|| {
        let schema = include_str!("../../../docs/geosweep.schema.json");
        jsonschema::validator_for(&serde_json::from_str(schema).unwrap()).unwrap()
    });
    let text = str::from_utf8(&output.stdout).unwrap();
    assert_eq!(text.lines().count(), 1, "{text}");
    let printed = serde_json::from_str(text).unwrap();
    if let Err(error) = SCHEMA.validate(&printed) {
        // The command's name selects the part of the schema.
        let command = printed["command"].as_str().unwrap_or_default().replace(' ', "-");
        panic!("{command}: at {}: {error}\n{text}", error.instance_path());
    }
    printed
}

/// Returns the rows of a float64 array (K, 5), split where they are NaN.
fn curves(bytes: &[u8]) -> Vec<Vec<[f64; 5]>> {
    let length = u16::from_le_bytes([bytes[8], bytes[9]]) as usize;
    let header = std::str::from_utf8(&bytes[10..10 + length]).unwrap();
    assert!(header.contains("'descr': '<f8'") && header.contains(", 5)"), "{header}");
    let values: Vec<f64> =
        bytes[10 + length..].as_chunks().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
    let rows = values.as_chunks::<5>().0;
    rows.split(|row| row[0].is_nan()).map(<[_]>::to_vec).collect()
}
