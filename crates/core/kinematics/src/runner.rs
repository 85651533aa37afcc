//! An object in the cycle that is being solved.

use maniple_geometry::contact::Straight;
use maniple_geometry::{ObjectId, Piece, Planar, Scalar};

use crate::event::EventKind;
use crate::track::Stage;

/// Why and beside whom an object was stopped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Halt {
    pub(crate) kind: EventKind,
    pub(crate) other: Option<ObjectId>,
    /// Whether there were others at the same time.
    pub(crate) is_one_of_several: bool,
}

impl Halt {
    /// Returns the stop beside an object.
    pub(crate) fn beside(other: ObjectId) -> Self {
        Self { kind: EventKind::Object, other: Some(other), is_one_of_several: false }
    }

    /// Returns the stop at a wall.
    pub(crate) fn at_wall(kind: EventKind) -> Self {
        Self { kind, other: None, is_one_of_several: false }
    }

    /// Returns the reason where two coincide: an object comes before a wall, a wall before the edge, the smaller id
    /// before the larger.
    pub(crate) fn merged(self, other: Self) -> Self {
        match self.kind.cmp(&other.kind) {
            std::cmp::Ordering::Less => self,
            std::cmp::Ordering::Greater => other,
            std::cmp::Ordering::Equal => Self {
                kind: self.kind,
                other: self.other.min(other.other),
                is_one_of_several: self.is_one_of_several
                    || other.is_one_of_several
                    || self.other != other.other,
            },
        }
    }
}

/// The way that an object would go through the cycle if nothing were in it.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Track<S: Scalar> {
    /// One piece from 0 to 1, of a motion that goes on.
    Straight {
        /// Where the object is at 0.
        point: S::Vector,
        velocity: S::Vector,
    },
    /// Stages of the arena, from one place to another.
    Turning(u32, u32),
}

/// An object in the cycle that is being solved: its track, and how far it follows it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Runner<S: Scalar> {
    /// The place of the object in the world's arrays.
    pub(crate) slot: u32,
    pub(crate) id: ObjectId,
    pub(crate) radius: S,
    pub(crate) track: Track<S>,
    /// Where it will be at the end of the cycle.
    pub(crate) last: S::Vector,
    /// Until when the object follows its track; 1 unless it was stopped or pulled back.
    pub(crate) end: S,
    /// Whether it stays at `last` from `end` on, since it does not follow its track to the end.
    pub(crate) is_held: bool,
    pub(crate) halt: Option<Halt>,
    /// How often it was pulled back.
    pub(crate) retreats: u32,
    /// Whether its track ends so near to something at rest that the certificate has to ask.
    pub(crate) ends_near: bool,
}

impl<S: Scalar> Runner<S> {
    /// Stops the object at a time, at the rounded point of its track.
    pub(crate) fn stop(&mut self, time: S, halt: Halt, arena: &[Stage<S>]) {
        assert!(self.halt.is_none(), "an object collides at most once a cycle");
        self.last = self.position(time, arena);
        self.is_held = true;
        self.end = time;
        self.halt = Some(halt);
    }

    /// Pulls the object back along its track by a step that doubles each time, at the latest to where it was at the
    /// start of the cycle.
    ///
    /// # Panics
    /// Where it is there already.
    pub(crate) fn retreat(&mut self, arena: &[Stage<S>]) {
        assert!(self.can_retreat(arena), "an object at its start cannot be pulled back");
        let base = if self.retreats == 0 && self.halt.is_none() { self.rest_begins(arena) } else { self.end };
        let step = (0..self.retreats).fold(S::from_f64(4.0) * S::ROUNDOFF, |step, _| step + step);
        self.retreats += 1;
        let end = (base - step).greater(S::ZERO).flushed();
        self.last = self.position(end, arena);
        self.is_held = true;
        self.end = end;
    }

    /// Returns whether the object is not where it was at the start of the cycle.
    pub(crate) fn can_retreat(&self, arena: &[Stage<S>]) -> bool {
        self.end > S::ZERO && self.rest_begins(arena) > S::ZERO
    }

    /// Returns whether the object moves at a time, the instant of a stop or arrival excluded.
    pub(crate) fn is_moving(&self, time: S, arena: &[Stage<S>]) -> bool {
        if self.is_held && time >= self.end {
            return false;
        }
        match self.track {
            Track::Straight { velocity, .. } => velocity != S::Vector::zero(),
            Track::Turning(..) => self.piece_at(time, arena).is_moving(),
        }
    }

