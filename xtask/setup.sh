#!/bin/sh
# Makes ready what builds of firmware, runs in the emulator and tests of pages need, without root and without touching
# the system: what is installed in a sufficient version serves, and what is missing is fetched as Debian packages and
# unpacked below FOLDER: apt with a state of its own reads the system's sources, keys and list of packages, and a script
# for each program in FOLDER/bin, or in FOLDER/compiler/bin, finds the unpacked libraries.
#
#     setup.sh FOLDER check|ensure NEED…
#
# A library of C is not unpacked: a program starts with the loader of the system, and with no other library of C than
# its own.
set -eu
folder=$1 action=$2
shift 2
apt=$folder/apt
export LC_ALL=C PATH="$folder/bin:$PATH"

# What a need is: its title, packages, programs by their places, links PLACE:TARGET which the packages make when they
# are installed, and what to do where there is no apt-get: a package of most other systems, or a command.
need() {
    name=$1 links='' elsewhere=$1
    case $name in
    # Debian's compiler with the library's source, and the linker. `rustc-web` is Debian's own newer compiler; the one
    # named `rustc` is too old.
    compiler) title="Debian's compiler for chips" packages="rustc-web cargo-web rust-web-src lld-19" \
        programs="usr/bin/rustc usr/bin/rustdoc usr/bin/cargo usr/bin/ld.lld-19" \
        elsewhere="rustup target add thumbv7em-none-eabihf" ;;
    # Linker, C compiler and C library for WebAssembly, beside the compiler.
    wasm) title="linker and C compiler for WebAssembly" packages="lld-19 clang-19 wasi-libc" \
        programs="usr/bin/wasm-ld-19 usr/bin/clang-19" elsewhere="rustup target add wasm32-wasip1" ;;
    clang) title="the C compiler clang" packages=clang-19 programs=usr/bin/clang-19 elsewhere=clang ;;
    qemu) title="the emulator QEMU" packages=qemu-system-arm programs=usr/bin/qemu-system-arm ;;
    c-compiler) title="the C compiler for chips" programs='usr/bin/arm-none-eabi-*' elsewhere=gcc-arm-embedded \
        packages="gcc-arm-none-eabi binutils-arm-none-eabi libnewlib-arm-none-eabi" \
        links="usr/lib/arm-none-eabi/lib:newlib usr/lib/arm-none-eabi/include:../../include/newlib" ;;
    riscv) title="compiler and emulator for RISC-V" elsewhere=riscv-gnu-toolchain \
        packages="gcc-riscv64-unknown-elf binutils-riscv64-unknown-elf picolibc-riscv64-unknown-elf qemu-system-misc" \
        programs="usr/bin/riscv64-unknown-elf-* usr/bin/qemu-system-riscv32" ;;
    chromium) title=Chromium packages="chromium fonts-dejavu-core" programs=usr/lib/chromium/chromium ;;
    # The program by which tests drive it.
    driver) title="the driver of Chromium" packages=chromium-driver programs=usr/bin/chromedriver elsewhere=chromedriver ;;
    make | cmake) title=$name packages=$name programs=usr/bin/$name ;;
    python) title=Python packages=python3 programs='usr/bin/python3*' elsewhere=python3 ;;
    # The installer of Python's packages, which Debian has apart from Python.
    pip) title=pip packages=python3-pip-whl programs='' elsewhere=python3-pip ;;
    *) echo "no need $name" >&2 && exit 2 ;;
    esac
}

# at_least LOWEST COMMAND…: the first version that it prints is not below this one.
at_least() {
    lowest=$1
    shift
    found=$("$@" 2> /dev/null | grep -o '[0-9][0-9.]*' | head -n 1)
    [ -n "$found" ] && [ "$(printf '%s\n' "$lowest" "$found" | sort -V | head -n 1)" = "$lowest" ]
}

