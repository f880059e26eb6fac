//! Records of trained constants, each with one list of its fields.
//!
//! The macro [`record!`] takes the definition of a struct, with the range of each field. From this list it makes what
//! writes the record into a binary model and into the model's identity, what reads it, and what checks it. The binary
//! form has the fields in the order of the list, little-endian, without padding. `bearing-watch train` exports a record
//! as `Debug` prints it, so that a new field needs no other line there either.

mod field;
mod input;
mod output;

pub use field::Field;
pub(crate) use input::{Fault, Input};
pub(crate) use output::Output;

/// Stands for "none" in a byte.
pub(crate) const NONE: u8 = u8::MAX;
/// In place of the channel that a load subtracts, if there is none to subtract from: the load is a weight on an axis.
pub(crate) const WEIGHT: u8 = 0;
/// The largest number below one.
pub(crate) const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;
/// Largest number: its square is far inside the range of f32.
pub(crate) const LARGEST: f32 = 1e18;
/// Longest sampling interval, s.
pub(crate) const LONGEST_S: f32 = 1e4;
/// Least ln of a prior probability, and of the mean of an e-value; no training set supports smaller ones.
pub(crate) const LEAST_LOG: f32 = -100.0;
/// Largest limit and cap of the evidence, nats.
pub(crate) const MOST_NATS: f32 = 1e3;

