//! What the examples share: one source that runs on the drive's chip and on the host.
//!
//! An example declares `#[macro_use] mod support;`, ends in `main!(run);` and prints with `say!`.
//! On the host that is a plain `main` and `println!`; on the target it is the reset handler and
//! semihosting, which a debug probe and QEMU both understand. This is a folder without a `main.rs`,
//! so that cargo does not take it for an example of its own.

#[allow(unused_imports, unused_macros, reason = "not every example classifies")]
pub mod classifier;
#[allow(dead_code, reason = "only `measure` counts instructions")]
pub mod count;
#[allow(dead_code, reason = "only two examples damage their streams")]
pub mod damage;
#[allow(dead_code, reason = "not every example decimates")]
pub mod decimation;
#[allow(dead_code, reason = "only `measure` and `measure_front_end` count those of the front end")]
pub mod front_end;
#[allow(dead_code, reason = "only two examples compare bits by hashes")]
pub mod hash;
#[cfg(all(target_os = "none", feature = "signature"))]
#[allow(dead_code, reason = "only `measure_signature` has calls that are that long")]
pub mod long_count;
#[allow(dead_code, reason = "`monitor` has a recording instead")]
pub mod numbers;
#[allow(dead_code, reason = "not every example measures its stack")]
#[cfg(target_os = "none")]
pub mod paint;
#[allow(dead_code, reason = "not every example has a front end")]
pub mod raw;
#[allow(dead_code, reason = "only two examples damage their streams")]
pub mod raw_damage;
#[allow(dead_code, reason = "not every example estimates by instrumental variables")]
pub mod refined;
#[allow(dead_code, reason = "not every example watches the shaft")]
pub mod shaft;
#[allow(dead_code, reason = "not every example estimates by least squares")]
pub mod squares;
#[allow(dead_code, reason = "`logging` prints no text of its own")]
#[cfg(target_os = "none")]
pub mod target;

/// The program's entry: runs the function, and on the target then ends the semihosting session.
macro_rules! main {
    ($run:path) => {
        #[cfg(not(target_os = "none"))]
        fn main() {
            $run();
        }

        #[cfg(target_os = "none")]
        #[cortex_m_rt::entry]
        fn main() -> ! {
            $run();
            $crate::support::target::succeed()
        }
    };
}

/// Prints one line; formats like `println!`.
#[allow(unused_macros, reason = "`logging` prints nothing on the target")]
macro_rules! say {
    ($($words:tt)*) => {{
        #[cfg(not(target_os = "none"))]
        println!($($words)*);
        #[cfg(target_os = "none")]
        $crate::support::target::say(format_args!($($words)*));
    }};
}
