//! Lets the linker find the memory map at the top of the repository, and the list of the tests.

fn main() {
    let package = env!("CARGO_MANIFEST_DIR");
    println!("cargo::rustc-link-search={package}/../..");
    println!("cargo::rustc-link-arg-tests=-Tembedded-test.x");
    println!("cargo::rustc-check-cfg=cfg(rust_analyzer)");
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=../../memory.x");
}
