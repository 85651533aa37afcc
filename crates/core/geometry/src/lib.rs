//! Circles, segments and time; exact predicates and contact times over them.

mod circle;
pub mod contact;
mod exact;
mod identity;
pub mod limits;
mod motion;
mod piece;
pub mod predicate;
mod scalar;
mod segment;
mod time;

pub use circle::Circle;
pub use identity::ObjectId;
pub use limits::{Limits, NumberError};
pub use motion::Motion;
pub use piece::Piece;
pub use scalar::{Planar, Scalar};
pub use segment::Segment;
pub use time::{Cycle, Moment};
