//! Programs in C: the example, the frame of the guide, and one that leaves out a barrier.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use crate::build::{Linkage, ROOT, check_syntax, compile, scratch, validated};

const EXAMPLE: &str = "examples/embed.c";

/// Returns the code blocks of a language in a page.
fn blocks<'a>(page: &'a str, language: &str) -> Vec<&'a str> {
    let parts = page.split("```");
    let blocks = parts.skip(1).step_by(2).filter_map(|block| block.split_once('\n'));
    blocks.filter(|block| block.0 == language).map(|block| block.1).collect()
}

fn read(file: &str) -> String {
    fs::read_to_string(Path::new(ROOT).join(file)).unwrap()
}

/// The header compiles on its own and when included twice, since headers are included by other headers. It
/// also compiles with the guide's code in C and C++.
#[test]
fn the_header_compiles_in_c_and_cpp() {
    let folder = scratch("header");
    let twice = "#include \"geosweep.h\"\n#include \"geosweep.h\"\n";
    let guide = read("docs/c.md");
    let page = read("docs/cpp.md");
    let in_cpp = blocks(&page, "cpp");
    assert_eq!(in_cpp.len(), 3, "a frame, frames together and memory of one's own");
    let in_c = blocks(&guide, "c");
    let [frame, curves] = in_c[..] else { panic!("a frame and its curves are in the guide, in C") };
    let objects = "#include \"geosweep.hpp\"\n#include \"geosweep.hpp\"\n";
    let with_objects = format!("{objects}{}", in_cpp.concat());
    // This header acts like volk's. It declares variables with the names of Vulkan's functions, so it needs
    // Vulkan without prototypes.
    let volk = "#pragma once\n#define VK_NO_PROTOTYPES\n#include <vulkan/vulkan_core.h>\n\
                extern PFN_vkCreateInstance vkCreateInstance;\n";
    fs::write(folder.join("volk.h"), volk).unwrap();
    let header = folder.join("volk.h");
    let with_volk = format!(
        "#define GEOSWEEP_VULKAN_HEADER \"{}\"\n{twice}#include \"{0}\"\n",
        header.display()
    );
    // Forward declarations suffice for a program's own headers.
    let forward = format!(
        "struct GeosweepSurface;\nstruct GeosweepFrame;\n\
         void draw(GeosweepSurface *surface, const GeosweepFrame &frame);\n{twice}"
    );
    let with_curves = format!(
        "{twice}void record(GeosweepSurface *surface, VkCommandBuffer commands, \
         GeosweepFrame frame);\n\
         void record(GeosweepSurface *surface, VkCommandBuffer commands, GeosweepFrame frame) \
         {{\n{curves}}}\n"
    );
    let renderer = "VkInstance instance, VkPhysicalDevice physical_device, VkDevice device, \
                    VkBuffer vertices, VkCommandBuffer load_commands, VkCommandBuffer commands, \
                    GeosweepSolver *solver, GeosweepSurface *surface, GeosweepPlan *plan, \
                    GeosweepImage distances";
    let with_frame =
        format!("{twice}void frame({renderer});\nvoid frame({renderer}) {{\n{frame}}}\n");
    for (name, standard, source) in [
        ("twice.c", "c99", twice),
        ("twice.cpp", "c++11", twice),
        ("objects.cpp", "c++11", objects),
        ("page.cpp", "c++17", &with_objects),
        ("volk.c", "c99", &with_volk),
        ("volk.cpp", "c++11", &with_volk),
        ("forward.cpp", "c++11", &forward),
        ("frame.c", "c99", &with_frame),
        ("frame.cpp", "c++20", &with_frame),
        ("curves.c", "c99", &with_curves),
        ("curves.cpp", "c++20", &with_curves),
    ] {
        fs::write(folder.join(name), source).unwrap();
        check_syntax(&folder.join(name), standard);
    }
}

/// The shader for hosts in C++ compiles.
#[test]
fn the_shader_of_contours_compiles() {
    use naga::valid::{Capabilities, ValidationFlags, Validator};
    let mut parser = naga::front::glsl::Frontend::default();
    let options = naga::front::glsl::Options::from(naga::ShaderStage::Fragment);
    let module = parser.parse(&options, &read("examples/cpp/contours.frag")).unwrap();
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::all());
    let info = validator.validate(&module).unwrap();
    assert!(naga::back::spv::write_vec(&module, &info, &Default::default(), None).is_ok());
}

/// The example compares its map with distances on a plane, and fails if they differ. It runs with the shared
/// and the static library.
#[test]
fn the_example_runs_and_the_validation_layers_have_nothing_to_say() {
    for linkage in [Linkage::Shared, Linkage::Static] {
        let program = scratch("example").join(format!("{linkage:?}"));
        compile(&Path::new(ROOT).join(EXAMPLE), &program, linkage);
        let run = validated(&program);
        let frames = run.printed.lines().filter(|line| line.starts_with("frame ")).count();
        assert_eq!((frames, run.findings), (10, Vec::new()), "{}", run.printed);
        // The distance on the level, from row 40, column 50 to the first corner, with half a unit between
        // points.
        let exact = 0.5 * f64::hypot(40.0, 50.0);
        assert!(run.printed.contains(&format!("frame 0: {exact:.3},")), "{}", run.printed);
    }
}

