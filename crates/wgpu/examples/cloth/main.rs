//! Draws eight frames of a moving cloth with wgpu in the colours of its map, without a window:
//! `cargo run --release -p geosweep-wgpu --example cloth -- picture.png`

mod cloth;
mod readback;
mod renderer;

use std::error::Error;
use std::fs::File;
use std::io::BufWriter;

use cloth::PICTURE;
use renderer::{Renderer, open};

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).unwrap_or_else(|| "cloth.png".into());
    let (device, queue) = open(wgpu::InstanceFlags::default().with_env(), "")?;
    let renderer = Renderer::new(device, queue)?;
    for number in 0..8 {
        renderer.frame(number)?;
    }
    let pixels = readback::texels(&renderer.device, &renderer.queue, &renderer.picture)?;
    let outcome = renderer.map.outcome()?;
    let mut encoder =
        png::Encoder::new(BufWriter::new(File::create(&path)?), PICTURE[0], PICTURE[1]);
    encoder.set_color(png::ColorType::Rgba);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&pixels)?;
    writer.finish()?;
    println!("wrote {path}; the last map took {} iterations", outcome.iterations);
    Ok(())
}
