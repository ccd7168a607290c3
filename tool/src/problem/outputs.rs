//! Output files that are neither inputs nor one another.

use std::fs;
use std::path::Path;

use geosweep::io::OutputFile;

/// Refuses to write a file twice, or over an input: the same file under two names is rare and
/// worth an error before anything is lost.
pub fn check_outputs<'a>(
    outputs: &[&OutputFile],
    inputs: impl Iterator<Item = &'a Path>,
) -> Result<(), String> {
    for (index, output) in outputs.iter().enumerate() {
        if outputs[..index].iter().any(|before| before.is_same(output)) {
            let name = output.path().display();
            return Err(format!("{name}: is given for two outputs; choose another name"));
        }
    }
    let resolve = |path: &Path| fs::canonicalize(path).ok();
    let inputs: Vec<_> = inputs.filter_map(resolve).collect();
    for output in outputs {
        let target = resolve(output.path());
        if target.is_some_and(|target| inputs.contains(&target)) {
            let name = output.path().display();
            return Err(format!("{name}: is also an input; choose another name"));
        }
    }
    Ok(())
}
