//! The macro by which `train --rust` declares a `Watch`.

/// Declares a `Watch` as a static; nothing without the feature `watch`. `train --rust` writes it.
#[cfg(all(feature = "watch", target_has_atomic = "8"))]
#[doc(hidden)]
#[macro_export]
macro_rules! watch_static {
    ($(#[$doc:meta])* $vis:vis static $name:ident: $plan:ty $(, $front_end:ty)?;) => {
        $(#[$doc])*
        $vis static $name: $crate::watch::Watch<$plan $(, $front_end)?> = $crate::watch::Watch::new();
    };
}

/// Declares a `Watch` as a static; nothing without the feature `watch`. `train --rust` writes it.
#[cfg(not(all(feature = "watch", target_has_atomic = "8")))]
#[doc(hidden)]
#[macro_export]
macro_rules! watch_static {
    ($($any:tt)*) => {};
}
