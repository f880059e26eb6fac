//! What turns with the rotor: cogging, ripple, unbalance and errors of the resolver, as a table over the angle.
//!
//! Enters: mechanical angle, residual of the torque balance in amperes, velocity. Leaves: [`RotorTable`], the current
//! that belongs to an angle; [`RotorLine`], one whole order of it with its deviation; and [`RotorChange`], what
//! differs from lines that were stored before.
//!
//! ```text
//! x_p = mean of the residual over one pass of a bin                                                        (1)
//! m_b ← m_b + (x_p − m_b)/min(n_b, N)        mean of the bin b, for each direction of motion               (2)
//! v_b = (m_b⁺ + m_b⁻)/2                      friction, which changes its sign with the motion, cancels     (3)
//! C_k = (2/B) Σ v_b e^(−jkθ_b) / sinc(πk/B)  line of order k; a bin averages over its width                (4)
//! σ_k² = S_k/(2B²) Σ (1/n_b⁺ + 1/n_b⁻)       variance of each part of C_k                                  (5)
//! S_k = s²(1 − ρ²)/(1 − 2ρ cos(2πkh/B) + ρ²)                                                               (6)
//! ```
//!
//! Samples of one pass have much the same error, so that a pass counts once. s² is the variance of (1) about the mean
//! of its bin, ρ its correlation with the last pass, h the mean number of bins between them: (6) is the spectrum of a
//! first-order process, which slow disturbances of the residual resemble. A delay τ of the current turns the line by
//! kωτ in one direction and by −kωτ in the other: the phase is kept, the amplitude falls by cos kωτ.
//!
//! The table is not part of the detector's interrupt: whole orders hardly reach those of a bearing (`docs/field.md`
//! has the numbers). A drive that compensates cogging calls [`RotorTable::at`] itself.
//!
//! Cost of a sample: one multiplication of the angle, and two divisions and a root where a bin ends; no loop. State:
//! 12 bytes a bin and 48 bytes. (4) takes a sine a bin, [`RotorChange::between`] 1024 complex products a line: both are
//! for the main loop. `cargo xtask measure` prints the instructions.

mod change;
mod line;
mod map;
mod table;

pub use change::{RotorChange, RotorLimits};
pub use line::RotorLine;
pub use map::{RotorMap, RotorSettings};
pub use table::RotorTable;

#[cfg(test)]
mod tests;
