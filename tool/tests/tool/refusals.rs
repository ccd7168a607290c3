//! Errors of the tool. It leaves nothing behind and overwrites nothing after an error.

use std::ffi::OsStr;
use std::fs;

use crate::workbench::{Workbench, map, notes, stderr};

#[test]
fn wrong_words_are_refused() {
    let bench = Workbench::new();
    let flat = bench.flat(5, 7);
    let positions = bench.array("positions.npy", &[5, 7, 3], &vec![0.5; 105]);
    let metric = bench.array("metric.npy", &[5, 7, 2, 2], &[1.0, 0.0, 0.0, 1.0].repeat(35));
    for (surface, words, parts) in [
        (&*flat, "-o map.npy", &["--source", "--source-curve", "--source-points"][..]),
        (&flat, "-s 1,1", &["--output"]),
        (&flat, "-s nan,1 -o map.npy", &["nan", "finite number"]),
        (&flat, "-s 1,inf -o map.npy", &["inf", "finite number"]),
        (&flat, "-s 1 -o map.npy", &["R,C[,T0]"]),
        (&flat, "-s 1,2,3,4 -o map.npy", &["R,C[,T0]"]),
        (&flat, "-s -1,2 -o map.npy", &["-1,2", "outside the grid", "0 to 4", "0 to 6"]),
        (&flat, "-s 4.5,2 -o map.npy", &["4.5,2", "outside the grid"]),
        (&flat, "-s 1,1 --spacing 0 -o map.npy", &["positive"]),
        (&flat, "-s 1,1 --spacing -2 -o map.npy", &["positive"]),
        (&flat, "-s 1,1 --spacing 1,nan -o map.npy", &["nan", "finite number"]),
        (&flat, "-s 1,1 --spacing 1,2,3 -o map.npy", &["one for columns"]),
        (&flat, "-s 1,1 --spacing 1e300 -o map.npy", &["edge", "unit of length"]),
        (&positions, "-s 1,1 --spacing 2 -o map.npy", &["positions.npy", "need no spacing"]),
        ("builtin:plane:9x9", "-s 1,1 --spacing 2 -o map.npy", &["--spacing", "built-in"]),
        (&flat, "-s 1,1 --iterations 0 -o map.npy", &["at least one iteration"]),
        (&flat, "-s 1,1 --tolerance -1 -o map.npy", &["tolerance -1"]),
        (&flat, "-s 1,1 --tolerance nan -o map.npy", &["tolerance NaN"]),
        (&flat, "-s 1,1 --device 0 -o map.npy", &["--device", "--engine vulkan"]),
        (&flat, "-s 1,1 --precision double -o map.exr", &["map.exr", "single precision", ".tif"]),
        (&flat, "-s 1,1 --precision double --error e.exr -o m.npy", &["e.exr", "single precision"]),
        (&flat, "-s 1,1 --precision double --schedule tiles -o map.npy", &["--schedule"]),
        (&flat, "-s 1,1 --precision half -o map.npy", &["half", "double"]),
        (&flat, "-s 1,1 --edges chord --metric METRIC -o map.npy", &["--edges", "leave"]),
        (&flat, "-s 1,1 --wavefront round -o map.npy", &["round", "planar"]),
        ("builtin:plane:0x0", "-s 0,0 -o map.npy", &["0 x 0", "empty"]),
        ("builtin:plane:1000000x1000000", "-s 0,0 -o map.npy", &["too large", "268435456"]),
        ("builtin:plane:99999999999999999999x2", "-s 0,0 -o map.npy", &["ROWSxCOLS"]),
        ("builtin:plane", "-s 0,0 -o map.npy", &["ROWSxCOLS"]),
        ("builtin:teapot:9x9", "-s 0,0 -o map.npy", &["teapot", "plane", "torus"]),
    ] {
        let words = words.replace("METRIC", &metric);
        bench.refuses(&bench.distance(surface, &words), parts);
    }
    for stop in ["--iterations 3", "--tolerance 1e-3"] {
        let line = format!("distance {flat} --engine fast-marching -s 1,1 -o map.npy {stop}");
        bench.refuse(line, &["--iterations", "fast marching"]);
    }
}

