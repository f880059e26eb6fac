# What the manifests promise of old versions: the crates by the lowest version of the compiler, RUST_VERSION. Its
# toolchain is looked for in the file system, because rustup's own commands may start to download.
set -eu
for folder in "${RUSTUP_HOME:-$HOME/.rustup}/toolchains/$RUST_VERSION"*; do toolchain=$folder; done
if [ ! -d "$toolchain" ]; then
    echo "not installed: rustup toolchain install $RUST_VERSION --profile minimal"
    exit 77
fi
for own in $PUBLISHED; do set -- "$@" --package "${own%%:*}"; done
export RUSTC="$toolchain/bin/rustc" CARGO_TARGET_DIR="$TARGET/oldest/compiler"
unset RUSTUP_TOOLCHAIN LD_LIBRARY_PATH
exec "$toolchain/bin/cargo" check --locked --all-features "$@"
