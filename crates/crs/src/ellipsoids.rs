//! Looks up the ellipsoids of the geographic coordinate reference systems of the EPSG register (v11.022), and their unit
//! of angles.

use geosweep_surface::Ellipsoid;

/// A line for each ellipsoid: its radius in metres, its inverse flattening, the unit of angles, and the numbers of the
/// systems with both. All systems between the ends of a run have them.
const ELLIPSOIDS: &str = include_str!("epsg_ellipsoids.csv");

/// Returns the ellipsoid of a geographic system, or `None` if the register has no such system.
///
/// # Errors
/// If its longitudes and latitudes are not in degrees.
pub fn of_system(epsg: u16) -> Result<Option<Ellipsoid>, String> {
    let holds = |runs: &str| {
        let mut runs = runs.split(' ').map(|run| run.split_once('-').unwrap_or((run, run)));
        runs.any(|(first, last)| {
            let ends = [first, last].map(|end| end.parse::<u16>());
            matches!(ends, [Ok(first), Ok(last)] if (first..=last).contains(&epsg))
        })
    };
    let lines = ELLIPSOIDS.lines().skip(1).filter_map(|line| {
        let mut fields = line.split(',');
        let [radius, inverse, unit, runs] = [(); 4].map(|()| fields.next().unwrap_or_default());
        let ellipsoid = Ellipsoid::new(radius.parse().ok()?, inverse.parse().ok()?)?;
        Some((ellipsoid, unit, runs))
    });
    match lines.into_iter().find(|(_, _, runs)| holds(runs)) {
        None => Ok(None),
        Some((ellipsoid, "degree", _)) => Ok(Some(ellipsoid)),
        Some((_, unit, _)) => Err(not_degrees(&format!("{unit}s (EPSG:{epsg})"))),
    }
}

/// Returns the message for angles in another unit.
pub fn not_degrees(unit: &str) -> String {
    format!(
        "its longitudes and latitudes are in {unit}, not in degrees; gdalwarp -t_srs EPSG:4326 makes a grid of degrees"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn systems_have_their_ellipsoids() {
        let of = |epsg| of_system(epsg).unwrap();
        assert_eq!(of(4326), Some(Ellipsoid::WGS_84));
        assert_eq!(of(4979), Some(Ellipsoid::WGS_84));
        assert_eq!(of(4277), Ellipsoid::new(6_377_563.396, 299.324_964_6));
        assert_eq!(of(4052), Ellipsoid::new(6_370_997.0, 0.0));
        assert_eq!(of(1), None);
        assert!(of_system(4807).unwrap_err().contains("grads"));
        let systems = ELLIPSOIDS.lines().skip(1).map(|line| line.split(',').count());
        assert!(systems.clone().all(|fields| fields == 4) && systems.count() > 50);
    }
}
