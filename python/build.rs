//! Binds the module's calls of elementary functions to its own.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    // ELF looks a symbol up in the program first, and Python has the `sin` of the system; elsewhere a library's own is
    // taken.
    if std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|system| system == "linux") {
        println!("cargo:rustc-cdylib-link-arg=-Wl,-Bsymbolic-functions");
    }
}