/// Tests of the library have every fault of every format.
#[test]
fn wrong_surfaces_are_refused_by_name() {
    let bench = Workbench::new();
    bench.array("infinite.npy", &[2, 2], &[0.0, 1.0, f64::INFINITY, 0.0]);
    bench.array("holes.npy", &[2, 2], &[f64::NAN; 4]);
    bench.array("cube.npy", &[2, 2, 2], &[0.0; 8]);
    bench.array("indefinite.npy", &[2, 2, 2, 2], &[1.0, 2.0, 2.0, 1.0].repeat(4));
    bench.array("unknown.obj", &[2, 2], &[0.0; 4]);
    fs::create_dir(bench.inputs.path().join("folder.npy")).unwrap();
    for (name, shape, count) in [("mask.npy", "(2, 2)", 4), ("mask3.npy", "(2, 2, 3)", 12)] {
        let header = format!("{{'descr': '|b1', 'fortran_order': False, 'shape': {shape}}}");
        let length = [header.len() as u8, 0];
        let values = vec![1; count];
        bench.input(
            name,
            [b"\x93NUMPY\x01\x00", &length[..], header.as_bytes(), &values[..]].concat(),
        );
    }
    let mut rgb = Vec::new();
    let mut encoder = png::Encoder::new(&mut rgb, 2, 2);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(&[0; 12]).unwrap();
    bench.input("rgb.png", rgb);
    for name in ["empty.png", "text.npy", "text.tif", "text.exr"] {
        bench.input(name, if name.starts_with("text") { "0 1 2 3" } else { "" });
    }
    for (name, parts) in [
        ("missing.npy", &["cannot be read"][..]),
        ("folder.npy", &["is a folder"]),
        ("unknown.obj", &["unknown extension .obj", ".npy, .npz, .png, .tif, .asc or .exr"]),
        ("empty.png", &["empty"]),
        ("rgb.png", &["Rgb", "only grey PNG"]),
        ("text.npy", &["no NumPy .npy file"]),
        ("text.tif", &["not a usable TIFF file"]),
        ("text.exr", &["not a usable EXR file"]),
        ("infinite.npy", &["height at row 1, column 0 is infinite", "NaN"]),
        ("holes.npy", &["no point of the surface is left"]),
        ("cube.npy", &["(2, 2, 2)", "(M, N, 3)"]),
        ("mask.npy", &["holds booleans", "--mask"]),
        ("mask3.npy", &["holds booleans", "--mask"]),
        ("indefinite.npy", &["row 0, column 0", "positive definite"]),
    ] {
        let path = bench.inputs.path().join(name);
        let output = bench.distance(path.to_str().unwrap(), "-s 0,0 -o map.npy");
        bench.refuses(&output, &[&[name], parts].concat());
    }
}

#[test]
fn wrong_companions_are_refused_by_name() {
    let bench = Workbench::new();
    let flat = bench.flat(3, 4);
    let doubles = bench.array("doubles.npy", &[3, 4], &[1.0; 12]);
    let small = bench.array("small.npy", &[2, 4], &[1.0; 8]);
    let mut zero = [1.0; 12];
    zero[6] = -0.5;
    let zero = bench.array("zero.npy", &[3, 4], &zero);
    let metric = bench.array("metric.npy", &[3, 3, 2, 2], &[1.0, 0.0, 0.0, 1.0].repeat(9));
    let header = "{'descr': '|b1', 'fortran_order': False, 'shape': (4, 3)}";
    let length = [header.len() as u8, 0];
    let turned = bench.input(
        "turned.npy",
        [b"\x93NUMPY\x01\x00", &length[..], header.as_bytes(), &[1; 12]].concat(),
    );
    let curve = bench.input("curve.txt", "0,0\n1;1\noops\n");
    let outside = bench.input("outside.txt", "0,0\n1,9\n");
    let blank = bench.input("blank.txt", "# nothing\n");
    for (words, parts) in [
        (format!("--mask {doubles}"), &["doubles.npy", "booleans or integers"][..]),
        (format!("--mask {turned}"), &["turned.npy", "4 x 3", "3 x 4"]),
        (format!("--mask {curve}"), &["curve.txt", ".npy, .npz, .png"]),
        (format!("--slowness {small}"), &["small.npy", "2 x 4", "3 x 4"]),
        (
            format!("--slowness {zero}"),
            &["zero.npy", "slowness -0.5 at row 1, column 2", "negative"],
        ),
        (format!("--metric {metric}"), &["metric.npy", "3 x 3", "3 x 4"]),
        (format!("--metric {doubles}"), &["doubles.npy", "(M, N, 2, 2)"]),
        (format!("--source-curve {curve}"), &["curve.txt", "line 3", "row,col"]),
        (
            format!("--source-curve {outside}"),
            &["outside.txt", "line 2", "column 9", "outside the grid"],
        ),
        (format!("--source-curve {blank}"), &["blank.txt", "no place"]),
        (format!("--source-curve {doubles}"), &["doubles.npy", "(K, 2)"]),
        (format!("--source-points {curve}"), &["curve.txt", "line 3", "row,col"]),
        (
            format!("--source-points {outside}"),
            &["outside.txt", "line 2", "column 9", "outside the grid"],
        ),
    ] {
        bench.refuses(&bench.distance(&flat, &format!("-s 0,0 -o map.npy {words}")), parts);
    }
}

