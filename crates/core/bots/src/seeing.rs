//! What a bot sees, sorted by what it does with it.

mod block;
mod memory;
mod scene;
mod search;

pub(crate) use block::{Block, nearest_point};
pub(crate) use memory::Memory;
pub(crate) use scene::{Item, Scene, middle, nearest, size};
pub(crate) use search::Search;
