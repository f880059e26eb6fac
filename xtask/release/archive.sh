# The archive of the C library: header, static libraries for the host and for chips, the project of the documents, and
# the files of c-api/package, by which pkg-config, CMake, Zephyr, PlatformIO, the Arduino IDE, CMSIS packs and ESP-IDF
# take the unpacked archive. The same libraries give the same bytes: files are sorted and have no times and owners.
#
# FOLDER has the project, in FOLDER/firmware; CHIP and RISCV are targets, CHIP_LIBRARY and RISCV_LIBRARY the
# libraries that export the interface only.
set -eu
name=bearing-watch-c-$VERSION library=libbearing_watch_c.a rig=examples/support/standard_rig
out=$FOLDER/$name
mkdir -p "$out"
mv "$FOLDER/firmware" "$out/"
put() { mkdir -p "$(dirname "$out/$2")" && cp "$1" "$out/$2"; }
for file in CHANGELOG.md LICENSE-APACHE LICENSE-MIT; do put $file $file; done
put c-api/ARCHIVE.md README.md
put c-api/README.md INTERFACE.md
for folder in include src; do put c-api/include/bearing_watch.h $folder/bearing_watch.h; done
put c-api/examples/BearingWatch/BearingWatch.ino examples/BearingWatch/BearingWatch.ino
for file in print.h records.c; do put c-api/examples/$file examples/$file; done
put $rig/held_out.bin examples/held_out.bin
for folder in examples examples/BearingWatch; do put $rig/model.h $folder/model.h; done

# The library for this machine and any model, and what a program links with besides, each once.
host=$(rustc -vV | sed -n 's/^host: //p')
mkdir -p "$TARGET/release-c"
BEARING_WATCH_PLAN='' CARGO_TARGET_DIR=$TARGET/release-c cargo rustc --release --package bearing-watch-c --lib \
    --crate-type staticlib -- --print "native-static-libs=$TARGET/release-c/needs"
system=$(tr ' ' '\n' < "$TARGET/release-c/needs" | awk 'NF && !seen[$0]++' | paste -sd' ' -)
made=$TARGET/release-c/release/$library
# Elsewhere the binary utilities are others.
[ "$(uname)" != Linux ] || { sh c-api/export.sh '' "$made" "$made.exported.a" && made=$made.exported.a; }

# strip PREFIX LIBRARY PLACE: without debugging information, which names folders of this machine.
strip_to() { mkdir -p "$out/$3" && "${1}strip" --strip-debug -D -o "$out/$3/$library" "$2"; }
strip_to '' "$made" "lib/$host"
strip_to riscv64-unknown-elf- "$RISCV_LIBRARY" "lib/$RISCV"
# The Arduino IDE takes libraries from folders of its own, by the names of cores and units.
for folder in "lib/$CHIP" src/cortex-m4/fpv4-sp-d16-hard src/cortex-m7/fpv5-sp-d16-hard; do
    strip_to arm-none-eabi- "$CHIP_LIBRARY" $folder
done

(cd c-api/package && find . -type f) | while read -r file; do
    mkdir -p "$(dirname "$out/$file")"
    minor=${VERSION#*.}
    sed -e "s|@VERSION@|$VERSION|g; s|@MAJOR@|${VERSION%%.*}|g; s|@MINOR@|${minor%%.*}|g; s|@HOST@|$host|g" \
        -e "s|@PROCESSOR@|${host%%-*}|g; s|@CHIP@|$CHIP|g; s|@RISCV@|$RISCV|g; s|@SYSTEM@|$system|g" \
        "c-api/package/$file" > "$out/$file"
    if grep '@' "$out/$file"; then echo "$file has a word that is not replaced" && exit 1; fi
done

# Licence texts of what the library contains.
cargo tree --locked --package bearing-watch-c --edges normal,no-proc-macro --prefix none --format '{p}' |
    sed -n 's/^\([^ ]*\) v\([^ ]*\)\( (\*)\)*$/\1-\2/p' | sort -u | while read -r package; do
    source=$(find "${CARGO_HOME:-$HOME/.cargo}/registry/src" -mindepth 2 -maxdepth 2 -name "$package" | head -n 1)
    texts=$out/licenses/$package
    mkdir -p "$texts"
    # Beside its manifest, or in the folder that REUSE has.
    find "$source" -maxdepth 1 -type f \( -iname 'licen[sc]e*' -o -iname 'copying*' -o -iname 'notice*' \
        -o -iname 'unlicense*' \) -exec cp {} "$texts" \;
    [ ! -d "$source/LICENSES" ] || cp "$source"/LICENSES/* "$texts"
    # A package of traits alone that forgot the texts: that of the second licence is the same for all.
    [ -n "$(ls "$texts")" ] || { grep -q '^license = "MIT OR Apache-2.0"' "$source/Cargo.toml" && cp LICENSE-APACHE "$texts"; }
done
cp "$(rustc --print sysroot)/share/doc/rust/COPYRIGHT-library.html" "$out/licenses/rust-standard-library.html"

rm -f "$DIST"/bearing-watch-c-*.tar.gz
tar --sort=name --mtime=@0 --owner=0 --group=0 --numeric-owner --mode=u=rw,go=r,a+X --format=ustar -C "$FOLDER" \
    -cf - "$name" | gzip -9n > "$DIST/$name.tar.gz"
