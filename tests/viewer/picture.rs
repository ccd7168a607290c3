//! Pictures that the viewer writes after a number of frames, which are the same in every run.

use std::process::Stdio;

use crate::screen::{Grab, Screen};
use crate::{check, command};

/// Returns the file that the viewer writes.
pub fn file(screen: &Screen, arguments: &str) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("picture.png");
    let mut command = command(screen, arguments);
    check(&command.arg("--picture").arg(&path).stdin(Stdio::null()).output().unwrap());
    std::fs::read(path).unwrap()
}

/// Returns the picture that the viewer writes.
pub fn taken(screen: &Screen, arguments: &str) -> Grab {
    let file = file(screen, arguments);
    let mut reader = png::Decoder::new(std::io::Cursor::new(file)).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    let pixels = bytes.as_chunks().0.to_vec();
    Grab { width: info.width as usize, height: info.height as usize, pixels }
}
