//! The `bearing-watch` command.

/// Columns of recordings are megabytes, whose pages the system's allocator returns and asks for again and again.
#[cfg(not(target_family = "wasm"))]
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> std::process::ExitCode {
    workbench::run()
}
