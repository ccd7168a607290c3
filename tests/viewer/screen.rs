//! An X server for one test, without a screen, and its only user.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use x11rb::connection::Connection;
use x11rb::protocol::xproto::{
    AtomEnum, ClientMessageEvent, ConfigureWindowAux, ConnectionExt, EventMask, ImageFormat,
    InputFocus, Window,
};
use x11rb::protocol::xtest::ConnectionExt as _;
use x11rb::rust_connection::RustConnection;

use crate::rest;

/// Time limit. Nothing here takes a tenth of it unless it hangs.
pub const LIMIT: Duration = Duration::from_secs(300);

pub const LEFT: u8 = 1;
pub const RIGHT: u8 = 3;
pub const WHEEL_UP: u8 = 4;
pub const ESCAPE: u32 = 0xff1b;

const KEY: u8 = 2;
const BUTTON: u8 = 4;
const MOTION: u8 = 6;

/// An X server and a connection to it.
pub struct Screen {
    server: Child,
    pub name: String,
    connection: RustConnection,
    root: Window,
}

/// Contents of a window: three bytes per pixel.
#[derive(Clone, PartialEq)]
pub struct Grab {
    pub width: usize,
    pub height: usize,
    pub pixels: Vec<[u8; 3]>,
}

impl Screen {
    pub fn new() -> Self {
        // The server chooses a free number and prints it.
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1280x800x24", "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("the tests need Xvfb; ci/setup installs it");
        let mut number = String::new();
        BufReader::new(server.stdout.take().unwrap()).read_line(&mut number).unwrap();
        let name = format!(":{}", number.trim());
        let (connection, screen) = RustConnection::connect(Some(&name)).unwrap();
        let root = connection.setup().roots[screen].root;
        Self { server, name, connection, root }
    }

