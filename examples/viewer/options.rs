//! Command line of the viewer.

use std::path::PathBuf;

use clap::Parser;
use geosweep::io::OutputFile;

use crate::decal::Placement;
use crate::shown::NO_SEAMS;
use crate::surfaces::{Model, Name};

/// Distance maps on the GPU, drawn in 3D.
#[derive(Clone, Debug, Parser)]
pub struct Options {
    #[arg(long, default_value = "terrain", help = Name::help())]
    pub surface: Name,
    /// First source, on the first surface
    #[arg(long, value_name = "ROW,COL", value_parser = place)]
    pub source: Option<[f32; 2]>,
    /// First direction of the camera: its angles around the vertical and above the horizon, in degrees
    #[arg(long, value_name = "TURN,PITCH", value_parser = angles, allow_hyphen_values = true)]
    pub camera: Option<[f32; 2]>,
    /// Size of the window
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = size, default_value = "1200x700")]
    pub size: [u32; 2],
    /// Show agents that walk to the source
    #[arg(long)]
    pub agents: bool,
    /// Let agents step to one of eight neighbours, rather than along the image of directions
    #[arg(long, requires = "agents")]
    pub neighbours: bool,
    /// Show a decal around the source, placed in this way
    #[arg(
        long,
        value_enum,
        value_name = "PLACEMENT",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "log-map"
    )]
    pub decal: Option<Placement>,
    /// A part of the device's name
    #[arg(long, value_name = "NAME")]
    pub device: Option<String>,
    /// End after this many frames. A deforming surface then moves by the same time every frame
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub frames: Option<u64>,
    /// Write the last frame
    #[arg(long, value_name = "FILE.png", requires = "frames", value_parser = png_output)]
    pub picture: Option<OutputFile>,
    /// Turn on the validation layers. Any message of theirs makes the exit status 1
    #[arg(long)]
    pub validate: bool,
}

impl Options {
    /// Returns the content of the first stage.
    pub fn model(&self) -> crate::Result<Model> {
        for (given, what) in [(self.agents, "agents"), (self.decal.is_some(), "decals")] {
            if given && self.surface.is_closed() {
                let rest = "leave them out, or show the terrain or the sheet";
                return Err(format!("{what} {NO_SEAMS}: {rest}").into());
            }
        }
        let mut model = self.surface.load()?;
        if let Some(source) = self.source {
            model.look.check_source(source)?;
            model.look.source = source;
        }
        if let Some([turn, pitch]) = self.camera {
            model.look.camera.look_from(turn.to_radians(), pitch.to_radians());
        }
        Ok(model)
    }
}

fn pair<T: std::str::FromStr>(text: &str, separator: char) -> Option<[T; 2]> {
    let (first, second) = text.split_once(separator)?;
    Some([first.trim().parse().ok()?, second.trim().parse().ok()?])
}

fn place(text: &str) -> Result<[f32; 2], String> {
    pair(text, ',').ok_or("give a row and a column, such as 297,219".into())
}

fn angles(text: &str) -> Result<[f32; 2], String> {
    pair(text, ',').ok_or("give two angles in degrees, such as 35,-20".into())
}

fn size(text: &str) -> Result<[u32; 2], String> {
    pair(text, 'x')
        .filter(|size| size.iter().all(|side| (1..=16384).contains(side)))
        .ok_or("give a width and a height, such as 1200x700".into())
}

fn png_output(text: &str) -> Result<OutputFile, String> {
    let path = PathBuf::from(text);
    if path.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("png")) {
        return Err("a picture is written as .png; choose such a name".into());
    }
    OutputFile::new(&path).map_err(|error| error.to_string())
}