/// The example of a closed surface compares its maps with distances on a tube, and fails if they differ.
#[test]
fn the_closed_tube_runs_and_the_validation_layers_have_nothing_to_say() {
    let program = scratch("closed").join("closed");
    compile(&Path::new(ROOT).join("examples/closed.c"), &program, Linkage::Shared);
    let run = validated(&program);
    let frames = run.printed.lines().filter(|line| line.starts_with("frame ")).count();
    assert_eq!((frames, run.findings), (10, Vec::new()), "{}", run.printed);
    // On the circular tube of the first frame, the path from column 123 over the seam to column 8 spans 13 of 128
    // columns.
    let exact = 13.0 / 128.0 * std::f64::consts::TAU;
    assert!(run.printed.contains(&format!("and {exact:.4} to column 8,")), "{}", run.printed);
}

/// A hazard must be reported. This shows that the layers are active, and that the reader's stages matter.
#[test]
fn a_reader_that_is_not_named_is_reported() {
    let reader = "{{VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_READ_BIT},";
    let example = read(EXAMPLE);
    assert_eq!(example.matches(reader).count(), 1);
    let folder = scratch("unnamed-reader");
    let source = folder.join("embed.c");
    fs::write(&source, example.replace(reader, "{{0, 0},")).unwrap();
    compile(&source, &folder.join("embed"), Linkage::Shared);
    let findings = validated(&folder.join("embed")).findings;
    assert!(
        findings.iter().any(|line| line.contains("SYNC-HAZARD-READ-AFTER-WRITE")),
        "the validation layers report no hazard (on Debian and Ubuntu they come with \
         vulkan-validationlayers): {findings:?}"
    );
}

/// The guide's frame in C, with the code that a renderer has around it.
#[test]
fn the_frame_of_the_guide_compiles_and_runs() {
    let guide = read("docs/c.md");
    let blocks = blocks(&guide, "c");
    let mut frames = blocks.iter().filter(|block| block.contains("geosweep_solver_create("));
    let (Some(snippet), None) = (frames.next(), frames.next()) else {
        panic!("one block of C in the guide creates a solver")
    };
    let folder = scratch("snippet");
    let harness = read("tests/capi/snippet.c");
    let source = harness
        .replace("examples/embed.c", &format!("{ROOT}/{EXAMPLE}"))
        .replace("/* the guide's frame */", snippet);
    assert!(source.contains(snippet));
    fs::write(folder.join("snippet.c"), source).unwrap();
    compile(&folder.join("snippet.c"), &folder.join("snippet"), Linkage::Shared);
    let run = validated(&folder.join("snippet"));
    assert_eq!(run.findings, Vec::<String>::new(), "{}", run.printed);
    assert!(run.printed.contains("the snippet's map is right"), "{}", run.printed);
}

/// The program assigns and moves objects, and converts 64-bit accesses.
#[test]
fn objects_in_cpp_are_destroyed_once_and_in_order() {
    let program = scratch("objects").join("objects");
    compile(&Path::new(ROOT).join("tests/capi/objects.cpp"), &program, Linkage::Shared);
    let run = validated(&program);
    assert_eq!(run.findings, Vec::<String>::new(), "{}", run.printed);
    assert!(run.printed.contains("are as they should"), "{}", run.printed);
}

/// Both libraries contain all functions of the header: a program that takes the address of each one links.
#[test]
fn all_functions_are_in_both_libraries() {
    let header = read("crates/capi/src/geosweep.h");
    let declared =
        header.lines().filter(|line| !line.trim_start().starts_with("//") && line.contains('('));
    let names: BTreeSet<_> = declared
        .filter_map(|line| {
            let start = line.find("geosweep_")?;
            line[start..].split('(').next()
        })
        .collect();
    assert!(names.len() > 25, "{names:?}");
    let table: String = names.iter().map(|name| format!("    (Function){name},\n")).collect();
    let source = format!(
        "#include \"geosweep.h\"\n\
         typedef void (*Function)(void);\n\
         static const Function functions[] = {{\n{table}}};\n\
         int main(void) {{\n\
         \x20   for (unsigned i = 0; i < sizeof functions / sizeof *functions; i++) {{\n\
         \x20       if (!functions[i]) return 1;\n\
         \x20   }}\n\
         \x20   return geosweep_source_at(3.0f, 4.0f).col != 4.0f;\n\
         }}\n"
    );
    let folder = scratch("functions");
    fs::write(folder.join("functions.c"), source).unwrap();
    for linkage in [Linkage::Shared, Linkage::Static] {
        let program = folder.join(format!("{linkage:?}"));
        compile(&folder.join("functions.c"), &program, linkage);
        validated(&program);
    }
}
