//! Attacks a door of `readers`, or replays files.
#![cfg_attr(attack_coverage, no_main)]

attack::program!(attack::readers::DOORS);
