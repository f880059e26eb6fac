//! The code of the book's chapters, as documentation tests.

#[doc = include_str!("../book/src/firmware.md")]
struct Firmware;
#[doc = include_str!("../book/src/mathematics.md")]
struct Mathematics;
#[doc = include_str!("../book/src/target.md")]
struct Target;
#[doc = include_str!("../book/src/faults.md")]
struct Faults;
