//! A sign of life.

use std::time::Duration;

use indicatif::ProgressBar;

/// A sign of life on a terminal while it lives.
pub struct Spinner(ProgressBar);

impl Spinner {
    pub fn new(doing: &'static str) -> Self {
        let bar = ProgressBar::new_spinner().with_message(doing);
        bar.enable_steady_tick(Duration::from_millis(100));
        Self(bar)
    }
}

impl Drop for Spinner {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
