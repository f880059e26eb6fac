//! The code of the book's chapters, as documentation tests.

#[doc = include_str!("../book/src/drive-engineer.md")]
struct DriveEngineer;
#[doc = include_str!("../book/src/firmware.md")]
struct Firmware;
#[doc = include_str!("../book/src/mathematics.md")]
struct Mathematics;
#[doc = include_str!("../book/src/porting.md")]
struct Porting;
#[doc = include_str!("../book/src/commissioning.md")]
struct Commissioning;
#[doc = include_str!("../book/src/faults.md")]
struct Faults;
#[doc = include_str!("../book/src/retraining.md")]
struct Retraining;
