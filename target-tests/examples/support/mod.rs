//! What the programs share, with the support of the firmware examples: see `examples/support/mod.rs`.

#[allow(unused_imports, unused_macros, reason = "not every program classifies")]
#[path = "../../../examples/support/classifier.rs"]
pub mod classifier;
#[allow(dead_code, reason = "not every program counts instructions")]
#[path = "../../../examples/support/count.rs"]
pub mod count;
#[allow(dead_code, reason = "only two programs damage their streams")]
pub mod damage;
#[allow(dead_code, reason = "not every program decimates")]
pub mod decimation;
#[allow(dead_code, reason = "not every program gathers evidence of runs")]
pub mod directed;
#[allow(dead_code, reason = "only `measure` and `measure_front_end` count those of the front end")]
pub mod front_end;
#[allow(dead_code, reason = "only `kernels` compares bits by hashes")]
#[path = "../../../examples/support/hash.rs"]
pub mod hash;
#[allow(dead_code, reason = "not every program has a gate")]
pub mod law;
#[allow(dead_code, reason = "only `measure_signature` has calls that are that long")]
#[cfg(all(target_os = "none", feature = "signature"))]
pub mod long_count;
#[allow(dead_code, reason = "not every program draws numbers")]
#[path = "../../../examples/support/numbers.rs"]
pub mod numbers;
#[allow(dead_code, reason = "not every program measures its stack")]
#[cfg(target_os = "none")]
#[path = "../../../examples/support/paint.rs"]
pub mod paint;
#[macro_use]
#[path = "../../../examples/support/program.rs"]
mod program;
#[allow(dead_code, reason = "not every program has a front end")]
pub mod raw;
#[allow(dead_code, reason = "only two programs damage their streams")]
pub mod raw_damage;
#[allow(dead_code, reason = "not every program estimates by instrumental variables")]
#[path = "../../../examples/support/refined.rs"]
pub mod refined;
#[allow(dead_code, reason = "not every program watches the shaft")]
pub mod shaft;
#[allow(dead_code, reason = "not every program estimates by least squares")]
pub mod squares;
#[cfg(target_os = "none")]
#[path = "../../../examples/support/target.rs"]
pub mod target;
