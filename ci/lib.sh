# shellcheck shell=bash
# Shared parts of the commands in ci/. Sourced from the checkout's root, under `set -euo pipefail`.

say() { printf '%s: %s\n' "ci/${0##*/}" "$*"; }
die() {
    say "$*" >&2
    exit 1
}

# Announces a command, runs it, and prints how long it took.
step() {
    local start=$SECONDS
    printf '\n==> %s\n' "$*"
    "$@"
    ((SECONDS - start < 5)) || say "that took $((SECONDS - start)) s"
}

# A shell that is not a login shell often lacks rustup's folder.
export PATH="$PATH:${CARGO_HOME:-${HOME:-/}/.cargo}/bin"

# ---------------------------------------------------------------- Rust

# need_rust [SUBCOMMAND...]: checks that cargo is as new as Cargo.toml requires, and that the given
# subcommands exist, which a minimal toolchain lacks.
need_rust() {
    local cure="install Rust with rustup (https://rustup.rs)"
    local have want sub
    want=$(sed -n 's/^rust-version *= *"\([0-9.]*\)".*/\1/p' Cargo.toml)
    want=${want:-1.89}
    command -v cargo >/dev/null || die "cargo is missing; $cure, then run this again"
    have=$(cargo --version 2>&1) || die "cargo does not work ($have); $cure, then run this again"
    have=$(cut -d ' ' -f 2 <<<"$have")
    [[ $(printf '%s\n' "$want" "${have%%-*}" | sort -V | head -n 1) == "$want" ]] ||
        die "cargo $have is older than $want; 'rustup update stable', or $cure"
    for sub; do
        cargo "$sub" --version >/dev/null 2>&1 ||
            die "'cargo $sub' is missing; 'rustup component add clippy rustfmt' brings it"
    done
}

# ------------------------------------------------------------ packages

