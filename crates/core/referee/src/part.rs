//! What a cycle of a match spends its time on.

use maniple_game as game;

/// The parts of a cycle of a match, in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The commands of all seats.
    Commands,
    /// A part of the world's cycle.
    World(game::Part),
    /// The delta of each seat.
    Views,
    /// The state hash for the record, and whether the match has ended.
    Result,
}