    /// Returns the piece that the object is on from a time on.
    pub(crate) fn live(&self, time: S, arena: &[Stage<S>]) -> Piece<S> {
        if self.is_held && time >= self.end {
            Piece::at_rest(self.last, self.end, S::ONE)
        } else {
            self.piece_at(time, arena)
        }
    }

    /// Returns the pieces that the object passes from a time on.
    pub(crate) fn pieces_from<'a>(&self, time: S, arena: &'a [Stage<S>]) -> Pieces<'a, S> {
        let end = if self.is_held { self.end } else { S::ONE };
        let held = self.is_held.then(|| Piece::at_rest(self.last, self.end, S::ONE));
        match self.track {
            Track::Straight { point, velocity } => {
                Pieces { time, end, straight: Some(straight(point, velocity)), stages: &[], held }
            }
            Track::Turning(..) => Pieces { time, end, straight: None, stages: self.stages(arena), held },
        }
    }

    /// Returns the velocity of the motion that the object is on at a time.
    pub(crate) fn velocity_at(&self, time: S, arena: &[Stage<S>]) -> S::Vector {
        match self.track {
            Track::Straight { velocity, .. } => velocity,
            Track::Turning(..) => stage_at(self.stages(arena), time).motion.velocity,
        }
    }

    /// Returns the object at rest where it has been stopped.
    pub(crate) fn held(&self) -> Straight<S> {
        Straight { point: self.last, velocity: S::Vector::zero(), radius: self.radius }
    }

    /// Returns the stages of a track that turns.
    pub(crate) fn stages<'a>(&self, arena: &'a [Stage<S>]) -> &'a [Stage<S>] {
        match self.track {
            Track::Straight { .. } => &[],
            Track::Turning(from, to) => &arena[from as usize..to as usize],
        }
    }

    /// Returns where the object is at a time, rounded.
    pub(crate) fn place(&self, time: S, arena: &[Stage<S>]) -> S::Vector {
        if self.is_held && time >= self.end { self.last } else { self.position(time, arena) }
    }

    /// Returns where the track is at a time, rounded.
    fn position(&self, time: S, arena: &[Stage<S>]) -> S::Vector {
        self.piece_at(time, arena).position(time)
    }

    fn piece_at(&self, time: S, arena: &[Stage<S>]) -> Piece<S> {
        match self.track {
            Track::Straight { point, velocity } => straight(point, velocity),
            Track::Turning(..) => stage_at(self.stages(arena), time).piece,
        }
    }

    /// When the object has come to rest for the remainder of the cycle.
    fn rest_begins(&self, arena: &[Stage<S>]) -> S {
        match self.track {
            Track::Straight { .. } => S::ONE,
            Track::Turning(..) => {
                let moving = self.stages(arena).iter().rev().find(|stage| stage.piece.is_moving());
                moving.map_or(S::ZERO, |stage| stage.piece.until)
            }
        }
    }
}

/// The pieces that an object passes, in the order of time.
#[derive(Clone, Debug)]
pub(crate) struct Pieces<'a, S: Scalar> {
    time: S,
    /// When the object stops to follow its track.
    end: S,
    straight: Option<Piece<S>>,
    stages: &'a [Stage<S>],
    held: Option<Piece<S>>,
}

impl<S: Scalar> Iterator for Pieces<'_, S> {
    type Item = Piece<S>;

    fn next(&mut self) -> Option<Piece<S>> {
        loop {
            let piece = match self.straight.take() {
                Some(piece) => piece,
                None => match self.stages.split_first() {
                    Some((stage, rest)) => {
                        self.stages = rest;
                        stage.piece
                    }
                    None => return self.held.take(),
                },
            };
            if piece.until > self.time && piece.since < self.end {
                return Some(clip(piece, self.end));
            }
        }
    }
}

/// Returns the stage that holds at a time: the last that has begun.
pub(crate) fn stage_at<S: Scalar>(stages: &[Stage<S>], time: S) -> &Stage<S> {
    let begun = stages.partition_point(|stage| stage.piece.since <= time);
    &stages[begun.saturating_sub(1)]
}

/// Returns the piece of a motion that goes on for the whole cycle, from the point where the object is at its start.
#[inline]
pub(crate) fn straight<S: Scalar>(point: S::Vector, velocity: S::Vector) -> Piece<S> {
    Piece { point, velocity, since: S::ZERO, until: S::ONE, goal: None }
}

/// A piece whose end was cut off loses its goal.
fn clip<S: Scalar>(piece: Piece<S>, end: S) -> Piece<S> {
    if piece.until <= end { piece } else { Piece { until: end, goal: None, ..piece } }
}
