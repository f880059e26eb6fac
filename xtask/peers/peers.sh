# The workbench and other programs on the same traces: identifies systems with the workbench, numpy, sippy and oxictl.
set -eu
data=$TARGET/peers/data
mkdir -p "$data"
ours() { cargo run --release --quiet --package bearing-watch-workbench --example peers -- "$1" "$data"; }
ours write >&2
ours time > "$TARGET/peers/rust.json"
CARGO_TARGET_DIR=$TARGET/peers/oxictl cargo run --release --quiet --manifest-path xtask/peers/oxictl/Cargo.toml \
    -- "$data" > "$TARGET/peers/oxictl.json"
"$PYTHON" xtask/peers/peers.py "$data" "$TARGET/peers/rust.json" "$TARGET/peers/oxictl.json" ||
    echo "a ratio that is asked for is missed" >&2