# Each requirement is tested by its purpose, not by a package's name, so that a system prepared in another way
# stays unchanged.
have_archive() { have_library "lib$1.a"; }
have_library() { [[ $(c++ -print-file-name="$1" 2>/dev/null) == /* ]]; }
have_json() { # the folders in which the Vulkan loader looks
    local home=${HOME:-/}
    [[ -n $(find {/usr,/usr/local}/share/vulkan {/etc,/usr/local/etc,/etc/xdg}/vulkan \
        "$home"/.{config,local/share}/vulkan -name "$1" 2>/dev/null) ]]
}

# need WHY PACKAGE[|PACKAGE...] TEST...: notes a package if the test fails. Of several names, it is the first
# one known here.
need() {
    local why=$1 names=$2
    shift 2
    "$@" || missing+=("$why=$names")
}

have_environments() { "${PYTHON:-python3}" -c 'import ensurepip, venv' 2>/dev/null; }

# list_missing [for_tests|for_python|for_wheels|for_windows|for_cmake|for_programs]
list_missing() {
    missing=()
    need "certificates, for cargo's downloads" ca-certificates test -e /etc/ssl/certs/ca-certificates.crt
    need "C++ compiler, linker and library" g++ command -v c++ >/dev/null
    if [[ ${1-} == for_tests || ${1-} == for_python || ${1-} == for_wheels ]]; then
        need "Python, for the package in python/" python3 command -v "${PYTHON:-python3}" >/dev/null
        need "virtual environments, for the same" python3-venv have_environments
    fi
    if [[ ${1-} == for_wheels ]]; then
        need "advzip, which packs wheels tighter" advancecomp command -v advzip >/dev/null
    fi
    if [[ ${1-} == for_windows ]]; then
        need "C compiler that links for Windows" gcc-mingw-w64-x86-64 command -v x86_64-w64-mingw32-gcc >/dev/null
        need "the same for C++" g++-mingw-w64-x86-64 command -v x86_64-w64-mingw32-g++ >/dev/null
    fi
    if [[ ${1-} == for_cmake || ${1-} == for_programs ]]; then
        need "CMake, for the library for C" cmake command -v cmake >/dev/null
        need "make, by which CMake builds" make command -v make >/dev/null
    fi
    if [[ ${1-} == for_programs ]]; then
        need "pkg-config, for programs in C" pkg-config command -v pkg-config >/dev/null
        need "Vulkan's headers, for the same" libvulkan-dev test -e /usr/include/vulkan/vulkan_core.h
    fi
    case ${1-} in for_python | for_wheels | for_windows | for_cmake | for_programs) return 0 ;; esac
    if [[ -z ${SHADERC_LIB_DIR-} ]]; then
        need "GLSL compiler for build.rs" libshaderc-dev have_archive shaderc_combined
        need "a part of it that it is packaged without" glslang-dev have_archive glslang
        need "another such part" "libspirv-tools-dev|spirv-tools-dev|spirv-tools" have_archive SPIRV-Tools-opt
    fi
    need "Vulkan loader" libvulkan1 have_library libvulkan.so.1
    [[ -n ${VK_DRIVER_FILES-}${VK_ICD_FILENAMES-} ]] ||
        need "lavapipe, Vulkan on the CPU" mesa-vulkan-drivers have_json 'lvp_icd*.json'
    if [[ -n ${1-} ]]; then
        need "validation layers" vulkan-validationlayers have_json 'VkLayer_khronos_validation.json'
        need "Vulkan's headers and linker's library, for programs in C" libvulkan-dev have_library libvulkan.so
        need "CMake, for programs in C++" cmake command -v cmake >/dev/null
        need "make, by which CMake builds" make command -v make >/dev/null
        need "pkg-config, for the same" pkg-config command -v pkg-config >/dev/null
        need "spirv-val, the SPIR-V checker" spirv-tools command -v spirv-val >/dev/null
        need "X server without a screen, for the viewer's tests" xvfb command -v Xvfb >/dev/null
        # The viewer loads these when it starts.
        need "X11, for the viewer" libx11-6 have_library libX11.so.6
        need "X11, for the viewer" libx11-xcb1 have_library libX11-xcb.so.1
        need "pointers, for the viewer" libxcursor1 have_library libXcursor.so.1
        need "input devices, for the viewer" libxi6 have_library libXi.so.6
        need "keyboards, for the viewer" libxkbcommon-x11-0 have_library libxkbcommon-x11.so.0
    fi
}

# install_missing [for_tests|for_python|for_wheels|for_windows|for_cmake|for_programs]
install_missing() {
    local -a missing packages=() as_root=()
    local entry name names
    list_missing "$@"
    ((${#missing[@]})) || return 0
    say "missing on this machine:"
    for entry in "${missing[@]}"; do
        printf '    %s (%s)\n' "${entry##*=}" "${entry%=*}"
    done
    command -v apt-get >/dev/null || die "no apt-get here: install these yourself, under whatever name they have"
    if ((EUID != 0)); then
        command -v sudo >/dev/null || die "run this as root, or install sudo"
        as_root=(sudo)
        [[ -t 0 ]] || as_root=(sudo -n) # nobody is there to type a password
    fi
    # apt asks no questions, waits for another apt's lock and leaves running services alone.
    as_root+=(env DEBIAN_FRONTEND=noninteractive NEEDRESTART_SUSPEND=1
        apt-get -o DPkg::Lock::Timeout=300 -o Acquire::Retries=3)
    say "reading the package lists"
    "${as_root[@]}" -q=2 update </dev/null || say "some package lists could not be read; going on without them"
    for entry in "${missing[@]}"; do
        IFS='|' read -ra names <<<"${entry##*=}"
        for name in "${names[@]}" ""; do
            [[ -n $name ]] || die "no package ${entry##*=} is known here (${entry%=*})"
            [[ -n $(apt-cache show --no-all-versions "$name" 2>/dev/null) ]] && break
        done
        [[ " ${packages[*]} " == *" $name "* ]] || packages+=("$name")
    done
    say "installing ${packages[*]}"
    "${as_root[@]}" -q=2 install -y --no-install-recommends "${packages[@]}" </dev/null ||
        die "could not install them, see above; as root: apt-get install ${packages[*]}"
    list_missing "$@"
    ((${#missing[@]} == 0)) || die "still missing after the installation: ${missing[*]}"
}

# ------------------------------------------------------------- shaderc

# Debian's and Ubuntu's libshaderc, shared and static, lacks glslang and SPIRV-Tools, so that nothing can be
# linked with it. This writes a linker script under the library's name that groups all the static archives.
# GNU ld, gold, lld and mold understand it, and nothing is copied. It is outside target/, which `cargo clean`
# deletes and which CARGO_TARGET_DIR moves.
link_shaderc() {
    if [[ -n ${SHADERC_LIB_DIR-} ]]; then
        say "using your SHADERC_LIB_DIR=$SHADERC_LIB_DIR, unchecked"
        forget_older_shaderc "$SHADERC_LIB_DIR"
        return
    fi
    local dir=$PWD/.shaderc name path new
    local -a archives=()
    # Only some versions have the last five.
    for name in shaderc_combined glslang SPIRV-Tools-opt SPIRV-Tools \
        SPIRV MachineIndependent GenericCodeGen OSDependent OGLCompiler; do
        have_archive "$name" || continue
        path=$(c++ -print-file-name="lib$name.a")
        archives+=("$(readlink -f "$path")")
    done
    # Sizes and times distinguish versions of the packages. The folder's own path shows that a checkout was
    # moved.
    new="/* Made by ci/setup: libshaderc with all its parts.
   $dir
$(stat -c '   %s %Y %n' "${archives[@]}")
*/
GROUP($(printf ' "%s"' "${archives[@]}") )"
    if [[ $new != "$(cat "$dir/libshaderc.so" 2>/dev/null)" ]]; then
        say "writing .shaderc/libshaderc.so, a linker script"
        rm -rf "$dir.new"
        mkdir -p "$dir.new"
        echo '*' >"$dir.new/.gitignore"
        printf '%s\n' "$new" >"$dir.new/libshaderc.so"
        if ! try_shaderc "$dir.new"; then
            rm -r "$dir.new"
            die "libshaderc as installed here does not work, see above;
    with a working one, set SHADERC_LIB_DIR to its folder"
        fi
        rm -rf "$dir"
        mv "$dir.new" "$dir"
    fi
    forget_older_shaderc "$new"
}

# Links a program with the libshaderc in folder $1, and compiles a shader with it.
try_shaderc() {
    c++ -x c++ -o "$1/try" - -L"$1" -lshaderc -pthread <<'END' && "$1/try" && rm "$1/try"
#include <cstdio>
#include <cstring>
#include <shaderc/shaderc.h>
int main() {
    const char *glsl = "#version 450\nlayout(local_size_x = 8) in;"
                       "layout(binding = 0) buffer B { float v[]; };"
                       "void main() { v[gl_GlobalInvocationID.x] *= 2.0; }";
    shaderc_compile_options_t options = shaderc_compile_options_initialize();
    shaderc_compile_options_set_target_env(options, shaderc_target_env_vulkan, shaderc_env_version_vulkan_1_1);
    shaderc_compile_options_set_optimization_level(options, shaderc_optimization_level_performance);
    shaderc_compilation_result_t result = shaderc_compile_into_spv(
        shaderc_compiler_initialize(), glsl, std::strlen(glsl), shaderc_compute_shader, "try", "main", options);
    std::fputs(shaderc_result_get_error_message(result), stderr);
    return shaderc_result_get_compilation_status(result) != shaderc_compilation_status_success;
}
END
}

# Cargo does not notice that the library behind shaderc-sys was replaced. A note in the target folder names
# the one ($1) with which it was built.
forget_older_shaderc() {
    local target note
    target=$(cargo metadata --no-deps --format-version 1 |
        sed -n 's/.*"target_directory":"\([^"]*\)".*/\1/p')
    [[ -n $target ]] || die "cargo metadata names no target folder"
    note=$target/shaderc-built-with
    [[ $1 != "$(cat "$note" 2>/dev/null)" ]] || return 0
    if [[ -d $target ]]; then
        say "dropping what was built with another libshaderc, if anything"
        # Cargo removes the build of only one profile at a time.
        for profile in dev release ci; do
            cargo clean -q --profile "$profile" -p shaderc-sys ||
                die "could not; run 'cargo clean', then this again"
        done
    fi
    mkdir -p "$target"
    printf '%s\n' "$1" >"$note"
}

# -------------------------------------------------------------- Vulkan

# check_vulkan [LAYER]: checks that the loader finds a device (the one named by GEOSWEEP_TEST_DEVICE, if set)
# and the layer.
check_vulkan() {
    local scratch devices
    scratch=$(mktemp -d)
    # shellcheck disable=SC2064 # the value of now is meant
    trap "rm -rf '$scratch'" EXIT
    c++ -o "$scratch/devices" ci/vulkan-devices.cpp -ldl
    devices=$("$scratch/devices" "$@") || die "Vulkan does not work here, see above.
    Lavapipe's driver file is lvp_icd*.json in /usr/share/vulkan/icd.d; VK_DRIVER_FILES and
    VK_ICD_FILENAMES replace all driver files (now: '${VK_DRIVER_FILES-}', '${VK_ICD_FILENAMES-}')"
    say "Vulkan devices: ${devices//$'\n'/, }"
    [[ ${devices,,} == *"$(tr '[:upper:]' '[:lower:]' <<<"${GEOSWEEP_TEST_DEVICE-}")"* ]] ||
        die "none of them is called '$GEOSWEEP_TEST_DEVICE' (GEOSWEEP_TEST_DEVICE);
    lavapipe, in the package mesa-vulkan-drivers, is called llvmpipe"
}

# build_all: builds the libraries, programs, tests and examples, with all features. The tests' dependencies decide on
# features of other crates. So the tool and the extension for Python are built together with the tests; alone, each
# would compile the library again.
build_all() {
    cargo build --profile ci --workspace --all-features --lib --bins --tests --examples
}

# test_binaries TARGET...: builds these targets of the library's tests (--lib, --test NAME), and prints the name and the
# path of each binary.
test_binaries() {
    local arguments=(test --profile ci -p geosweep --all-features "$@" --no-run)
    step cargo "${arguments[@]}" >&2
    cargo "${arguments[@]}" --message-format json 2>/dev/null |
        sed -n 's/.*"kind":\["\([a-z]*\)[^]]*\].*"name":"\([a-z]*\)".*"executable":"\([^"]*\)".*/\1 \2 \3/p' |
        sed 's/^lib geosweep /lib /; s/^test //'
}

# ------------------------------------------------------------ releases

# Platforms of binaries: the Rust target, and the target of zig's C compiler with the oldest glibc on which the
# binaries run. Windows is linked by mingw-w64.
declare -A rust_target=(
    [linux-x86_64]=x86_64-unknown-linux-gnu
    [linux-aarch64]=aarch64-unknown-linux-gnu
    [musl-x86_64]=x86_64-unknown-linux-musl
    [musl-aarch64]=aarch64-unknown-linux-musl
    [windows-x86_64]=x86_64-pc-windows-gnu
)
oldest_glibc=2.28

# The version of the packages, from Cargo.toml.
release_version() { sed -n '/^\[workspace.package\]/,/^\[d/s/^version = "\(.*\)"$/\1/p' Cargo.toml; }

# Prints the number'th (1) fenced block of a language in a page of Markdown.
block() { # FILE LANGUAGE [NUMBER]
    awk -v fence="\`\`\`$2" -v wanted="${3:-1}" '
        $0 == fence && ++count == wanted { inside = 1; next }
        inside && /^```/ { exit }
        inside { print }' "$1"
}

# release_tools PLATFORM...: installs what building for these platforms needs, and says what: maturin, zig and
# cargo-zigbuild from PyPI in a virtual environment below the target folder, targets of Rust, mingw-w64.
release_tools() {
    local platform target
    tools=${CARGO_TARGET_DIR:-$PWD/target}/release-tools
    install_missing for_python
    [[ -x $tools/bin/maturin && -x $tools/bin/cargo-zigbuild ]] || {
        say "maturin, cargo-zigbuild and ziglang from PyPI go into $tools"
        step "${PYTHON:-python3}" -m venv "$tools"
        step "$tools/bin/pip" install -q -c python/checks.txt maturin cargo-zigbuild ziglang
    }
    export PATH=$tools/bin:$PATH
    for platform; do
        [[ $platform != native ]] || continue
        target=${rust_target[$platform]-}
        [[ -n $target ]] || die "unknown platform $platform; these are known: native ${!rust_target[*]}"
        [[ -d $(rustc --print target-libdir --target "$target" 2>/dev/null) ]] || step rustup target add "$target"
        [[ $platform != windows-* ]] || install_missing for_windows
    done
}

# linker PLATFORM: prints the C compiler that links for a platform.
linker() {
    local path=$tools/cc-$1 target=${rust_target[$1]}
    case $1 in
    windows-x86_64) path=x86_64-w64-mingw32-gcc ;;
    *)
        target=${target/-unknown/}
        [[ $1 == musl-* ]] || target+=.$oldest_glibc
        printf '#!/bin/sh\nexec %q zig cc -- -target %s "$@"\n' "$tools/bin/cargo-zigbuild" "$target" >"$path"
        chmod +x "$path"
        ;;
    esac
    printf '%s' "$path"
}
