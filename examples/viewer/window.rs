//! The window and its events.

use geosweep::glam::Vec2;
use winit::application::ApplicationHandler;
use winit::dpi::{PhysicalPosition, PhysicalSize};
use winit::event::{ElementState, KeyEvent, MouseButton, MouseScrollDelta, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop};
use winit::keyboard::{Key, NamedKey};
use winit::window::{Window, WindowId};

use crate::Result;
use crate::options::Options;
use crate::shown::Shown;
use crate::viewer::Viewer;

struct App {
    options: Options,
    /// Window, which outlives the renderer.
    window: Option<Window>,
    viewer: Option<Viewer>,
    pointer: Vec2,
    /// Whether the left and the right button are down.
    moves_source: bool,
    orbits: bool,
    title: String,
    result: Result<()>,
}

/// Shows the window until it is closed.
pub fn run(options: Options) -> Result<()> {
    let events = EventLoop::new().map_err(|error| format!("no window can be shown: {error}"))?;
    let mut app = App {
        options,
        window: None,
        viewer: None,
        pointer: Vec2::ZERO,
        moves_source: false,
        orbits: false,
        title: String::new(),
        result: Ok(()),
    };
    events.run_app(&mut app)?;
    app.result
}

impl App {
    fn open(&mut self, events: &ActiveEventLoop) -> Result<()> {
        let [width, height] = self.options.size;
        let attributes = Window::default_attributes()
            .with_title("geosweep")
            .with_inner_size(PhysicalSize::new(width, height));
        let window = self.window.insert(events.create_window(attributes)?);
        self.viewer = Some(Viewer::new(window, self.options.clone())?);
        Ok(())
    }

    fn draw(&mut self, events: &ActiveEventLoop) -> Result<()> {
        let (Some(window), Some(viewer)) = (&self.window, &mut self.viewer) else { return Ok(()) };
        viewer.frame(window.inner_size().into())?;
        let title = viewer.title();
        if title != self.title {
            window.set_title(&title);
            self.title = title;
        }
        if viewer.is_done() {
            events.exit();
        }
        Ok(())
    }

    fn key(&mut self, events: &ActiveEventLoop, key: &Key) -> Result<()> {
        let Some(viewer) = &mut self.viewer else { return Ok(()) };
        match key {
            Key::Named(NamedKey::Escape) => events.exit(),
            Key::Character(letter) => match letter.to_lowercase().as_str() {
                "s" => viewer.next_surface()?,
                "c" => viewer.next_schedule()?,
                "w" => viewer.next_wavefront()?,
                "l" => viewer.change(Shown::switch_contours)?,
                "a" => viewer.change(Shown::switch_agents)?,
                "n" => viewer.change(Shown::switch_steps)?,
                "d" => viewer.change(Shown::next_decal)?,
                // Most keyboards have + and = on the same key.
                "+" | "=" => viewer.change(Shown::enlarge_decal)?,
                "-" => viewer.change(Shown::shrink_decal)?,
                "p" => viewer.trace(self.pointer)?,
                _ => {}
            },
            _ => {}
        }
        Ok(())
    }

    fn moved(&mut self, to: PhysicalPosition<f64>) {
        let to = Vec2::new(to.x as f32, to.y as f32);
        let by = to - std::mem::replace(&mut self.pointer, to);
        if let Some(viewer) = &mut self.viewer {
            if self.moves_source {
                viewer.pick(to);
            }
            if self.orbits {
                viewer.orbit(by);
            }
        }
    }

    fn event(&mut self, events: &ActiveEventLoop, event: &WindowEvent) -> Result<()> {
        match event {
            WindowEvent::CloseRequested => events.exit(),
            WindowEvent::RedrawRequested => self.draw(events)?,
            WindowEvent::KeyboardInput {
                event: KeyEvent { logical_key, state: ElementState::Pressed, repeat: false, .. },
                ..
            } => self.key(events, logical_key)?,
            WindowEvent::CursorMoved { position, .. } => self.moved(*position),
            WindowEvent::MouseInput { state, button, .. } => {
                let down = *state == ElementState::Pressed;
                match button {
                    MouseButton::Left => {
                        self.moves_source = down;
                        if let (true, Some(viewer)) = (down, &mut self.viewer) {
                            viewer.pick(self.pointer);
                        }
                    }
                    MouseButton::Right => self.orbits = down,
                    _ => {}
                }
            }
            WindowEvent::MouseWheel { delta, .. } => {
                let notches = match delta {
                    MouseScrollDelta::LineDelta(_, notches) => *notches,
                    MouseScrollDelta::PixelDelta(by) => by.y as f32 / 40.0,
                };
                if let Some(viewer) = &mut self.viewer {
                    viewer.zoom(notches);
                }
            }
            WindowEvent::Resized(_) => {
                if let Some(viewer) = &mut self.viewer {
                    viewer.resized();
                }
            }
            WindowEvent::Occluded(false) => {
                if let Some(viewer) = &mut self.viewer {
                    viewer.exposed();
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// Ends the program at the first error.
    fn check(&mut self, events: &ActiveEventLoop, result: Result<()>) {
        if let Err(error) = result {
            if self.result.is_ok() {
                self.result = Err(error);
            }
            events.exit();
        }
    }
}

impl ApplicationHandler for App {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.window.is_none() {
            let opened = self.open(events);
            self.check(events, opened);
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        if !events.exiting() {
            let done = self.event(events, &event);
            self.check(events, done);
        }
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        let (Some(window), Some(viewer)) = (&self.window, &self.viewer) else { return };
        // A minimised window has no size. Its next event wakes the program.
        let size = window.inner_size();
        if viewer.wants_frame() && size.width > 0 && size.height > 0 {
            window.request_redraw();
            events.set_control_flow(ControlFlow::Poll);
        } else {
            events.set_control_flow(ControlFlow::Wait);
        }
    }

    fn exiting(&mut self, events: &ActiveEventLoop) {
        if let Some(viewer) = self.viewer.take() {
            let ended = viewer.end();
            self.check(events, ended);
        }
        self.window = None;
    }
}
