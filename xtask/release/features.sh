# Combinations of the core's features, by cargo-hack: none, each, and each pair. All features together are a check of
# `cargo xtask test`. In a copy whose workspace has the core alone: cargo-hack leaves the choice of the package to
# cargo, which would take the default members of the workspace, and with them features that they want.
set -eu
. xtask/release/copy.sh
copy features
set_members
cd "$copied"
"$TOOL" hack check --lib --feature-powerset --depth 2 "$@"
