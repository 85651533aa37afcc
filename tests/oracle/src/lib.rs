//! The oracle: one cycle of circles on straight lines, solved apart from the core.
//!
//! It shares no line of code with what it judges. All pairs, no sectors, no components, one list of contacts. Every
//! number that is given is a double and is taken as it is; from there on all is rational and without rounding, but for
//! the time of a collision, which is a root and has [`PRECISION`] bits. So whether there is a collision is decided
//! exactly, and where somebody stops is exact for a time that is good to 200 bits.
//!
//! The rules are those of `docs/KINEMATICS.md`: a circle collides if it would come nearer than touching; it stops a skin
//! above touching, and at once where it is within two skins already.
//!
//! [`solve`] starts from the state of another solver at the start of a cycle, and [`judge`] says what that solver made of
//! the cycle. Whole runs cannot be compared, since near ties make them part lawfully.
//!
//! ```
//! use maniple_oracle::{Ending, Object, Obstacle, Scene, Stops, rounded, solve};
//!
//! let object = |x, speed| Object { center: [x, 0.0], velocity: [speed, 0.0], radius: 0.5, goal: None };
//! let objects = vec![object(0.0, 1.0), object(2.0, -1.0)];
//! let scene = Scene { objects, walls: Vec::new(), skin: 0.125, stops: Stops::Both };
//! let solution = solve(&scene);
//! assert_eq!(solution.outcomes[0].ending, Ending::Stopped(Obstacle::Object(1)));
//! assert_eq!(rounded(&solution.outcomes[0].time), 0.4375);
//! ```

mod exact;
mod judge;
mod scene;
mod solve;
mod track;

pub use exact::{Exact, PRECISION, Vector, rounded};
pub use judge::{Actual, Verdict, judge};
pub use scene::{Goal, Object, Obstacle, Scene, Stops, Wall};
pub use solve::{Ending, Outcome, Solution, solve};
