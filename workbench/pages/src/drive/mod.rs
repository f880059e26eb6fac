//! Pages of what a drive does: its recordings one after another, its runs, the life of its bearing, and it alive.

pub mod life;
pub mod live;
pub mod replay;
mod runs;
