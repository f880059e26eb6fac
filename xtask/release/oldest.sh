# What the manifests promise of old versions: the crates with the lowest versions of their dependencies.
set -eu
. xtask/release/copy.sh
copy oldest
for own in $PUBLISHED; do
    set -- "$@" "${own#*:}"
    packages="${packages-} --package ${own%%:*}"
done
set_members "$@"
cd "$copied"
rm Cargo.lock
# The option is one of nightly; the variable admits it, and only for this.
RUSTC_BOOTSTRAP=1 cargo generate-lockfile -Z direct-minimal-versions
# shellcheck disable=SC2086
CARGO_TARGET_DIR="$TARGET/oldest/target" cargo check --locked --all-features $packages