    /// Waits until `found` returns a value.
    pub fn wait<T>(&self, what: &str, mut found: impl FnMut() -> Option<T>) -> T {
        let start = Instant::now();
        loop {
            if let Some(found) = found() {
                return found;
            }
            assert!(start.elapsed() < LIMIT, "{what}: not after {LIMIT:?}");
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// Returns the viewer's window, once it is shown. Keys go to it, as a window manager would otherwise
    /// arrange.
    pub fn window(&self) -> Window {
        let window = self.wait("the window is shown", || {
            let tree = self.connection.query_tree(self.root).unwrap().reply().unwrap();
            tree.children.into_iter().find(|&window| self.title(window).starts_with("geosweep: "))
        });
        self.focus(window);
        window
    }

    fn focus(&self, window: Window) {
        let parent = InputFocus::PARENT;
        let focused = self.connection.set_input_focus(parent, window, x11rb::CURRENT_TIME);
        focused.unwrap().check().unwrap();
    }

    fn atom(&self, name: &str) -> u32 {
        self.connection.intern_atom(false, name.as_bytes()).unwrap().reply().unwrap().atom
    }

    pub fn title(&self, window: Window) -> String {
        let name = self.atom("_NET_WM_NAME");
        let reply = self.connection.get_property(false, window, name, AtomEnum::ANY, 0, 256);
        let reply = reply.unwrap().reply();
        reply.map(|reply| String::from_utf8_lossy(&reply.value).into_owned()).unwrap_or_default()
    }

    pub fn grab(&self, window: Window) -> Grab {
        let size = self.connection.get_geometry(window).unwrap().reply().unwrap();
        let (width, height) = (size.width, size.height);
        let format = ImageFormat::Z_PIXMAP;
        let image = self.connection.get_image(format, window, 0, 0, width, height, u32::MAX);
        let data = image.unwrap().reply().unwrap().data;
        let pixels = data.chunks_exact(4).map(|pixel| [pixel[2], pixel[1], pixel[0]]).collect();
        Grab { width: width.into(), height: height.into(), pixels }
    }

    /// Returns the contents of a program's window once the program is idle: all input has arrived, no frame
    /// is pending, and the server has drawn all frames.
    pub fn still(&self, window: Window, program: u32) -> Grab {
        let at_work = [program, self.server.id()];
        self.wait("the picture stands still", || rest::are_done(&at_work).then_some(()));
        self.grab(window)
    }

    fn input(&self, kind: u8, detail: u8, at: [i16; 2]) {
        let event = self.connection.xtest_fake_input(kind, detail, 0, self.root, at[0], at[1], 0);
        event.unwrap().check().unwrap();
    }

    /// Moves the pointer. The window is at the screen's upper left.
    pub fn point(&self, at: [i16; 2]) {
        self.input(MOTION, 0, at);
    }

    pub fn press(&self, button: u8) {
        self.input(BUTTON, button, [0; 2]);
    }

    pub fn release(&self, button: u8) {
        self.input(BUTTON + 1, button, [0; 2]);
    }

    pub fn click(&self, button: u8) {
        self.press(button);
        self.release(button);
    }

    /// Presses the key with a symbol.
    pub fn key(&self, symbol: u32) {
        let (first, last) =
            (self.connection.setup().min_keycode, self.connection.setup().max_keycode);
        let codes = self.connection.get_keyboard_mapping(first, last - first + 1).unwrap();
        let codes = codes.reply().unwrap();
        let each = usize::from(codes.keysyms_per_keycode);
        let index = codes.keysyms.chunks(each).position(|symbols| symbols[0] == symbol).unwrap();
        let code = first + index as u8;
        self.input(KEY, code, [0; 2]);
        self.input(KEY + 1, code, [0; 2]);
    }

    pub fn resize(&self, window: Window, [width, height]: [u32; 2]) {
        let size = ConfigureWindowAux::new().width(width).height(height);
        self.connection.configure_window(window, &size).unwrap().check().unwrap();
    }

    pub fn hide(&self, window: Window) {
        self.connection.unmap_window(window).unwrap().check().unwrap();
    }

    pub fn show(&self, window: Window) {
        self.connection.map_window(window).unwrap().check().unwrap();
        self.focus(window);
    }

    /// Sends the message of a window manager when the user closes the window.
    pub fn close(&self, window: Window) {
        let data = [self.atom("WM_DELETE_WINDOW"), 0, 0, 0, 0];
        let message = ClientMessageEvent::new(32, window, self.atom("WM_PROTOCOLS"), data);
        let sent = self.connection.send_event(false, window, EventMask::NO_EVENT, message);
        sent.unwrap().check().unwrap();
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

impl Grab {
    pub fn at(&self, [x, y]: [i16; 2]) -> [u8; 3] {
        self.pixels[y as usize * self.width + x as usize]
    }

    /// Returns the fraction of pixels for which `holds` is true.
    pub fn part(&self, holds: impl Fn([u8; 3]) -> bool) -> f64 {
        let count = self.pixels.iter().filter(|&&pixel| holds(pixel)).count();
        count as f64 / self.pixels.len() as f64
    }

    /// Returns the fraction of pixels that differ from another picture of the same size.
    pub fn changed(&self, other: &Self) -> f64 {
        assert_eq!((self.width, self.height), (other.width, other.height));
        let pairs = self.pixels.iter().zip(&other.pixels);
        pairs.filter(|(a, b)| a != b).count() as f64 / self.pixels.len() as f64
    }

    /// Returns the middle of the white disc that marks the source.
    pub fn source(&self) -> Option<[i16; 2]> {
        let white = |&(_, pixel): &(usize, &[u8; 3])| pixel.iter().all(|&channel| channel > 246);
        let (mut sum, mut count) = ([0, 0], 0);
        for (index, _) in self.pixels.iter().enumerate().filter(white) {
            sum = [sum[0] + index % self.width, sum[1] + index / self.width];
            count += 1;
        }
        (count > 0).then(|| sum.map(|sum| (sum / count) as i16))
    }
}

/// Returns whether a color belongs to the surface: the background, walls and shadows are close to grey.
pub fn is_colored([r, g, b]: [u8; 3]) -> bool {
    r.max(g).max(b) - r.min(g).min(b) > 40
}