# Whether what is installed or unpacked serves.
serves() {
    case $name in
    compiler)
        # Not on the search path, where rustup's come first.
        own=$folder/compiler/bin
        [ -d "$own" ] || own=/usr/bin
        at_least 1.89 "$own/rustc" --version && [ -x "$own/rustdoc" ] && [ -x "$own/cargo" ] &&
            [ -x "$own/ld.lld-19" ] && [ -d "$("$own/rustc" --print sysroot)/lib/rustlib/src/rust/library/core" ]
        ;;
    wasm) command -v wasm-ld-19 && command -v clang-19 &&
        { [ -f /usr/lib/wasm32-wasi/libc.a ] || [ -f "$folder/wasm/usr/lib/wasm32-wasi/libc.a" ]; } ;;
    clang) command -v clang-19 || command -v clang ;;
    driver) command -v chromedriver ;;
    # The first version that has all boards.
    qemu) at_least 6.0 qemu-system-arm --version ;;
    # With the first linker that has all options. The place of a file that it does not have is the bare name.
    c-compiler) at_least 12 arm-none-eabi-gcc -dumpversion &&
        [ "$(arm-none-eabi-gcc -print-file-name=nano.specs)" != nano.specs ] ;;
    riscv) riscv64-unknown-elf-gcc --version > /dev/null 2>&1 && qemu-system-riscv32 --version > /dev/null 2>&1 ;;
    chromium) command -v chromium || command -v chromium-browser || command -v google-chrome ;;
    make) at_least 3 make --version ;;
    # The version that the project of the documents asks for.
    cmake) at_least 3.22 cmake --version ;;
    python) python3 -c 'import venv' 2> /dev/null ;;
    pip) python3 -c 'import ensurepip' 2> /dev/null || [ -d "$folder/pip/usr/share/python-wheels" ] ;;
    esac > /dev/null
}

remedy() {
    case $elsewhere in rustup*) ;; *)
        for call in "sudo apt-get install $packages" "brew install $elsewhere" "sudo dnf install $elsewhere"; do
            program=${call#sudo }
            command -v "${program%% *}" > /dev/null && elsewhere=$call && break
        done ;;
    esac
    printf '%s cannot be set up: %s; remedy:\n    %s\n' "$title" "$1" "$elsewhere" >&2
    exit 1
}

# The system's list of installed packages without those that are to be unpacked and those of the same source, which look
# for each other beside them; without relations, so that no installed package hinders another one.
status() {
    awk -v wanted=" $packages " -v sources=" $1 " 'BEGIN { RS = ""; FS = "\n" } {
        name = source = kept = ""
        for (k = 1; k <= NF; k++) {
            if ($k ~ /^Package: /) name = substr($k, 10)
            if ($k ~ /^Source: /) { source = substr($k, 9); sub(/ \(.*/, "", source) }
            if ($k ~ /^(Package|Status|Architecture|Multi-Arch|Version|Provides): /) kept = kept $k "\n"
        }
        if (source == "") source = name
        if (!index(wanted, " " name " ") && !index(sources, " " source " ")) print kept
    }' /var/lib/dpkg/status
}

# Reads the lists of packages.
update() {
    mkdir -p "$apt/lists/partial" "$apt/archives/partial"
    # Hooks of the system would write outside. An address that does not answer ends the command in its first minute.
    cat > "$apt/apt.conf" <<END
Dir::State "$apt";
Dir::State::lists "$apt/lists";
Dir::State::status "$apt/status";
Dir::Cache "$apt";
#clear APT::Update::Pre-Invoke;
#clear APT::Update::Post-Invoke;
#clear APT::Update::Post-Invoke-Success;
#clear DPkg::Post-Invoke;
Acquire::IndexTargets::deb::DEP-11::DefaultEnabled "false";
Acquire::IndexTargets::deb::Contents-deb::DefaultEnabled "false";
Acquire::Languages "none";
Acquire::Retries "1";
Acquire::http::Timeout "10";
Acquire::https::Timeout "10";
APT::Get::Assume-Yes "true";
APT::Get::allow-change-held-packages "true";
APT::Get::allow-downgrades "true";
APT::Get::allow-remove-essential "true";
APT::Install-Recommends "false";
APT::Keep-Downloaded-Packages "true";
APT::Sandbox::User "root";
Debug::NoLocking "true";
END
    packages='' status '' > "$apt/status"
    echo "reading the lists of packages" >&2
    # A source of another project may be out of reach; it matters if what is missing is not in the others.
    apt-get --config-file "$apt/apt.conf" --quiet --quiet update >&2 || true
}

install() {
    # shellcheck disable=SC2086
    apt-get --config-file "$apt/apt.conf" install -o "Dir::State::status=$apt/status-$name" \
        -o "Dir::Cache::archives=$apt/archives-$name" "$@" $packages
}

