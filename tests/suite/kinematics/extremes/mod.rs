//! Adversarial scenes: one generator, one test and one count for each class of what is hard for rounded numbers.
//!
//! Every class is played by [`tally::Tally`], which looks at all pairs at and between the stored states in rational
//! arithmetic (`ways.rs`), and prints a line of the table of results. `MANIPLE_LONG=1` plays more.

mod border;
mod chains;
mod patrol;
mod scales;
mod site;
mod tally;
mod touches;
mod walls;
mod ways;
