//! What the examples share: one source that runs on the drive's chip and on the host.
//!
//! An example declares `#[macro_use] mod support;`, ends in `main!(run);` and prints with `say!`.
//! On the host that is a plain `main` and `println!`; on the target it is the reset handler and
//! semihosting, which a debug probe and QEMU both understand. This is a folder without a `main.rs`,
//! so that cargo does not take it for an example of its own.

#[allow(unused_imports, unused_macros, reason = "not every example classifies")]
pub mod classifier;
#[allow(dead_code, reason = "only `drive` counts instructions")]
pub mod count;
#[allow(dead_code, reason = "only two examples compare bits by hashes")]
pub mod hash;
#[allow(dead_code, reason = "`monitor` has a recording instead")]
pub mod numbers;
#[allow(dead_code, reason = "only `drive` measures its stack")]
#[cfg(target_os = "none")]
pub mod paint;
#[macro_use]
mod program;
#[allow(dead_code, reason = "not every example estimates by instrumental variables")]
pub mod refined;
#[allow(dead_code, reason = "`logging` prints no text of its own")]
#[cfg(target_os = "none")]
pub mod target;
