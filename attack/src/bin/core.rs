//! Attacks a door of `core`, or replays files.
#![cfg_attr(attack_coverage, no_main)]

attack::program!(attack::core::DOORS);
