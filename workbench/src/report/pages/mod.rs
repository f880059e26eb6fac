//! The pages: each function converts the results of a command to sections or a whole page.

pub mod audit;
pub mod campaign;
pub mod demo;
pub mod evaluation;
pub mod live;
pub mod model;
pub mod replay;
pub mod segments;
pub mod structure;
pub mod tables;
pub mod validation;
pub mod worth;
