# The packages for crates.io. Cargo builds each from what is in its package and, for those that are not published yet,
# from the packages of the others.
set -eu
rm -f "$DIST"/*.crate
# As in the workspace's profile, which packages do not have: dependencies that are built already are used.
export CARGO_PROFILE_DEV_DEBUG=false CARGO_PROFILE_DEV_LTO=off
for own in $PUBLISHED; do set -- "$@" --package "${own%%:*}"; done
env -u CARGO_TARGET_DIR cargo package --locked --allow-dirty --target-dir "$TARGET" "$@"
for own in $PUBLISHED; do cp "$TARGET/package/${own%%:*}-$VERSION.crate" "$DIST"; done
