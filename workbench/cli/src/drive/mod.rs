//! `init`: from recordings to a drive file.

pub(super) mod asked;
mod found;
pub(super) mod guess;
pub(super) mod init;
mod names;
mod proposal;
mod values;
