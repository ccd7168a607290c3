//! The viewer as a user meets it: a window on an X server, and input events. The validation layers are
//! active, and a message of theirs makes the viewer's exit status an error.
#![cfg(all(feature = "formats", target_os = "linux"))]

mod agents;
mod closed;
mod decal;
mod picture;
mod rest;
mod screen;

use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};

use picture::file;
use screen::{ESCAPE, Grab, LEFT, RIGHT, Screen, WHEEL_UP, is_colored};
use x11rb::protocol::xproto::Window;

/// A running viewer.
struct Viewer {
    process: Option<Child>,
    window: Window,
}

/// Returns the path of the viewer's executable. `cargo test` builds the example along with the tests, but
/// `cargo test --test viewer` does not.
fn program() -> PathBuf {
    let tests = std::env::current_exe().unwrap();
    let path = tests.parent().unwrap().parent().unwrap().join("examples/viewer");
    assert!(path.exists(), "build it: cargo build --release --all-features --example viewer");
    path
}

fn command(screen: &Screen, arguments: &str) -> Command {
    let mut command = Command::new(program());
    command.env("DISPLAY", &screen.name).env_remove("WAYLAND_DISPLAY").arg("--validate");
    if let Ok(device) = std::env::var("GEOSWEEP_TEST_DEVICE") {
        command.args(["--device", &device]);
    }
    command.args(arguments.split_whitespace());
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

impl Viewer {
    fn start(screen: &Screen, arguments: &str) -> Self {
        let process = Some(command(screen, arguments).spawn().unwrap());
        let window = screen.window();
        Self { process, window }
    }

    /// Returns the picture that the viewer shows once it is idle.
    fn still(&self, screen: &Screen) -> Grab {
        screen.still(self.window, self.process.as_ref().expect("it runs").id())
    }

    /// Waits until the viewer ends, which something else must cause.
    fn end(mut self, screen: &Screen) {
        let mut process = self.process.take().unwrap();
        screen.wait("the viewer ends", || process.try_wait().unwrap());
        check(&process.wait_with_output().unwrap());
    }
}

impl Drop for Viewer {
    fn drop(&mut self) {
        if let Some(mut process) = self.process.take() {
            let _ = process.kill();
            if let Ok(output) = process.wait_with_output() {
                eprintln!("{}", String::from_utf8_lossy(&output.stderr));
            }
        }
    }
}

fn check(output: &Output) {
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{}: {said}", output.status);
    assert_eq!(said, "");
}

/// Returns whether the source is at a place, within the size of its mark.
fn is_at(grab: &Grab, place: [i16; 2]) -> bool {
    grab.source().is_some_and(|[x, y]| (x - place[0]).abs() <= 4 && (y - place[1]).abs() <= 4)
}

#[test]
fn the_source_follows_the_pointer() {
    let screen = Screen::new();
    let viewer = Viewer::start(&screen, "--size 480x300");
    let before = viewer.still(&screen);
    // The surface is shown in its colors on a background, with dark lines.
    let colored = before.part(is_colored);
    assert!((0.2..0.8).contains(&colored), "{colored}");
    assert!([[0, 0], [479, 0], [0, 299]].iter().all(|&corner| !is_colored(before.at(corner))));

    // A click on the surface moves the source there. The device finds the place with a picture of one pixel.
    let place = [300, 190];
    assert!(!is_at(&before, place));
    screen.point(place);
    screen.click(LEFT);
    screen.wait("the source has moved", || is_at(&screen.grab(viewer.window), place).then_some(()));
    let clicked = viewer.still(&screen);
    assert!(clicked.changed(&before) > 0.2, "colors and lines move with the source");

    // A drag moves the source along.
    let place = [200, 150];
    screen.press(LEFT);
    for step in 1..=5 {
        screen.point([300 - 20 * step, 190 - 8 * step]);
    }
    screen.release(LEFT);
    screen
        .wait("the source was dragged", || is_at(&screen.grab(viewer.window), place).then_some(()));
    let dragged = viewer.still(&screen);

    // Beside the surface there is nothing to click on.
    screen.point([5, 5]);
    screen.click(LEFT);
    assert!(viewer.still(&screen) == dragged);
    // The same place gives the same picture.
    screen.point([300, 190]);
    screen.click(LEFT);
    screen.wait("the source is back", || (screen.grab(viewer.window) == clicked).then_some(()));

    screen.key(ESCAPE);
    viewer.end(&screen);
}

#[test]
fn keys_switch_surface_schedule_and_wavefront() {
    let screen = Screen::new();
    let viewer = Viewer::start(&screen, "--size 320x200");
    screen.point([160, 100]);
    let titled = |part: &str| {
        let found = || screen.title(viewer.window).contains(part).then_some(());
        screen.wait(part, found);
    };
    titled("terrain, 344 x 403 points, raster, curved fronts");
    titled(" ms on ");
    let raster = viewer.still(&screen);
    screen.key(u32::from(b'w'));
    titled("planar fronts");
    // Planar fronts are of first order, so their lines are at other places, but not far away.
    let planar = viewer.still(&screen);
    assert!((0.001..0.9).contains(&planar.changed(&raster)), "{}", planar.changed(&raster));
    screen.key(u32::from(b'w'));
    titled("circular fronts");
    screen.key(u32::from(b'w'));
    titled("curved fronts");
    screen.wait("as before", || (screen.grab(viewer.window) == raster).then_some(()));

    // All schedules lead to the same map.
    let same = |grab: &Grab| {
        let pairs = grab.pixels.iter().zip(&raster.pixels);
        pairs.flat_map(|(a, b)| a.iter().zip(b)).all(|(&a, &b)| a.abs_diff(b) <= 4)
    };
    screen.key(u32::from(b'c'));
    titled("tiles");
    assert!(same(&viewer.still(&screen)));
    screen.key(u32::from(b'c'));
    titled("raster");

    // The sheet moves without input.
    screen.key(u32::from(b's'));
    titled("sheet, 192 x 192 points");
    let first = screen.grab(viewer.window);
    screen.wait("it moves", || {
        let next = screen.grab(viewer.window);
        (next.part(is_colored) > 0.1 && next.changed(&first) > 0.1).then_some(())
    });
    // The window is closed while the sheet moves.
    screen.close(viewer.window);
    viewer.end(&screen);
}

/// Returns the fraction of a kind of pixels in a picture that have a pixel of this kind nearby in another picture.
fn part_beside(grab: &Grab, other: &Grab, is_one: impl Fn([u8; 3]) -> bool) -> f64 {
    let close = |at: usize| {
        let (x, y) = (at % grab.width, at / grab.width);
        let rows = y.saturating_sub(2)..(y + 3).min(grab.height);
        let cols = || x.saturating_sub(2)..(x + 3).min(grab.width);
        rows.into_iter().any(|y| cols().any(|x| is_one(other.at([x as i16, y as i16]))))
    };
    let ones: Vec<_> = (0..grab.pixels.len()).filter(|&at| is_one(grab.pixels[at])).collect();
    ones.iter().filter(|&&at| close(at)).count() as f64 / ones.len() as f64
}

/// Returns whether new white pixels lead from one place to another, without gaps other than those at ridges.
fn leads(grab: &Grab, before: &Grab, from: [i16; 2], to: [i16; 2]) -> bool {
    let far = |a: [i16; 2], b: [i16; 2]| (a[0] - b[0]).abs().max((a[1] - b[1]).abs());
    let white = |(at, pixel): (usize, &[u8; 3])| {
        let new = *pixel != before.pixels[at] && pixel.iter().all(|&channel| channel > 160);
        new.then(|| [(at % grab.width) as i16, (at / grab.width) as i16])
    };
    let mut left: Vec<_> = grab.pixels.iter().enumerate().filter_map(white).collect();
    let mut reached = vec![from];
    while let Some(place) = reached.pop() {
        if far(place, to) <= 8 {
            return true;
        }
        let (next, rest) = left.into_iter().partition(|&other| far(place, other) <= 10);
        left = rest;
        reached.extend::<Vec<_>>(next);
    }
    false
}

#[test]
fn keys_draw_contours_and_a_path_as_lines() {
    let screen = Screen::new();
    let viewer = Viewer::start(&screen, "--size 480x300");
    let shaded = viewer.still(&screen);
    let titled = |part: &str, wanted: bool| {
        let found = || (screen.title(viewer.window).contains(part) == wanted).then_some(());
        screen.wait(part, found);
    };
    // The same lines are drawn in another way.
    screen.key(u32::from(b'l'));
    titled("contours as lines", true);
    let drawn = viewer.still(&screen);
    let changed = drawn.changed(&shaded);
    let is_ink = |[r, g, b]: [u8; 3]| r.max(g).max(b) < 70;
    let beside = [part_beside(&drawn, &shaded, is_ink), part_beside(&shaded, &drawn, is_ink)];
    println!("{changed:.3} changed, ink beside ink: {beside:.3?}");
    assert!((0.005..0.3).contains(&changed), "{changed}");
    assert!(beside.iter().all(|&part| part > 0.75), "{beside:?}");
    screen.key(u32::from(b'l'));
    titled("contours as lines", false);
    screen.wait("as before", || (screen.grab(viewer.window) == shaded).then_some(()));

    // The path runs from below the pointer to the source.
    let start = [120, 155];
    let source = shaded.source().unwrap();
    screen.point(start);
    screen.key(u32::from(b'p'));
    let leads_to =
        |place: [i16; 2]| leads(&screen.grab(viewer.window), &shaded, start, place).then_some(());
    screen.wait("the path leads to the source", || leads_to(source));
    let traced = viewer.still(&screen);
    assert!(traced.changed(&shaded) < 0.05, "{}", traced.changed(&shaded));
    // Beside the surface, no path starts, and the last one stays.
    screen.point([5, 5]);
    screen.key(u32::from(b'p'));
    assert!(viewer.still(&screen) == traced);
    // The path ends at the source's new place.
    let place = [300, 190];
    screen.point(place);
    screen.click(LEFT);
    screen.wait("the path leads to the new place", || leads_to(place));

    screen.key(u32::from(b'l'));
    titled("contours as lines", true);
    let elsewhere = viewer.still(&screen);
    let beside = part_beside(&shaded, &elsewhere, is_ink);
    println!("from another source: {beside:.3}");
    assert!(beside < 0.65, "{beside}");

    // On a moving surface, contours are found every frame.
    screen.key(u32::from(b's'));
    titled("sheet", true);
    titled("contours as lines", true);
    let first = screen.grab(viewer.window);
    screen.wait("it moves", || {
        let next = screen.grab(viewer.window);
        (next.part(is_ink) > 0.003 && next.changed(&first) > 0.1).then_some(())
    });
    screen.key(ESCAPE);
    viewer.end(&screen);
}

#[test]
fn the_picture_follows_the_camera_and_the_window() {
    let screen = Screen::new();
    let viewer = Viewer::start(&screen, "--size 320x200 --source 100,100");
    let before = viewer.still(&screen);
    screen.point([160, 100]);
    screen.press(RIGHT);
    screen.point([220, 110]);
    screen.release(RIGHT);
    screen.wait("it turns", || (screen.grab(viewer.window).changed(&before) > 0.2).then_some(()));
    let turned = viewer.still(&screen);
    assert!(!is_at(&turned, [220, 110]), "only the left button moves the source");
    screen.click(WHEEL_UP);
    screen.click(WHEEL_UP);
    let larger = |grab: &Grab| grab.part(is_colored) > 1.2 * turned.part(is_colored);
    screen.wait("it comes closer", || larger(&screen.grab(viewer.window)).then_some(()));
    let near = viewer.still(&screen);

    // A larger window, a wider one, smaller ones, and back: the picture is the same as before.
    for size in [[640, 480], [500, 120], [97, 61], [320, 200]] {
        screen.resize(viewer.window, size);
        screen.wait("all of the window is drawn", || {
            let grab = screen.grab(viewer.window);
            let [width, height] = size;
            let whole = (grab.width, grab.height) == (width as usize, height as usize)
                && grab.at([width as i16 - 1, height as i16 - 1]) != [0; 3]
                && grab.part(is_colored) > 0.1;
            whole.then_some(())
        });
    }
    screen.wait("as before", || (screen.grab(viewer.window) == near).then_some(()));
    // Without a window manager, to minimise a window is to unmap it.
    screen.hide(viewer.window);
    screen.show(viewer.window);
    screen.wait("shown again", || (screen.grab(viewer.window) == near).then_some(()));
    screen.key(ESCAPE);
    viewer.end(&screen);
}

#[test]
fn counted_frames_of_a_moving_surface_are_the_same_every_time() {
    let screen = Screen::new();
    let six = "--surface sheet --size 240x160 --frames 6";
    let first = file(&screen, six);
    assert!(first == file(&screen, six));
    let later = "--surface sheet --size 240x160 --frames 7";
    assert!(first != file(&screen, later));
    let elsewhere = "--surface sheet --size 240x160 --frames 6 --source 100,150.5";
    assert!(first != file(&screen, elsewhere));
}

#[test]
fn errors_of_the_viewer_are_reported() {
    let screen = Screen::new();
    for (arguments, part) in [
        ("--source 344,0", "its rows are 0 to 343, its columns 0 to 402"),
        ("--source 1", "give a row and a column"),
        ("--size 0x5", "give a width and a height"),
        ("--picture a.png", "--frames"),
        ("--frames 1 --picture a.jpg", "choose such a name"),
        ("--camera 35", "give two angles"),
        ("--surface cloud", "give terrain, sheet or builtin:NAME:ROWSxCOLS"),
        ("--surface builtin:globe", "not of the form NAME:ROWSxCOLS"),
        ("--surface builtin:peaks:9x9", "no closed surface is called \"peaks\"; there are closed-"),
        ("--surface builtin:closed-torus:3x9", "3 x 9 points is too small to be glued"),
        ("--surface builtin:globe:31x61 --source 31,0", "its rows are 0 to 30"),
        ("--surface builtin:globe:31x61 --agents", "agents do not pass seams yet: leave them out"),
        ("--surface builtin:globe:31x61 --decal", "decals do not pass seams yet: leave them out"),
        ("--device nosuchdevice", "is not the device asked for"),
    ] {
        let mut command = Command::new(program());
        command.env("DISPLAY", &screen.name).args(arguments.split_whitespace());
        let output = command.output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success() && said.contains(part), "{arguments}: {said}");
    }
    let mut command = Command::new(program());
    let output = command.env("DISPLAY", ":nowhere").output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success() && said.contains("no window can be shown"), "{said}");
}