#[test]
fn outputs_that_cannot_be_written_are_refused_before_anything_is_read() {
    let bench = Workbench::new();
    // The surface does not exist: its error would come first if the file were opened.
    for (words, parts) in [
        ("-o map.txt", &["unknown extension .txt", ".npy, .tif or .exr"][..]),
        ("-o map", &["no extension"]),
        ("-o no/map.npy", &["no/map.npy", "no folder", "create it"]),
        ("-o map.npy --picture no/map.png", &["no/map.png", "no folder"]),
        ("-o map.npy --picture map.jpg", &["map.jpg", ".png"]),
    ] {
        bench.refuses(&bench.distance("missing.npy", &format!("-s 0,0 {words}")), parts);
    }
}

#[test]
fn existing_files_in_the_way_stay() {
    let bench = Workbench::new();
    let flat = bench.flat(5, 5);
    let before = fs::read(&flat).unwrap();
    let output = bench.run_args(["distance", &flat, "--engine", "cpu", "-s", "0,0", "-o", &flat]);
    bench.refuses(&output, &["flat.npy", "also an input"]);
    assert_eq!(fs::read(&flat).unwrap(), before);

    let folder = bench.inputs.path().join("map.npy");
    fs::create_dir(&folder).unwrap();
    let words = format!("-s 0,0 -o {}", folder.display());
    bench.refuses(&bench.distance(&flat, &words), &["map.npy", "a folder has this name"]);
}

#[cfg(unix)]
#[test]
fn names_need_not_be_text() {
    use std::os::unix::ffi::OsStrExt;
    let bench = Workbench::new();
    let name = OsStr::from_bytes(b"\xff.npy");
    let words = |words: &'static str| words.split(' ').map(OsStr::new);
    let output = bench.run_args(words("distance").chain([name]).chain(words("-s 0,0 -o map.npy")));
    bench.refuses(&output, &[".npy: cannot be read"]);
    let output =
        bench.run_args(words("distance builtin:plane:5x5 --engine cpu -s 0,0 -o").chain([name]));
    assert!(output.status.success(), "{}", stderr(&output));
    assert_eq!(map(&bench.output("").join(name)).len(), 25);
    let source = OsStr::from_bytes(b"1,\xff");
    let bench = Workbench::new();
    let output = bench.run_args(words("distance builtin:plane:5x5 -o map.npy -s").chain([source]));
    bench.refuses(&output, &["UTF-8"]);
}

#[cfg(unix)]
#[test]
fn links_are_followed_and_devices_left_alone() {
    let bench = Workbench::new();
    std::os::unix::fs::symlink(bench.inputs.path().join("real.npy"), bench.output("map.npy"))
        .unwrap();
    fs::write(bench.inputs.path().join("real.npy"), "old").unwrap();
    let output = bench.distance("builtin:plane:5x5", "-s 0,0 -o map.npy");
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(fs::symlink_metadata(bench.output("map.npy")).unwrap().is_symlink());
    assert_eq!(map(&bench.inputs.path().join("real.npy")).len(), 25);

    fs::remove_file(bench.output("map.npy")).unwrap();
    std::os::unix::fs::symlink("/dev/null", bench.output("map.npy")).unwrap();
    let output = bench.distance("builtin:plane:5x5", "-s 0,0 -o map.npy");
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("not a regular file"), "{}", stderr(&output));
}

#[cfg(unix)]
#[test]
fn a_closed_pipe_does_not_panic() {
    use std::process::{Command, Stdio};
    let bench = Workbench::new();
    let program = assert_cmd::cargo::cargo_bin!("geosweep");
    let mut child = Command::new(program)
        .current_dir(bench.outputs.path())
        .args("distance builtin:plane:65x65 --engine cpu -s 0,0 --json -o map.npy".split(' '))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(notes(&output), "");
}
