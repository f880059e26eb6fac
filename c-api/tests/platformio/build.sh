# The archive as a library of PlatformIO, in a folder that has it and the files of its document: its own packer reads
# the manifest, and its own build makes the firmware. Its registry has the builder SCons and the compiler of a chip. In
# their places are SCons of pip and the compiler of this machine, which the stand-ins beside this file name.
set -eu
stand_ins=$CHECKOUT/c-api/tests/platformio
export PLATFORMIO_CORE_DIR="$PWD/core"
mkdir -p core/packages project/src project/include
cp -r "$stand_ins/platform" .
cp -r "$stand_ins/tool-scons" core/packages/
# As PlatformIO notes which package it has installed.
mv core/packages/tool-scons/piopm.json core/packages/tool-scons/.piopm

pack() { "$PYTHON" -m platformio pkg pack bearing-watch > said 2>&1; }
if ! pack; then
    # Without access to the list of licences, the other fields are checked without it.
    grep -q 'Could not load SPDX licenses for validation' said || { cat said; exit 1; }
    cp bearing-watch/library.json library.json
    grep -v '"license"' library.json > bearing-watch/library.json
    pack || { cat said; exit 1; }
    cp library.json bearing-watch/
fi

# The project of the document as a project of PlatformIO has it; data and linker script are read where it runs.
cd bearing-watch/firmware
cp main.c board.c recorded_drive.c rows.s ../../project/src/
cp board.h recorded_drive.h model/model.h ../../project/include/
cp stm32f405.ld model/rows.bin ../../project/
cd ../../project
sed -e "s|^platform = .*|platform = symlink://$PWD/../platform|" -e 's|^board = .*|board = drive|' \
    -e '/^framework = /d' -e "s|^lib_deps = .*|lib_deps = symlink://$PWD/../bearing-watch|" ../platformio.ini > whole.ini
# Without the flags that the library needs, the build must end with an error that names them.
flags=$(grep '^build_flags' whole.ini)
grep -v '^build_flags' whole.ini > platformio.ini
if "$PYTHON" -m platformio run > said 2>&1; then exit 1; fi
grep -q "needs $flags" said || { cat said; exit 1; }
mv whole.ini platformio.ini
"$PYTHON" -m platformio run
