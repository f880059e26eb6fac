//! The entry of a program, and its printer.

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
