# The table of the field beside that of a plain program in numpy, on the same records; a quarter of an hour a draw.
set -eu
ours=$TARGET/peers/field.json
mkdir -p "$TARGET/peers"
cargo run --release --quiet --package bearing-watch-studies -- campaign --field --json --draws 1 \
    --only mix,temperature,no-load-sensor,slip,duty-one-way,field-any > "$ours"
cargo build --release --quiet --package bearing-watch-studies --example field_records
"$PYTHON" xtask/peers/field.py "$TARGET/release/examples/field_records" "$ours" || echo "the detector is behind in a cell" >&2
