//! The `bearing-watch` command.

fn main() -> std::process::ExitCode {
    workbench::cli::run()
}
