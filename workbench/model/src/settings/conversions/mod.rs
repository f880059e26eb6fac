//! From the settings to what is read of recordings, and to the recipe of a training.

mod classifier;
mod life;
mod reading;
mod recipe;
mod shaft;

pub use life::WantedLife;
pub use reading::Reading;
