//! The embedding interface, used by the tests' own renderer.

mod changes;
mod closed;
#[cfg(feature = "formats")]
#[allow(dead_code, clippy::duplicate_mod)] // as for `render`
#[path = "../../../examples/closed.rs"]
mod closed_tube;
mod costs;
mod creation;
mod curves;
#[cfg(feature = "formats")]
#[allow(dead_code, clippy::duplicate_mod)] // as for `render`
#[path = "../../../examples/decal.rs"]
mod decal;
mod edges;
#[path = "../../../examples/embed.rs"]
mod example;
mod families;
mod faults;
mod frames;
#[cfg(feature = "formats")]
#[allow(dead_code, clippy::duplicate_mod)] // as for `render`
#[path = "../../../examples/horde.rs"]
mod horde;
mod in_flight;
mod inputs;
mod limits;
mod misuse;
mod outputs;
mod pipeline_store;
mod pipelines;
mod queues;
mod readme;
// `main` of this example is not called here, and the example includes the same tests/common/host/mod.rs as these tests.
#[cfg(feature = "formats")]
#[allow(dead_code, clippy::duplicate_mod)]
#[path = "../../../examples/render.rs"]
mod render;
mod resolution;
mod sampling;
mod scan_pairs;
mod skewed;
mod small_tiles;
mod stage;
mod surroundings;
mod together;

/// The example itself checks that every frame has converged.
#[test]
fn the_example_runs() {
    example::main().unwrap();
}

/// The picture is not empty, and the lines move with the source and with the surface. The validation layers
/// report nothing about the passes that draw or about the library's passes between them.
#[test]
#[cfg(feature = "formats")]
fn the_renderer_draws_the_requested_frame() {
    use render::PointSource;
    let mut host = render::Host::with_synchronization_validation();
    let mut draw = |phase, row, col| render::render(&mut host, 1, phase, PointSource::at(row, col));
    let background = [237u8, 235, 230];
    let first = draw(1.1, 150.0, 210.0);
    let pixels = || first.iter();
    // Devices round colours differently in the last digit.
    let is_background = |pixel: &[u8; 3]| (0..3).all(|i| pixel[i].abs_diff(background[i]) <= 1);
    let drawn = pixels().filter(|&pixel| !is_background(pixel)).count();
    assert!((0.4..0.9).contains(&(drawn as f64 / pixels().count() as f64)), "{drawn}");
    let red = |&&[r, g, b]: &&[u8; 3]| r > 190 && g < 60 && b < 70;
    assert!((20..2000).contains(&pixels().filter(red).count()), "the source is marked");
    let changed =
        |other: &[_]| pixels().zip(other).filter(|(a, b)| a != b).count() as f64 / drawn as f64;
    assert!(changed(&draw(1.1, 60.0, 100.0)) > 0.5);
    assert!(changed(&draw(1.6, 150.0, 210.0)) > 0.5);
    assert_eq!((host.messages(), host.allocations()), (Vec::new(), 0));
}

/// A source on the seam gives the same picture from either of its copies. The picture changes if the tube moves.
#[test]
#[cfg(feature = "formats")]
fn the_closed_tube_is_drawn() {
    use closed_tube::PointSource;
    let mut host = closed_tube::Host::with_synchronization_validation();
    let mut draw = |time, col| closed_tube::draw(&mut host, time, PointSource::at(95.0, col));
    let first = draw(0.8, 0.0);
    let is_red = |pixel: &&[u8; 3]| pixel[0] > 190 && pixel[1] < 60 && pixel[2] < 70;
    let marked = first.iter().filter(is_red).count();
    assert!((20..2000).contains(&marked), "the source is marked on {marked} pixels");
    assert!(first == draw(0.8, 160.0));
    assert!(first != draw(1.3, 0.0));
    assert_eq!((host.messages(), host.allocations()), (Vec::new(), 0));
}

/// Agents walk, and their trails are in the picture.
#[test]
#[cfg(feature = "formats")]
fn the_horde_walks() {
    let mut host = horde::Host::with_synchronization_validation();
    let [ways, links] = [false, true].map(|links| horde::march(&mut host, links, 4));
    for march in [&ways, &links] {
        assert_eq!(march.arrived, 0);
        // In each of the four frames an agent takes eight steps of a quarter of a cell, which makes 8 cells on level
        // ground and more over slopes.
        assert!((8.0..9.5).contains(&march.walked), "{}", march.walked);
    }
    assert!(ways.pixels != links.pixels);
    assert_eq!((host.messages(), host.allocations()), (Vec::new(), 0));
}

/// Each half of the picture contains its decal.
#[test]
#[cfg(feature = "formats")]
fn decals_are_drawn() {
    let mut host = decal::Host::with_synchronization_validation();
    let pixels = decal::draw(&mut host, 3);
    let is_ink = |pixel: &&[u8; 3]| pixel[0] > 150 && pixel[1] < 90 && pixel[2] < 90;
    for (half, pixels) in pixels.iter().enumerate() {
        let inked = pixels.iter().filter(is_ink).count();
        assert!(inked > 1000, "{half}: {inked}");
    }
    assert_eq!((host.messages(), host.allocations()), (Vec::new(), 0));
}
