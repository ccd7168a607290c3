//! Agents that walk to the source.

use crate::Viewer;
use crate::picture::taken;
use crate::screen::{ESCAPE, Grab, Screen};

/// Returns whether a color is that of agents, which neither the palette nor the ground have.
fn is_agent([r, g, b]: [u8; 3]) -> bool {
    r > 180 && g < 110 && b < 70
}

/// Returns the number of pixels of agents, and their mean distance from a place.
fn agents(grab: &Grab, [x, y]: [i16; 2]) -> (usize, f64) {
    let (mut count, mut sum) = (0, 0.0);
    for (at, _) in grab.pixels.iter().enumerate().filter(|(_, pixel)| is_agent(**pixel)) {
        let (col, row) = ((at % grab.width) as f64, (at / grab.width) as f64);
        count += 1;
        sum += (col - f64::from(x)).hypot(row - f64::from(y));
    }
    (count, sum / count.max(1) as f64)
}

#[test]
fn agents_come_nearer_by_directions_than_by_neighbours() {
    let screen = Screen::new();
    let picture = |frames: u32, steps: &str| {
        taken(&screen, &format!("--size 240x150 --frames {frames} --agents {steps}"))
    };
    let first = picture(2, "");
    let source = first.source().unwrap();
    let [first, later, beside] =
        [first, picture(30, ""), picture(30, "--neighbours")].map(|grab| agents(&grab, source));
    println!("pixels and mean distances: {first:.1?}, {later:.1?}; by neighbours {beside:.1?}");
    // Agents start in the farther places.
    assert!([first, later, beside].iter().all(|seen| seen.0 > 2000));
    let [near, nearer] = [beside, later].map(|seen| first.1 - seen.1);
    // The pace is the same, and ways that step to one of eight neighbours are longer by some hundredths.
    assert!(nearer > 4.0 && near > 4.0 && near < 0.97 * nearer, "{near:.2} and {nearer:.2} pixels");
}

#[test]
fn keys_show_agents_and_change_their_steps() {
    let screen = Screen::new();
    let viewer = Viewer::start(&screen, "--size 240x150");
    let before = viewer.still(&screen);
    let source = before.source().unwrap();
    assert_eq!(agents(&before, source).0, 0);
    let press = |key: u8, title: &str, wanted: bool| {
        screen.key(u32::from(key));
        let titled = || screen.title(viewer.window).contains(title) == wanted;
        screen.wait(title, || titled().then_some(()));
    };
    let seen = |place: [i16; 2]| agents(&screen.grab(viewer.window), place);
    press(b'a', "agents along directions", true);
    let (_, far) = screen.wait("agents", || Some(seen(source)).filter(|seen| seen.0 > 1000));
    screen.wait("they come", || (seen(source).1 < far - 4.0).then_some(()));
    press(b'n', "agents to neighbours", true);
    press(b'a', "agents", false);
    assert!(viewer.still(&screen) == before);

    // Agents walk over a surface in motion.
    press(b's', "sheet", true);
    press(b'a', "agents to neighbours", true);
    press(b'n', "agents along directions", true);
    screen.wait("agents on the sheet", || (seen(source).0 > 1000).then_some(()));
    screen.key(ESCAPE);
    viewer.end(&screen);
}
