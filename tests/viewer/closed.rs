//! Closed surfaces: no seam shows, what is behind is hidden, and what does not pass seams is refused.

use crate::picture::taken;
use crate::screen::{ESCAPE, Grab, LEFT, RIGHT, Screen, is_colored};
use crate::{Viewer, is_at, part_beside};

/// Returns the fraction of pixels of the surface that differ clearly between two pictures.
fn differing(a: &Grab, b: &Grab) -> f64 {
    let of_surface = |pixel: &[u8; 3]| is_colored(*pixel);
    let pairs = a.pixels.iter().zip(&b.pixels).filter(|(a, b)| of_surface(a) || of_surface(b));
    let differ = |(a, b): &(&[u8; 3], &[u8; 3])| (0..3).any(|k| a[k].abs_diff(b[k]) > 12);
    pairs.clone().filter(differ).count() as f64 / pairs.count() as f64
}

/// The unit sphere in four samplings, whose seams lie at different places. The source is on a seam of all but the
/// cube, whose faces meet elsewhere.
#[test]
fn a_sphere_looks_the_same_wherever_its_seams_are() {
    let screen = Screen::new();
    let samplings = [
        ("globe:65x129", "32,0"),
        ("octahedral-sphere:129x129", "64,128"),
        ("equal-area-sphere:129x129", "64,128"),
        ("cube-sphere:99x149", "24,24"),
    ];
    for camera in ["-60,30", "60,-35"] {
        let pictures = samplings.map(|(surface, source)| {
            let what = format!("--surface builtin:{surface} --source {source}");
            taken(&screen, &format!("{what} --camera {camera} --size 320x200 --frames 4"))
        });
        let [globe, others @ ..] = &pictures;
        // The source is in the west. From the east it is behind the sphere.
        assert_eq!(globe.source().is_some(), camera == "-60,30");
        for (other, (name, _)) in others.iter().zip(&samplings[1..]) {
            let differing = differing(globe, other);
            println!("{name} from {camera}: {differing:.4}");
            assert!(differing < 0.02, "{name} from {camera}: {differing:.4}");
            assert_eq!(globe.source().is_some(), other.source().is_some(), "{name}");
        }
    }
}

/// Returns the median step from pixels of the surface to their neighbours, across a line between two columns or, if
/// `turned`, two rows. Lines of equal distance cover less than half of the pixels.
fn step(grab: &Grab, line: usize, turned: bool) -> u32 {
    let length = if turned { grab.width } else { grab.height };
    let at = |across: usize, along: usize| {
        let [x, y] = if turned { [along, across] } else { [across, along] };
        grab.pixels[y * grab.width + x]
    };
    let pairs = (0..length).map(|along| [line - 1, line].map(|across| at(across, along)));
    let mut steps: Vec<_> = pairs
        .filter(|pair| pair.iter().all(|&pixel| is_colored(pixel)))
        .map(|[a, b]| (0..3).map(|k| u32::from(a[k].abs_diff(b[k]))).sum())
        .collect();
    assert!(steps.len() > 15, "{} pixels of the surface beside line {line}", steps.len());
    steps.sort_unstable();
    steps[steps.len() / 2]
}

/// From the west, the seam of columns is in the middle of the picture, and so is the seam of the torus' rows. The
/// source lies to one side of both seams. Coarse grids would show creases where normals do not agree.
#[test]
fn no_step_shows_where_a_seam_is() {
    let screen = Screen::new();
    for (surface, source, pitch, turned) in [
        ("closed-cylinder:21x33", "7,2", 0, false),
        ("closed-cone:21x33", "10,2", 0, false),
        ("closed-torus:21x33", "16,2", 20, false),
        ("closed-torus:21x33", "16,2", 0, true),
        ("moebius-strip:31x161", "12,8", 60, false),
        ("globe:21x41", "7,3", 10, false),
    ] {
        let what = format!("--surface builtin:{surface} --source {source} --camera -90,{pitch}");
        let grab = taken(&screen, &format!("{what} --size 321x201 --frames 4"));
        // The seam is in the middle of a pixel, so that both sides of that pixel count.
        let middle = if turned { 100 } else { 160 };
        let at_seam = [0, 1].map(|by| step(&grab, middle + by, turned));
        let beside = [-20, -15, -10, -5, 6, 11, 16, 21];
        let others = beside.map(|by: i32| step(&grab, (middle as i32 + by) as usize, turned));
        println!("{surface}: {at_seam:?}, beside it {others:?}");
        let most = others.into_iter().fold(0, u32::max);
        assert!(at_seam.into_iter().all(|step| step <= most + 1), "{surface}");
    }
}

