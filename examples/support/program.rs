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

/// Two places for segments, which last as long as the program; `None` if there are none left.
#[allow(unused_macros, reason = "not every example exchanges segments")]
macro_rules! places {
    ($model:expr, $plan:ty) => {{
        #[cfg(target_os = "none")]
        let places = (
            cortex_m::singleton!(: bearing_watch::Segment<$plan> = bearing_watch::Segment::new($model)),
            cortex_m::singleton!(: bearing_watch::Segment<$plan> = bearing_watch::Segment::new($model)),
        );
        #[cfg(not(target_os = "none"))]
        let places = {
            let place = || Some(&mut *Box::leak(Box::new(bearing_watch::Segment::<$plan>::new($model))));
            (place(), place())
        };
        places.0.zip(places.1)
    }};
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
