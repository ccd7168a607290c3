//! Implements the functions of objects with an image: directions and log maps.

use std::sync::Arc;

use ash::vk;

use super::arguments::{Output, chart, reference};
use super::objects::{Object, exclusive, hand_out, land, object, take};
use super::shared::Shared;
use super::solver::GeosweepSolver;
use super::status::{GeosweepStatus, guard};
use super::surface::{GeosweepImage, GeosweepSurface};
use super::surface_info::GeosweepHostImage;
use crate::surface::Chart;
use crate::vulkan::VulkanError;
use crate::vulkan::embed::{FrameSurface, HostImage, Solver, WayImage};

/// An object with an image of directions or of a log map.
pub(super) trait Ways: Object + Sized {
    /// The name of the argument in errors.
    const ARGUMENT: &'static str;

    /// Creates an object, in an image of the host if there is one.
    fn create(
        shared: &Arc<Shared>,
        surface: &FrameSurface,
        image: Option<HostImage>,
    ) -> Result<Self, VulkanError>;

    fn image(&self) -> &WayImage;

    /// Returns the image, to be changed, and the state of its solver.
    fn image_mut(&mut self) -> (&mut WayImage, &Shared);
}

/// Implements [`Ways`] for a kind of object with the image in its field `$field`. The solver's method of this name
/// creates the image, and its method `$into` uses an image of the program.
macro_rules! ways {
    ($kind:ident, $field:ident, $into:ident) => {
        impl way_image::Ways for $kind {
            const ARGUMENT: &'static str = stringify!($field);

            fn create(
                shared: &Arc<Shared>,
                surface: &embed::FrameSurface,
                image: Option<embed::HostImage>,
            ) -> Result<Self, crate::vulkan::VulkanError> {
                let Shared { solver, device, .. } = &**shared;
                let mut allocator = shared.allocator();
                let $field = match image {
                    None => solver.$field(device, &mut allocator, surface)?,
                    Some(image) => solver.$into(device, &mut allocator, surface, image)?,
                };
                Ok(Self { shared: Arc::clone(shared), $field })
            }

            fn image(&self) -> &embed::WayImage {
                self.$field.way_image()
            }

            fn image_mut(&mut self) -> (&mut embed::WayImage, &Shared) {
                (self.$field.way_image_mut(), &self.shared)
            }
        }
    };
}
pub(super) use ways;

/// Computes the bytes of device memory of an object, by a method of its solver.
///
/// # Safety
/// As for the functions of the header.
pub(super) unsafe fn bytes_for(
    solver: *const GeosweepSolver,
    [rows, cols]: [u32; 2],
    bytes: *mut u64,
    bytes_for: fn(&Solver, &ash::Device, Chart) -> Result<u64, VulkanError>,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let (solver, output) = unsafe { (object(solver, "solver")?, Output::new(bytes, "bytes")?) };
        let Shared { solver, device, .. } = &**solver.shared();
        output.write(bytes_for(solver, device, chart(rows, cols)?)?);
        Ok(())
    })
}

/// Creates an object. It uses the image of the program unless `image` is null.
///
/// # Safety
/// As for the functions of the header.
pub(super) unsafe fn create<T: Ways>(
    surface: *const GeosweepSurface,
    image: *const GeosweepHostImage,
    of: *mut *mut T,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let (surface, output, image) = unsafe {
            let image = if image.is_null() { None } else { Some(reference(image, "image")?) };
            (object(surface, "surface")?, Output::new(of, T::ARGUMENT)?, image)
        };
        let GeosweepSurface { shared, surface, .. } = surface;
        hand_out(output, T::create(shared, surface, image.map(|image| (*image).into()))?);
        Ok(())
    })
}

/// Replaces the image of the program.
///
/// # Safety
/// As for the functions of the header.
pub(super) unsafe fn set_image<T: Ways>(
    of: *mut T,
    image: *const GeosweepHostImage,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let (of, image) = unsafe { (exclusive(of, T::ARGUMENT)?, reference(image, "image")?) };
        Ok(of.image_mut().0.set_image((*image).into())?)
    })
}

/// Returns the bytes of device memory of an object.
///
/// # Safety
/// As for the functions of the header.
pub(super) unsafe fn bytes<T: Ways>(of: *const T, bytes: *mut u64) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let (of, output) = unsafe { (object(of, T::ARGUMENT)?, Output::new(bytes, "bytes")?) };
        output.write(of.image().bytes());
        Ok(())
    })
}

/// Returns the image of an object.
///
/// # Safety
/// As for the functions of the header.
pub(super) unsafe fn image<T: Ways>(
    of: *const T,
    layout: vk::ImageLayout,
    image: *mut GeosweepImage,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let (of, output) = unsafe { (object(of, T::ARGUMENT)?, Output::new(image, "image")?) };
        output.write(of.image().image(layout).into());
        Ok(())
    })
}

/// Writes the surface's current sources into the object's descriptor sets, after some sources have been replaced.
///
/// # Safety
/// As for the functions of the header.
pub(super) unsafe fn rebind<T: Ways>(
    of: *mut T,
    surface: *const GeosweepSurface,
) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let (of, surface) = unsafe { (exclusive(of, T::ARGUMENT)?, object(surface, "surface")?) };
        let Shared { device, solver, .. } = &*surface.shared;
        Ok(of.image_mut().0.rebind(device, solver, &surface.surface)?)
    })
}

/// Destroys an object. Null is allowed.
///
/// # Safety
/// As for the functions of the header.
pub(super) unsafe fn destroy<T: Ways>(of: *mut T) -> GeosweepStatus {
    guard(|| {
        // SAFETY: the caller's promise.
        let Some(_) = (unsafe { land(of, T::ARGUMENT, |of| of.image().is_in_flight()) })? else {
            return Ok(());
        };
        // SAFETY: the caller's promise.
        let Some(mut of) = unsafe { take(of, T::ARGUMENT) }? else { return Ok(()) };
        let (image, shared) = of.image_mut();
        image.destroy(&shared.device, &mut shared.allocator());
        Ok(())
    })
}
