# The archive as a component of ESP-IDF, packed by its component manager and built with stand-ins of its functions.
set -eu
(cd bearing-watch && "$(dirname "$PYTHON")/compote" component pack --name bearing-watch --dest-dir ../dist)
# The folder of the C library, below that of `--picolibc-prefix`.
picolibc=/usr/lib/picolibc/riscv64-unknown-elf
[ ! -d "$DEBIAN/riscv$picolibc" ] || picolibc=$DEBIAN/riscv$picolibc
cmake -S "$CHECKOUT/c-api/tests/riscv" -B build "-DARCHIVE=$PWD/bearing-watch" "-DPICOLIBC=$picolibc"
cmake --build build
