# The Python package: a source distribution, the wheel that is built from it alone, and its way into an empty
# environment, where a detector must have the verdicts of the command line on simulated traces of a good and of a bad
# bearing.
set -eu
trap 'rm -rf "$FOLDER"' EXIT
rm -f "$DIST"/bearing_watch-*
(cd python && "$TOOL" sdist --out "$DIST")
# FOLDER is outside the checkout, whose configuration cargo would read.
tar xf "$DIST"/bearing_watch-*.tar.gz --strip-components 1 -C "$FOLDER"
# Not `--locked`: the distribution has the lock file of the whole workspace, of which cargo keeps what is wanted.
(cd "$FOLDER" && CARGO_TARGET_DIR="$TARGET/release-wheel" "$TOOL" build --release --strip --out "$DIST")
"$PYTHON" -m pip install --quiet --disable-pip-version-check "$DIST"/bearing_watch-*.whl
model=$PWD/examples/support/standard_rig/model.bwm program=$PWD/xtask/release/wheel.py
cd "$FOLDER"
for class in healthy spall; do
    "$WORKBENCH" simulate --rig dc --count 1 --seed 7 --class $class --out $class
    trace=$(find $class -name '*.csv' ! -name labels.csv)
    "$WORKBENCH" replay --json --model "$model" "$trace" | "$PYTHON" -c "import json, sys
print(*(segment['verdict'] for segment in json.load(sys.stdin)), sep='\n')" > host
    "$PYTHON" "$program" "$model" "$trace" > own
    cat own
    cmp host own
    grep -q -v undetermined own
done
