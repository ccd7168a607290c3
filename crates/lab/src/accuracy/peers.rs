//! Reads the results of other solvers, measured elsewhere, from a table.

use std::error::Error;
use std::path::Path;

use geosweep::shown::exact;
use geosweep::surface::builtin::Builtin;
use serde::Deserialize;

/// One map by another solver.
#[derive(Clone, Debug, PartialEq)]
pub struct Peer {
    pub builtin: Builtin,
    /// The number of points per side.
    pub points: usize,
    pub solver: String,
    pub seconds: f64,
    /// The mean relative error.
    pub mean: f64,
}

/// A row of the table. Other columns are ignored.
#[derive(Deserialize)]
struct Row {
    surface: String,
    size: String,
    solver: String,
    /// The time; empty if the solver did not finish.
    seconds: Option<f64>,
    mean_error: Option<f64>,
}

/// Reads a CSV table with at least the columns surface, size, solver, seconds and mean_error.
///
/// Rows of solvers that did not finish are left out. So are rows of geosweep itself, except those in double
/// precision.
pub fn read(path: &Path) -> Result<Vec<Peer>, Box<dyn Error>> {
    let text =
        std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
    parse(&text).map_err(|problem| format!("{}: {problem}", path.display()).into())
}

/// Parses a table. The result is sorted by solver, then surface, then size.
fn parse(text: &str) -> Result<Vec<Peer>, String> {
    let mut table = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
    let mut peers = Vec::new();
    for (index, row) in table.deserialize::<Row>().enumerate() {
        let row = row.map_err(|error| error.to_string())?;
        let peer = peer(row).map_err(|problem| format!("row {}: {problem}", index + 1))?;
        peers.extend(peer);
    }
    let key = |peer: &Peer| (peer.solver.clone(), peer.builtin.to_string(), peer.points);
    peers.sort_by_key(key);
    Ok(peers)
}

fn peer(row: Row) -> Result<Option<Peer>, String> {
    let Row { surface, size, solver, seconds, mean_error } = row;
    let (builtin, points) = (surface.parse()?, crate::lists::size(&size)?);
    let (Some(seconds), Some(mean)) = (seconds, mean_error) else { return Ok(None) };
    for number in [seconds, mean] {
        if !(number > 0.0 && number.is_finite()) {
            return Err(format!("`{}` is not a positive number", exact(number)));
        }
    }
    let solver = match solver.strip_prefix("geosweep cpu, ") {
        Some(front) if front.ends_with(", double precision") => front.to_owned(),
        _ if solver.starts_with("geosweep") => return Ok(None),
        _ => solver,
    };
    Ok(Some(Peer { builtin, points, solver, seconds, mean }))
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "surface,size,solver,seconds,mean_error,remark";

    #[test]
    fn rows_are_read_in_order_of_solver_and_size() {
        let rows = [
            r#"sphere,65,"walker, fast",0.5,1e-3,"#,
            r#"sphere, 33,"walker, fast", 0.25, 2e-3,"#,
            "sphere,33,sleeper,,,not done in 40 s",
            r#"sphere,33,"geosweep cpu, planar",0.1,1e-3,"#,
            r#"sphere,33,"geosweep vulkan, curved",0.1,1e-3,"#,
            r#"sphere,129,"geosweep cpu, curved, double precision",0.1,1e-6,"#,
        ];
        let mut peers = parse(&format!("{HEADER}\n{}\n", rows.join("\n"))).unwrap();
        assert_eq!(peers.remove(0).solver, "curved, double precision");
        assert_eq!(peers.iter().map(|peer| peer.points).collect::<Vec<_>>(), [33, 65]);
        let expected = Peer {
            builtin: Builtin::Sphere,
            points: 65,
            solver: "walker, fast".into(),
            seconds: 0.5,
            mean: 1e-3,
        };
        assert_eq!(peers[1], expected);
    }

    #[test]
    fn wrong_rows_say_where_and_what() {
        for (row, place, part) in [
            ("sphere,65,walker,0.5", "line: 2", "4 fields"),
            ("teapot,65,walker,0.5,1e-3,", "row 1", "teapot"),
            ("sphere,65.5,walker,0.5,1e-3,", "row 1", "`65.5`"),
            ("sphere,65,walker,-1,1e-3,", "row 1", "`-1`"),
            ("sphere,65,walker,fast,1e-3,", "line: 2", "float"),
        ] {
            let problem = parse(&format!("{HEADER}\n{row}")).unwrap_err();
            assert!(problem.contains(place) && problem.contains(part), "{problem}");
        }
        let headless = parse("sphere,65,walker\nsphere,65,walker").unwrap_err();
        assert!(headless.contains("surface"), "{headless}");
    }
}
