//! Implements the functions that contours, paths, regions, directions and log maps have in common. Their callers promise
//! what callers of the functions of the header promise.

use std::sync::Arc;

use ash::vk;

use super::arguments::{Output, optional, reference, write};
use super::memory::Memory;
use super::objects::{Object, check_landed, exclusive, hand_out, object, take};
use super::shared::{Made, Shared};
use super::solver::GeosweepSolver;
use super::status::Failure;
use super::surface::{GeosweepImage, GeosweepSurface};
use super::surface_info::GeosweepHostImage;
use geosweep::vulkan::VulkanError;
use geosweep::vulkan::embed::{self, BufferKind, FrameSurface, HostImage, ImageKind, Solver};

/// Object with an output of a frame.
pub(super) trait OutputObject: Object<Held = Made<embed::Output<Self::Kind>>> {
    type Kind;
}

impl<K, T: Object<Held = Made<embed::Output<K>>>> OutputObject for T {
    type Kind = K;
}

/// Computes the bytes of device memory of an output, by a method of its solver.
pub(super) unsafe fn bytes_for(
    solver: *const GeosweepSolver,
    bytes: *mut u64,
    bytes_for: impl FnOnce(&Solver, &ash::Device) -> Result<u64, Failure>,
) -> Result<(), Failure> {
    // SAFETY: required.
    unsafe {
        let output = Output::new(bytes, "bytes");
        let Shared { solver, device, .. } = &**object(solver)?;
        output?.write(bytes_for(solver, device)?);
    }
    Ok(())
}

/// Creates an output, by a method of its solver.
pub(super) unsafe fn create<T: OutputObject>(
    surface: *const GeosweepSurface,
    to: *mut *mut T,
    create: impl FnOnce(
        &Solver,
        &ash::Device,
        &mut Memory,
        &FrameSurface,
    ) -> Result<embed::Output<T::Kind>, VulkanError>,
) -> Result<(), Failure> {
    // SAFETY: required.
    let (surface, output) = unsafe { (object(surface)?, Output::new(to, T::ARGUMENT)?) };
    let GeosweepSurface { shared, surface, .. } = surface;
    let of = create(&shared.solver, &shared.device, &mut shared.allocator(), surface)?;
    hand_out(output, Made { shared: Arc::clone(shared), of });
    Ok(())
}

/// Returns the image of the program, or `None` for null.
pub(super) unsafe fn hosts(image: *const GeosweepHostImage) -> Result<Option<HostImage>, Failure> {
    // SAFETY: required.
    Ok(unsafe { optional(image, "image") }?.map(|image| (*image).into()))
}

/// Replaces the buffer of the program.
pub(super) unsafe fn set_buffer<T: OutputObject<Kind: BufferKind>>(
    of: *mut T,
    surface: *const GeosweepSurface,
    buffer: vk::Buffer,
) -> Result<(), Failure> {
    // SAFETY: required.
    let (output, surface) = unsafe { (exclusive(of)?, object(surface)?) };
    let Shared { device, solver, .. } = &*surface.shared;
    Ok(output.of.set_buffer(device, solver, &surface.surface, buffer)?)
}

/// Replaces the image of the program.
pub(super) unsafe fn set_image<T: OutputObject<Kind: ImageKind>>(
    of: *mut T,
    image: *const GeosweepHostImage,
) -> Result<(), Failure> {
    // SAFETY: required.
    let (output, image) = unsafe { (exclusive(of)?, reference(image, "image")?) };
    Ok(output.of.set_image((*image).into())?)
}

/// Returns the image of an output.
pub(super) unsafe fn image<T: OutputObject<Kind: ImageKind>>(
    of: *const T,
    layout: vk::ImageLayout,
    image: *mut GeosweepImage,
) -> Result<(), Failure> {
    // SAFETY: required.
    unsafe { write(image, "image", object(of)?.of.image(layout).into()) }
}

/// Returns the bytes of device memory of an output.
pub(super) unsafe fn bytes<T: OutputObject>(of: *const T, bytes: *mut u64) -> Result<(), Failure> {
    // SAFETY: required.
    unsafe { write(bytes, "bytes", object(of)?.of.bytes()) }
}

/// Makes an output read the surface's current inputs, after some of these have been replaced.
pub(super) unsafe fn rebind<T: OutputObject>(
    of: *mut T,
    surface: *const GeosweepSurface,
) -> Result<(), Failure> {
    // SAFETY: required.
    let (output, surface) = unsafe { (exclusive(of)?, object(surface)?) };
    let Shared { device, solver, .. } = &*surface.shared;
    Ok(output.of.rebind(device, solver, &surface.surface)?)
}

/// Destroys an output. Null is allowed.
pub(super) unsafe fn destroy<T: OutputObject>(of: *mut T) -> Result<(), Failure> {
    let check = |output: &T::Held| check_landed::<T>(output, output.of.is_in_flight());
    // SAFETY: required.
    if let Some(mut output) = unsafe { take(of, check) }? {
        let shared = &output.shared;
        output.of.destroy(&shared.device, &mut shared.allocator());
    }
    Ok(())
}
