//! Copies data from the device to the program.

use std::error::Error;

/// Returns a texture's rows, four bytes per texel. Waits for the device.
///
/// # Errors
/// If the device is lost.
pub fn texels(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
) -> Result<Vec<u8>, Box<dyn Error>> {
    let row = 4 * texture.width();
    let pitch = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let mut encoder = device.create_command_encoder(&Default::default());
    let copy = download(device, u64::from(pitch) * u64::from(texture.height()));
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &copy,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(pitch),
                rows_per_image: None,
            },
        },
        texture.size(),
    );
    let bytes = submit(device, queue, encoder, &copy)?;
    Ok(bytes.chunks(pitch as usize).flat_map(|line| &line[..row as usize]).copied().collect())
}

/// Returns a buffer's bytes. Waits for the device.
///
/// # Errors
/// If the device is lost.
#[allow(dead_code, reason = "the test reads buffers, the example does not")]
pub fn bytes(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    buffer: &wgpu::Buffer,
) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut encoder = device.create_command_encoder(&Default::default());
    let copy = download(device, buffer.size());
    encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, buffer.size());
    submit(device, queue, encoder, &copy)
}

fn download(device: &wgpu::Device, size: u64) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size,
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    })
}

fn submit(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    encoder: wgpu::CommandEncoder,
    copy: &wgpu::Buffer,
) -> Result<Vec<u8>, Box<dyn Error>> {
    queue.submit([encoder.finish()]);
    let (done, mapped) = std::sync::mpsc::channel();
    copy.map_async(wgpu::MapMode::Read, .., move |result| drop(done.send(result)));
    device.poll(wgpu::PollType::wait_indefinitely())?;
    mapped.recv()??;
    Ok(copy.get_mapped_range(..)?.to_vec())
}