# Finds the files that are needed and that the system does not have.
plan() {
    mkdir -p "$apt/archives-$name/partial"
    # shellcheck disable=SC2086
    sources=$(apt-cache --config-file "$apt/apt.conf" show --no-all-versions $packages |
        awk '/^Package: / { name = $2 } /^Source: / { name = $2 } /^$/ { print name } END { print name }' | tr '\n' ' ')
    status "$sources" > "$apt/status-$name"
    install --print-uris > "$apt/uris"
    sed -n "s/^'[^']*' \([^ ]*\) .*/\1/p" "$apt/uris" | grep -v -e '^libc6_' -e '^libc-bin_' > "$apt/files-$name"
}

# Fetches and unpacks them into FOLDER/NAME; until all is done, under another name.
unpack() {
    echo "fetching $title" >&2
    root=$folder/$name part=$folder/$name.part
    install --download-only --quiet --quiet >&2
    rm -rf "$part" "$root"
    mkdir -p "$part/bin" "$folder/bin"
    while read -r file; do dpkg-deb --extract "$apt/archives-$name/$file" "$part"; done < "$apt/files-$name"
    for link in $links; do ln -s "${link#*:}" "$part/${link%%:*}"; done
    # Absolute links lead to what is unpacked.
    find "$part" -type l | while read -r link; do
        target=$(readlink "$link")
        case $target in /*) [ ! -e "$part$target" ] || ln -sfnr "$part$target" "$link" ;; esac
    done
    # The descriptions of C libraries name folders of the system.
    [ ! -d "$part/usr/lib/arm-none-eabi/newlib" ] ||
        find "$part/usr/lib/arm-none-eabi/newlib" -name '*.specs' -exec sed -i "s| /usr/| $root/usr/|g" {} +
    libraries=$(find "$part" -name 'lib*.so*' -printf "$root/%P\n" | sed 's|/[^/]*$||' | sort -u | paste -sd: -)
    settings=
    [ -z "$libraries" ] || settings="export LD_LIBRARY_PATH='$libraries'\${LD_LIBRARY_PATH:+:\$LD_LIBRARY_PATH}"
    if [ -d "$part/usr/share/fonts" ]; then
        # The configuration of the packages names folders of the system only.
        cat > "$part/fonts.conf" <<END
<?xml version="1.0"?>
<!DOCTYPE fontconfig SYSTEM "urn:fontconfig:fonts.dtd">
<fontconfig>
  <dir>/usr/share/fonts</dir>
  <dir>$root/usr/share/fonts</dir>
  <cachedir>$root/cache</cachedir>
</fontconfig>
END
        settings="$settings FONTCONFIG_FILE='$root/fonts.conf'"
    fi
    for program in $programs; do
        for place in "$part"/$program; do
            words="'$root/${place#"$part"/}'"
            # The script names the compiler's library by a way that is in no workspace: by its plain name it is inside
            # of this one and outside of all others, where cargo calls it by different names, and each workspace would
            # compile `core` again for the same target directory.
            case $place in */rustc) words="$words --sysroot '/proc/self/root$root/usr'" ;; esac
            script=$part/bin/${place##*/}
            printf '#!/bin/sh\n%s\nexec %s "$@"\n' "$settings" "$words" > "$script"
            chmod +x "$script"
            [ "$name" = compiler ] || ln -sfn "../$name/bin/${place##*/}" "$folder/bin/"
        done
    done
    mv "$part" "$root"
    rm -r "$apt/archives-$name"
}

missing() { for one in "$@"; do need "$one" && { serves || echo "$one"; }; done | sort -u; }

wanted=$(missing "$@")
[ -n "$wanted" ] || exit 0
[ "$action" = ensure ] || exit 1
# shellcheck disable=SC2086
set -- $wanted
need "$1"
command -v apt-get > /dev/null || remedy "it is not installed, and there is no apt-get to fetch it"
mkdir -p "$folder"
# Another run may do the same; this one then waits, and finds it.
exec 9> "$folder/lock"
flock 9
# shellcheck disable=SC2046
set -- $(missing "$@")
[ $# -gt 0 ] || exit 0
update
# What cannot be had is an error before anything large is fetched.
for one in "$@"; do
    need "$one"
    plan || remedy "the system's sources do not have its packages, or cannot be reached"
done
for one in "$@"; do
    need "$one"
    unpack || remedy "its packages cannot be fetched"
    serves || remedy "the packages of the system's sources are too old, or do not run with its libraries"
done
