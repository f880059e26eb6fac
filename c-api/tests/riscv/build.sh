# The archive as a component of ESP-IDF, packed by its component manager and built with stand-ins of its functions.
set -eu
(cd bearing-watch && "$(dirname "$PYTHON")/compote" component pack --name bearing-watch --dest-dir ../dist)
cmake -S "$CHECKOUT/c-api/tests/riscv" -B build "-DARCHIVE=$PWD/bearing-watch" "-DPICOLIBC=$PICOLIBC"
cmake --build build
