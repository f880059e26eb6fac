# Reads a recording of a million rows with the workbench, pandas and pyarrow.
set -eu
mkdir -p "$TARGET/peers/data"
cargo build --release --quiet --package bearing-watch-workbench --example reading
"$PYTHON" xtask/peers/reading.py "$TARGET/peers/data" "$TARGET/release/examples/reading" ||
    echo "a ratio that is asked for is missed" >&2
