//! The one test suite of the workspace. It is a target of the package of the command, so that cargo builds the binary
//! that it runs.

mod architecture;
mod kinematics;
mod maps;
mod predicates;
mod protocol;
