//! Lets the linker find the memory map at the top of the repository, and the names of the interrupts here.

fn main() {
    let package = env!("CARGO_MANIFEST_DIR");
    println!("cargo::rustc-link-search={package}/../..");
    println!("cargo::rustc-link-search={package}/..");
    println!("cargo::rerun-if-changed=../build.rs");
    println!("cargo::rerun-if-changed=../../memory.x");
}
