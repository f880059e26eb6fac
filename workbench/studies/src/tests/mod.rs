//! Trainings on sets of the rig, through the public interface of the models.

mod default_recipe;
mod filters;
mod harmonics;
mod missing_features;
mod velocity_source;
