//! The words of the command line: commands, options, help, and what is printed.

pub(crate) mod arguments;
pub(crate) mod failure;
pub(crate) mod help;
pub(crate) mod jobs;
pub(crate) mod options;
pub(crate) mod output;
