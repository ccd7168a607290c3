//! Keeps devices open between the calls that compute one map, such as [`crate::distance_map`].

use std::process;
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::solver::HeadlessSolver;
use crate::Monitor;
use crate::vulkan::{DeviceChoice, VulkanError};

/// Device that no call is using.
struct Idle {
    choice: DeviceChoice,
    /// Process that opened the device. A child that the process makes by `fork` must not use the device.
    process: u32,
    solver: HeadlessSolver,
}

/// Idle devices; `None` if devices are closed after each call.
static IDLE: Mutex<Option<Vec<Idle>>> = Mutex::new(None);

/// Sets whether the calls of this process that compute one map on a Vulkan device, such as [`crate::distance_map`],
/// leave the device open for the next call with the same [`DeviceChoice`]. Opening a device takes 0.3 s or more, and
/// then its pipelines are compiled. By default, devices are closed after each call. `false` closes idle devices at
/// once.
///
/// Concurrent calls have a device each. A call that fails closes its device.
/// [`HeadlessSolver`] keeps one device open for as long as it lives, and surfaces on it too. New pipelines are saved
/// after each call, if there is a folder for them ([`crate::vulkan::keep_pipelines_in`]).
///
/// ```no_run
/// use geosweep::{Engine, DeviceChoice, Options, Sources, Spacing, Surface, distance_map, vulkan};
/// vulkan::keep_devices(true);
/// let surface = Surface::from_heights(300, 300, vec![0.0; 90_000], Spacing::square(1.0))?;
/// let options = Options::default().with_engine(Engine::Vulkan(DeviceChoice::Any));
/// for row in 0..300 {
///     let map = distance_map(&surface, &Sources::point(row as f64, 0.0), &options)?;
///     println!("{}", map.report.max_distance);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn keep_devices(keep: bool) {
    let mut idle = lock();
    let closed = match keep {
        true if idle.is_some() => None,
        true => idle.replace(Vec::new()),
        false => idle.take(),
    };
    // Other calls need not wait until the devices are closed.
    drop(idle);
    closed.into_iter().flatten().for_each(|device| device.close());
}

fn lock() -> MutexGuard<'static, Option<Vec<Idle>>> {
    IDLE.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Idle {
    fn close(self) {
        if self.process == process::id() {
            drop(self.solver);
        } else {
            std::mem::forget(self.solver);
        }
    }
}

/// Calls `solve` with an idle device, or with one that is opened for it.
pub(crate) fn with_device<T>(
    choice: &DeviceChoice,
    monitor: Monitor,
    solve: impl FnOnce(&mut HeadlessSolver) -> Result<T, VulkanError>,
) -> Result<T, VulkanError> {
    let solver = match take(choice) {
        Some(solver) => solver,
        None => HeadlessSolver::new(choice)?,
    };
    let mut solver = solver.with_monitor(monitor);
    let solved = solve(&mut solver)?;
    keep(choice, solver);
    Ok(solved)
}

/// Leaves a device open for the next call if devices stay open, and closes it otherwise.
fn keep(choice: &DeviceChoice, solver: HeadlessSolver) {
    if lock().is_none() {
        return;
    }
    let mut solver = solver.with_monitor(Monitor::default());
    // A device that is idle when the process ends is not closed, so that its pipelines are saved now. Other calls need
    // not wait for the file.
    solver.save_pipelines();
    if let Some(idle) = &mut *lock() {
        idle.push(Idle { choice: choice.clone(), process: process::id(), solver });
    }
}

fn take(choice: &DeviceChoice) -> Option<HeadlessSolver> {
    let mut idle = lock();
    let idle = idle.as_mut()?;
    let found = idle
        .iter()
        .position(|device| device.choice == *choice && device.process == process::id())?;
    Some(idle.swap_remove(found).solver)
}

#[cfg(test)]
mod tests {
    use ash::vk;

    use super::*;
    use crate::{Engine, Options, Sources, Spacing, Surface, distance_map};

    /// Returns the idle devices of a choice, if devices stay open.
    fn idle(choice: &DeviceChoice) -> Option<Vec<vk::Device>> {
        let idle = lock();
        let of_choice = |device: &&Idle| device.choice == *choice;
        let handle = |device: &Idle| device.solver.context.device.handle();
        idle.as_ref().map(|idle| idle.iter().filter(of_choice).map(handle).collect())
    }

    #[test]
    fn devices_stay_open_for_the_next_call_of_the_same_choice() {
        let name = std::env::var("GEOSWEEP_TEST_DEVICE").unwrap_or_else(|_| "llvmpipe".into());
        // No other test of this process writes the name in this way.
        let choice = DeviceChoice::Name(name.to_uppercase());
        let heights = (0..12 * 15).map(|k| f64::from(k % 7)).collect();
        let surface = Surface::from_heights(12, 15, heights, Spacing::square(1.0)).unwrap();
        let map = |choice: &DeviceChoice| {
            let options = Options::default().with_engine(Engine::Vulkan(choice.clone()));
            distance_map(&surface, &Sources::point(3.0, 4.0), &options)
        };
        let closed = map(&choice).unwrap();
        assert!(idle(&choice).is_none());

        keep_devices(true);
        let first = map(&choice).unwrap();
        let opened = idle(&choice).unwrap();
        assert_eq!(opened.len(), 1);
        let second = map(&choice).unwrap();
        assert_eq!(idle(&choice).unwrap(), opened, "it is the same device");
        assert!(closed.distances == first.distances && first.distances == second.distances);
        keep_devices(true);
        assert_eq!(idle(&choice).unwrap(), opened, "nothing is closed");
        let absent = DeviceChoice::Name("no such device".into());
        assert!(map(&absent).is_err());
        assert_eq!(idle(&absent).unwrap(), []);

        keep_devices(false);
        assert!(map(&choice).unwrap().distances == closed.distances);
        assert!(idle(&choice).is_none());
    }
}
