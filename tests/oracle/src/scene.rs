//! What the oracle is asked: the state at the start of a cycle.

/// The state at the start of a cycle. All numbers are finite.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The objects; others name them by their place in this list.
    pub objects: Vec<Object>,
    /// The walls; others name them by their place in this list.
    pub walls: Vec<Wall>,
    /// How far above touching a colliding circle stops, in world units; zero or more.
    pub skin: f64,
    /// Who stops in a collision.
    pub stops: Stops,
}

/// A circle that goes straight or rests.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Object {
    /// World units.
    pub center: [f64; 2],
    /// World units a cycle; zero at rest.
    pub velocity: [f64; 2],
    /// World units; positive.
    pub radius: f64,
    /// Where it comes to rest within this cycle; `None` where it goes on beyond the end of it, or rests already.
    pub goal: Option<Goal>,
}

/// An arrival.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// Where the centre is from then on, whatever the rounding of the velocity; world units.
    pub point: [f64; 2],
    /// The fraction of the cycle, `0.0..=1.0`.
    pub time: f64,
}

/// A wall, from one point to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wall {
    /// World units.
    pub start: [f64; 2],
    /// World units; differs from `start`.
    pub end: [f64; 2],
}

/// Who stops in a collision.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stops {
    /// Both partners, if they move.
    Both,
    /// Who moves towards the other: `v · d > 0` with its velocity `v` and the offset `d` to the other's centre.
    Approaching,
}

/// What an object collided with. Objects come before walls, and smaller numbers before larger ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Obstacle {
    /// The object of this number.
    Object(usize),
    /// The wall of this number.
    Wall(usize),
}
