//! One face of the settings over another one.

/// A value that is given or not.
pub(crate) trait Given {
    /// This value if it is given, or else the other one.
    fn or_given(self, base: Self) -> Self;
}

impl<T> Given for Option<T> {
    fn or_given(self, base: Self) -> Self {
        self.or(base)
    }
}

impl<T> Given for Vec<T> {
    fn or_given(self, base: Self) -> Self {
        if self.is_empty() { base } else { self }
    }
}

impl Given for bool {
    fn or_given(self, base: Self) -> Self {
        self || base
    }
}

/// Merges the sections of settings field by field; the compiler refuses a list that lacks one.
macro_rules! merges {
    ($section:ident { $($field:ident),+ $(,)? }) => {
        impl $crate::settings::sections::merge::Given for $section {
            fn or_given(self, base: Self) -> Self {
                Self { $($field: self.$field.or_given(base.$field)),+ }
            }
        }
    };
}
pub(crate) use merges;
