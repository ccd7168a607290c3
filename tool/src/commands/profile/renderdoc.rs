//! Captures a map with RenderDoc, through its in-application interface.

#[cfg(not(target_vendor = "apple"))]
mod interface {
    use std::ptr::null;

    use renderdoc::{RenderDoc, V100};

    /// RenderDoc, loaded into this process.
    pub struct Capture(RenderDoc<V100>);

    impl Capture {
        /// Connects to RenderDoc. This must happen before the device is opened.
        pub fn new() -> Result<Self, String> {
            RenderDoc::new().map(Self).map_err(|error| {
                format!(
                    "--renderdoc: RenderDoc is not loaded into this process ({error}); start the \
                     tool from RenderDoc, or with `renderdoccmd capture -w geosweep profile ...`"
                )
            })
        }

        /// Captures what `work` submits to the only device of this process. Also returns the name of the
        /// capture's file.
        pub fn around<T>(mut self, work: impl FnOnce() -> T) -> (T, Result<String, String>) {
            let before = self.0.get_num_captures();
            self.0.start_frame_capture(null(), null());
            let done = work();
            self.0.end_frame_capture(null(), null());
            let captures = self.0.get_num_captures();
            let last = (captures > before).then(|| self.0.get_capture(captures - 1)).flatten();
            let file = last.map(|(path, _)| path.display().to_string());
            (done, file.ok_or_else(|| "--renderdoc: RenderDoc has written no capture".into()))
        }
    }
}

#[cfg(target_vendor = "apple")]
mod interface {
    /// A stand-in for systems on which RenderDoc does not run.
    pub struct Capture;

    impl Capture {
        pub fn new() -> Result<Self, String> {
            Err("--renderdoc: RenderDoc does not run on this system".into())
        }

        pub fn around<T>(self, work: impl FnOnce() -> T) -> (T, Result<String, String>) {
            (work(), Err("--renderdoc: RenderDoc does not run on this system".into()))
        }
    }
}

pub use interface::Capture;