#[test]
fn a_globe_is_picked_on_its_seam_and_turned_below() {
    let screen = Screen::new();
    let globe = "--surface builtin:globe:61x121 --camera -90,0 --size 321x201";
    let viewer = Viewer::start(&screen, globe);
    let before = viewer.still(&screen);
    for place in [[160, 100], [158, 70], [162, 130], [160, 40]] {
        screen.point(place);
        screen.click(LEFT);
        screen.wait("the source has moved", || {
            is_at(&screen.grab(viewer.window), place).then_some(())
        });
    }
    let picked = viewer.still(&screen);
    assert!(picked.changed(&before) > 0.1);

    // The camera goes below the globe, which hides the source in the north.
    screen.point([160, 200]);
    screen.press(RIGHT);
    screen.point([160, 0]);
    screen.release(RIGHT);
    screen.wait("it turns", || screen.grab(viewer.window).source().is_none().then_some(()));
    let below = viewer.still(&screen);
    let [seen, from_below] = [&picked, &below].map(|grab| grab.part(is_colored));
    assert!((seen - from_below).abs() < 0.1 * seen, "a ball is as large from below: {from_below}");
    screen.key(ESCAPE);
    viewer.end(&screen);
}

/// Lines of equal distance pass the seams also if they are drawn as curves, and all schedules lead to one map. What
/// does not pass seams is refused in the title.
#[test]
fn keys_work_on_closed_surfaces_or_say_why_not() {
    let screen = Screen::new();
    let octahedral = "--surface builtin:equal-area-sphere:65x65 --size 320x200";
    let viewer = Viewer::start(&screen, octahedral);
    screen.point([160, 100]);
    let press = |key: u8, title: &str, wanted: bool| {
        screen.key(u32::from(key));
        let titled = || screen.title(viewer.window).contains(title) == wanted;
        screen.wait(title, || titled().then_some(()));
        viewer.still(&screen)
    };
    let first = press(b'a', "agents do not pass seams yet", true);
    for (key, title) in [(b'd', ", decals do not pass seams yet"), (b'p', ", paths do not pass")] {
        assert!(press(key, title, true) == first, "{title}");
    }
    let drawn = press(b'l', "contours as lines", true);
    let is_ink = |[r, g, b]: [u8; 3]| r.max(g).max(b) < 70;
    let beside = [part_beside(&drawn, &first, is_ink), part_beside(&first, &drawn, is_ink)];
    println!("ink beside ink: {beside:.3?}");
    assert!(drawn != first && beside.iter().all(|&part| part > 0.75), "{beside:?}");
    assert!(press(b'l', "contours as lines", false) == first);
    screen.key(u32::from(b'c'));
    screen.wait("tiles", || screen.title(viewer.window).contains("tiles").then_some(()));
    screen.wait("the same map", || {
        (differing(&screen.grab(viewer.window), &first) < 0.002).then_some(())
    });
    // The refusal of paths is over, and agents and decals are on the terrain again.
    let cube = press(b's', "cube-sphere, 201 x 302 points", true);
    let title = screen.title(viewer.window);
    assert!(title.contains("decals do not pass") && !title.contains("paths do not"), "{title}");
    assert!(cube.part(is_colored) > 0.1);
    screen.key(u32::from(b's'));
    let both = ", agents along directions, decal by the log map";
    screen.wait("terrain", || {
        let title = screen.title(viewer.window);
        (title.contains("terrain, 344 x 403 points") && title.contains(both)).then_some(())
    });
    screen.key(ESCAPE);
    viewer.end(&screen);
}
