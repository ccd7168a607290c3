//! The SPIR-V in glsl/spirv compared with the SPIR-V that the build has compiled.

use std::collections::BTreeSet;
use std::path::Path;

/// Returns the instructions of a module, sorted, since compilers differ in the order of decorations. The
/// header's third word names the compiler and is left out.
fn instructions(spirv: &[u8]) -> Vec<Vec<u32>> {
    let words: Vec<u32> =
        spirv.chunks_exact(4).map(|word| u32::from_le_bytes(word.try_into().unwrap())).collect();
    assert_eq!(words[0], 0x0723_0203, "not SPIR-V");
    let mut instructions = vec![vec![words[1], words[3]]];
    let mut rest = &words[5..];
    while let Some(first) = rest.first() {
        let (instruction, others) = rest.split_at((first >> 16) as usize);
        instructions.push(instruction.to_vec());
        rest = others;
    }
    instructions.sort();
    instructions
}

fn modules(folder: &str) -> BTreeSet<String> {
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name());
    files.filter_map(|name| name.into_string().ok()).filter(|name| name.ends_with(".spv")).collect()
}

/// Other versions of glslang may compile the same source to other instructions. So ci/test requests this test
/// only where the version is known to agree.
#[test]
fn committed_spirv_is_what_the_sources_compile_to() {
    let (compiled, committed) = (env!("OUT_DIR"), "glsl/spirv");
    assert_eq!(modules(compiled), modules(committed));
    if std::env::var_os("GEOSWEEP_COMPARE_SPIRV").is_none() {
        return;
    }
    for name in modules(committed) {
        let read =
            |folder: &str| instructions(&std::fs::read(Path::new(folder).join(&name)).unwrap());
        assert!(
            read(compiled) == read(committed),
            "{name} is stale: GEOSWEEP_UPDATE_SPIRV=1 cargo build --features shaderc renews it"
        );
    }
}
