# Records the drive into the folder FOLDER, describes the recordings and trains, as its engineers would do it: leaves
# model.rs. WORKBENCH is the command line.
set -eu
rm -rf "$FOLDER"
# Seconds of a record, and records of each class.
cargo run --quiet --release --package drive-foc --example record -- "$FOLDER" 4 40
cd "$FOLDER"
"$WORKBENCH" --quiet init --front-end .
# What no recording tells: amperes a count by the data sheet, and the bearing by its number (608).
sed -i 's|gain_a = \[1.000000e0, 1.000000e0\]|gain_a = [0.01, 0.01]|' front_end.toml
sed -i 's|# bearing = \[9, 3, 17, 10\]|bearing = [7, 3.97, 15, 0]|' drive.toml
grep -qF 'gain_a = [0.01, 0.01]' front_end.toml
grep -q '^bearing = ' drive.toml
"$WORKBENCH" --quiet train drive.toml --model out.bwm --rust model.rs
