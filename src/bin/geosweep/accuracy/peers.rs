//! What other solvers achieve, measured elsewhere and read from a table.

use std::error::Error;
use std::path::Path;

use geosweep::surface::builtin::Builtin;

/// One map by another solver.
#[derive(Clone, Debug, PartialEq)]
pub struct Peer {
    pub builtin: Builtin,
    /// Points a side.
    pub points: usize,
    pub solver: String,
    pub seconds: f64,
    /// Mean relative error.
    pub mean: f64,
}

const HEADER: &str = "surface,size,solver,seconds,mean_error";

/// Reads a table with [`HEADER`] as its first line.
pub fn read(path: &Path) -> Result<Vec<Peer>, Box<dyn Error>> {
    let text =
        std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
    parse(&text).map_err(|problem| format!("{}: {problem}", path.display()).into())
}

/// Rows by solver, then surface, then size.
fn parse(text: &str) -> Result<Vec<Peer>, String> {
    let mut lines = text.lines().map(str::trim).enumerate();
    if lines.next().map(|(_, line)| line) != Some(HEADER) {
        return Err(format!("the first line is not `{HEADER}`"));
    }
    let mut peers = lines
        .filter(|(_, line)| !line.is_empty())
        .map(|(index, line)| peer(line).map_err(|problem| format!("line {}: {problem}", index + 1)))
        .collect::<Result<Vec<_>, _>>()?;
    let key = |peer: &Peer| (peer.solver.clone(), peer.builtin.to_string(), peer.points);
    peers.sort_by_key(key);
    Ok(peers)
}

fn peer(line: &str) -> Result<Peer, String> {
    let cells: Vec<_> = line.split(',').map(str::trim).collect();
    let [surface, size, solver, seconds, mean] = cells[..] else {
        return Err(format!("{} cells instead of 5", cells.len()));
    };
    let positive = |cell: &str| match cell.parse::<f64>() {
        Ok(number) if number > 0.0 && number.is_finite() => Ok(number),
        _ => Err(format!("`{cell}` is no positive number")),
    };
    Ok(Peer {
        builtin: surface.parse()?,
        points: crate::study::size(size)?,
        solver: solver.to_owned(),
        seconds: positive(seconds)?,
        mean: positive(mean)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_read_in_order_of_solver_and_size() {
        let text =
            format!("{HEADER}\nsphere,65,walker,0.5,1e-3\n\nsphere, 33, walker, 0.25, 2e-3\n");
        let peers = parse(&text).unwrap();
        assert_eq!(peers.iter().map(|peer| peer.points).collect::<Vec<_>>(), [33, 65]);
        let expected = Peer {
            builtin: Builtin::Sphere,
            points: 65,
            solver: "walker".into(),
            seconds: 0.5,
            mean: 1e-3,
        };
        assert_eq!(peers[1], expected);
    }

    #[test]
    fn wrong_rows_say_where_and_what() {
        for (row, part) in [
            ("sphere,65,walker,0.5", "4 cells"),
            ("teapot,65,walker,0.5,1e-3", "teapot"),
            ("sphere,65.5,walker,0.5,1e-3", "`65.5`"),
            ("sphere,65,walker,-1,1e-3", "`-1`"),
        ] {
            let problem = parse(&format!("{HEADER}\n{row}")).unwrap_err();
            assert!(problem.contains("line 2") && problem.contains(part), "{problem}");
        }
        assert!(parse("sphere,65,walker,0.5,1e-3").unwrap_err().contains(HEADER));
    }
}
