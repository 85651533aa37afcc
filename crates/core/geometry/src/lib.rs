//! Circles, segments and time; exact predicates and contact times over them.

mod circle;
mod identity;
pub mod limits;
mod motion;
mod scalar;
mod segment;
mod time;

pub use circle::Circle;
pub use identity::ObjectId;
pub use limits::{Limits, NumberError};
pub use motion::Motion;
pub use scalar::{Planar, Scalar};
pub use segment::Segment;
pub use time::{Cycle, Moment};
