//! Trainings on sets of the rig, through the public interface of the models.

mod default_recipe;
mod missing_features;
mod shaft_choices;
