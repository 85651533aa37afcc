//! The one test suite of the workspace. It is a target of the package of the command, so that cargo builds the binary
//! that it runs.

#![expect(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

mod architecture;
mod arena;
mod bench;
mod bots;
mod clients;
mod commands;
mod configuration;
mod conformance;
mod crash;
mod faults;
mod fog;
mod fuzzing;
mod generate;
mod heavy;
mod journal;
mod kinematics;
mod lobby;
mod maps;
mod matches;
mod mirror;
mod network;
mod operation;
mod operations;
mod orts;
mod packed;
mod pause;
mod predicates;
mod profile;
mod protocol;
mod rational;
mod readme;
mod secrecy;
mod show;
mod simulate;
mod slow;
mod spectators;
mod tournament;
mod transcripts;
