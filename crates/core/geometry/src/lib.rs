//! Circles, segments and time; exact predicates and contact times over them.

mod circle;
pub mod limits;
mod scalar;
mod segment;
mod time;

pub use circle::Circle;
pub use limits::{Limits, NumberError};
pub use scalar::{Planar, Scalar};
pub use segment::Segment;
pub use time::{Cycle, Moment};