/// Defines a record: `pub struct NAME: FIELD { … }`, whose [`Field`] names it in a refusal. A field is a number, an
/// array of numbers, another record, or an array of records. It may have the range `in [LEAST, MOST]`, which excludes
/// what is not a number, and a [`Field`] of its own by `or FIELD`.
macro_rules! record {
    (
        $(#[$attribute:meta])*
        $visibility:vis struct $name:ident: $all:ident {
            $($(#[$of_field:meta])* $field_visibility:vis $field:ident: $kind:tt
                $(in [$least:expr, $most:expr])? $(or $what:ident)?,)+
        }
    ) => {
        $(#[$attribute])*
        $visibility struct $name {
            $($(#[$of_field])* $field_visibility $field: $kind,)+
        }

        impl $name {
            /// Appends the fields.
            pub(crate) const fn put(&self, output: &mut $crate::record::Output<'_>) {
                $($crate::record::record!(@put output, self.$field, $kind);)+
            }

            /// The record of the next bytes.
            #[allow(unused, reason = "a record of numbers alone names no field")]
            pub(crate) fn get(input: &mut $crate::record::Input<'_>) -> Self {
                use $crate::record::Field;
                Self { $($field: $crate::record::record!(@get input, $kind, $all $($what)?),)+ }
            }

            /// Compares each field with its range; what is not a number is in none.
            pub(crate) const fn check(&self) -> Result<(), $crate::record::Field> {
                $($crate::record::record!(@check self.$field, $kind, [$($least, $most)?], [$all $($what)?]);)+
                Ok(())
            }
        }
    };

    (@put $output:ident, $value:expr, f32) => { $output.f32($value) };
    (@put $output:ident, $value:expr, u8) => { $output.u8($value) };
    (@put $output:ident, $value:expr, i8) => { $output.u8($value.cast_unsigned()) };
    (@put $output:ident, $value:expr, bool) => { $output.u8($value as u8) };
    (@put $output:ident, $value:expr, u16) => { $output.u16($value) };
    (@put $output:ident, $value:expr, u32) => { $output.u32($value) };
    (@put $output:ident, $value:expr, i32) => { $output.u32($value.cast_unsigned()) };
    (@put $output:ident, $value:expr, [f32; $count:expr]) => { $output.floats(&$value) };
    (@put $output:ident, $value:expr, [$kind:tt; $count:expr]) => {{
        let mut rest: &[$kind] = &$value;
        while let [element, later @ ..] = rest {
            $crate::record::record!(@put $output, (*element), $kind);
            rest = later;
        }
    }};
    (@put $output:ident, $value:expr, $kind:ident) => { $value.put($output) };

    (@get $input:ident, f32, $($what:ident)+) => { $input.f32() };
    (@get $input:ident, u8, $($what:ident)+) => { $input.u8() };
    (@get $input:ident, i8, $($what:ident)+) => { $input.u8().cast_signed() };
    (@get $input:ident, bool, $($what:ident)+) => { $input.flag($crate::record::record!(@what $($what)+)) };
    (@get $input:ident, u16, $($what:ident)+) => { $input.u16() };
    (@get $input:ident, u32, $($what:ident)+) => { $input.u32() };
    (@get $input:ident, i32, $($what:ident)+) => { $input.u32().cast_signed() };
    (@get $input:ident, [$kind:tt; $count:expr], $($what:ident)+) => {
        core::array::from_fn(|_| $crate::record::record!(@get $input, $kind, $($what)+))
    };
    (@get $input:ident, $kind:ident, $($what:ident)+) => { $kind::get($input) };

    (@check $value:expr, $kind:tt, [], $what:tt) => {};
    (@check $value:expr, $kind:tt, [$least:expr, $most:expr], [$($what:ident)+]) => {
        if $crate::record::record!(@within $value, $kind, $least, $most) {
        } else {
            return Err($crate::record::record!(@what $($what)+));
        }
    };

    (@within $value:expr, [$kind:tt; $count:expr], $least:expr, $most:expr) => {{
        let mut rest: &[$kind] = &$value;
        let mut within = true;
        while let [element, later @ ..] = rest {
            within = within && *element >= $least && *element <= $most;
            rest = later;
        }
        within
    }};
    (@within $value:expr, $kind:ident, $least:expr, $most:expr) => { $value >= $least && $value <= $most };

    (@what $all:ident) => { $crate::record::Field::$all };
    (@what $all:ident $what:ident) => { $crate::record::Field::$what };
}
pub(crate) use record;

#[cfg(test)]
mod tests {
    use super::*;

    record! {
        #[derive(Clone, Copy, Debug, PartialEq)]
        struct Inner: Cost {
            weight: f32 in [0.0, BELOW_ONE],
            flag: bool or Label,
        }
    }

    record! {
        #[derive(Clone, Copy, Debug, PartialEq)]
        struct Outer: Evidence {
            small: i8 in [-6, 10],
            count: u16,
            numbers: [f32; 2] in [1.0, f32::INFINITY] or Prior,
            indices: [i32; 2] in [1, 7] or BlockMean,
            inner: [Inner; 2],
        }
    }

    const OUTER: Outer = Outer {
        small: -3,
        count: 0x0102,
        numbers: [1.5, 2.0],
        indices: [1, 7],
        inner: [Inner { weight: 0.25, flag: true }, Inner { weight: 0.0, flag: false }],
    };

    fn bytes(outer: &Outer) -> ([u8; 64], usize) {
        let mut bytes = [0; 64];
        let mut output = Output::new(&mut bytes);
        outer.put(&mut output);
        let length = output.written().unwrap();
        (bytes, length)
    }

    #[test]
    fn fields_are_stored_in_the_order_of_the_list() {
        let (stored, length) = bytes(&OUTER);
        let mut expected = std::vec![0xFD, 2, 1];
        [1.5_f32, 2.0].iter().for_each(|x| expected.extend(x.to_le_bytes()));
        [1_i32, 7].iter().for_each(|x| expected.extend(x.to_le_bytes()));
        expected.extend(0.25_f32.to_le_bytes());
        expected.push(1);
        expected.extend([0; 5]);
        assert_eq!(stored[..length], expected);
        let mut input = Input::new(&stored[..length]);
        assert_eq!((Outer::get(&mut input), input.finish()), (OUTER, Ok(())));
        let mut short = Input::new(&stored[..length - 1]);
        let _zeros = Outer::get(&mut short);
        assert_eq!(short.finish(), Err(Fault::Truncated));
        let mut long = Input::new(&stored[..=length]);
        let _first = Outer::get(&mut long);
        assert_eq!(long.finish(), Err(Fault::Truncated));
    }

    #[test]
    fn a_field_out_of_its_range_is_named() {
        assert_eq!(OUTER.check(), Ok(()));
        assert_eq!(Outer { small: -7, ..OUTER }.check(), Err(Field::Evidence));
        assert_eq!(Outer { numbers: [1.0, f32::NAN], ..OUTER }.check(), Err(Field::Prior));
        assert_eq!(Outer { numbers: [1.0, f32::INFINITY], ..OUTER }.check(), Ok(()));
        assert_eq!(Outer { indices: [8, 1], ..OUTER }.check(), Err(Field::BlockMean));
        let of = |weight| Inner { weight, flag: false }.check();
        assert_eq!([0.99, 1.0, -0.1, f32::NAN].map(|weight| of(weight).is_ok()), [true, false, false, false]);
        let (mut stored, length) = bytes(&OUTER);
        stored[length - 1] = 2;
        let mut input = Input::new(&stored[..length]);
        let _outer = Outer::get(&mut input);
        assert_eq!(input.finish(), Err(Fault::OutOfRange(Field::Label)));
        // The first fault tells the cause: behind it the bytes have no meaning.
        let mut short = Input::new(&stored[..length]);
        let _outer = Outer::get(&mut short);
        let _beyond = Outer::get(&mut short);
        assert_eq!(short.finish(), Err(Fault::OutOfRange(Field::Label)));
    }

    #[test]
    fn every_number_changes_the_identity() {
        let identity = |outer: Outer| {
            let mut output = Output::new(&mut []);
            outer.put(&mut output);
            output.identity()
        };
        let others = [
            Outer { small: -2, ..OUTER },
            Outer { count: 0x0103, ..OUTER },
            Outer { numbers: [2.0, 1.5], ..OUTER },
            Outer { indices: [1, 6], ..OUTER },
            Outer { inner: [OUTER.inner[0]; 2], ..OUTER },
        ];
        assert!(others.iter().all(|other| identity(*other) != identity(OUTER)));
    }
}
