//! What a cycle of a world spends its time on.

use maniple_kinematics as kinematics;

/// The parts of a cycle of a world, in their order. What a scenario does not ask for has no part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// What units have been told to do: where they go next, and at whom they fire.
    Tasks,
    /// A part of the motion of everybody.
    Kinematics(kinematics::Part),
    /// What was worked and hit, who dies, what the match is about, and the state hash.
    Rules,
    /// Who is where, for the views.
    Sightings,
    /// Who sees whom; only under fog.
    Vision,
}
