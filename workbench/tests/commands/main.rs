//! Command-line tests, each in its own folder.

mod alarm_commands;
mod audit_command;
mod book;
mod browser;
mod command_line;
mod common;
mod covariate_commands;
mod drive_file_commands;
mod evaluate_commands;
mod features_commands;
mod field_command;
mod format_commands;
mod front_end_commands;
mod grey_box_commands;
mod listen_command;
mod pages;
mod rising_commands;
mod simulate_command;
mod simulate_ema_command;
mod structure_command;
mod tables_command;
mod train_methods;
mod training_worth;
mod validate_command;
mod velocity_commands;
mod view_command;
