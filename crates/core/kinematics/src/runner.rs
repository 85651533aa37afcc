//! An object in the cycle that is being solved.

use maniple_geometry::{Cycle, ObjectId, Piece, Planar, Scalar};

use crate::event::EventKind;
use crate::track::Stage;
use crate::wall::Layers;

/// Why and beside whom an object was stopped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Halt {
    pub(crate) kind: EventKind,
    pub(crate) other: Option<ObjectId>,
}

impl Halt {
    /// Returns the reason where two coincide: an object comes before a wall, a wall before the edge, the smaller id
    /// before the larger.
    pub(crate) fn merged(self, other: Self) -> Self {
        match self.kind.cmp(&other.kind) {
            std::cmp::Ordering::Less => self,
            std::cmp::Ordering::Greater => other,
            std::cmp::Ordering::Equal => {
                if other.other < self.other {
                    other
                } else {
                    self
                }
            }
        }
    }
}

/// An object in the cycle that is being solved: its track, and how far it follows it.
#[derive(Clone, Debug)]
pub(crate) struct Runner<S: Scalar> {
    /// The place of the object in the world's arrays.
    pub(crate) slot: usize,
    pub(crate) id: ObjectId,
    pub(crate) radius: S,
    pub(crate) layers: Layers,
    pub(crate) stages: Vec<Stage<S>>,
    /// Until when the object follows its track; 1 unless it was stopped or pulled back.
    pub(crate) end: S,
    /// Where it is from then on, if it does not follow its track to the end.
    pub(crate) held: Option<S::Vector>,
    pub(crate) halt: Option<Halt>,
    /// How often it was pulled back.
    pub(crate) retreats: u32,
}

impl<S: Scalar> Runner<S> {
    pub(crate) fn new(
        slot: usize,
        id: ObjectId,
        (radius, layers): (S, Layers),
        stages: Vec<Stage<S>>,
    ) -> Self {
        Self { slot, id, radius, layers, stages, end: S::ONE, held: None, halt: None, retreats: 0 }
    }

    /// Stops the object at a time, at the rounded point of its track.
    pub(crate) fn stop(&mut self, time: S, halt: Halt) {
        assert!(self.halt.is_none(), "an object collides at most once a cycle");
        self.held = Some(self.stage_at(time).piece.position(time));
        self.end = time;
        self.halt = Some(halt);
    }

    /// Pulls the object back along its track by a step that doubles each time, at the latest to where it was at the
    /// start of the cycle.
    ///
    /// # Panics
    /// Where it is there already.
    pub(crate) fn retreat(&mut self) {
        assert!(self.can_retreat(), "an object at its start cannot be pulled back");
        let base = if self.retreats == 0 && self.halt.is_none() { self.rest_begins() } else { self.end };
        let step = (0..self.retreats).fold(S::from_f64(4.0) * S::ROUNDOFF, |step, _| step + step);
        self.retreats += 1;
        let end = (base - step).greater(S::ZERO).flushed();
        let stage = self.stage_at(end);
        self.held = Some(stage.piece.position(end));
        self.end = end;
    }

    /// Returns whether the object is not where it was at the start of the cycle.
    pub(crate) fn can_retreat(&self) -> bool {
        self.end > S::ZERO && self.stages.iter().any(|stage| stage.piece.is_moving())
    }

    /// Returns whether the object moves at a time, the instant of a stop or arrival excluded.
    pub(crate) fn is_moving(&self, time: S) -> bool {
        self.live(time).is_moving()
    }

    /// Returns the piece that the object is on from a time on.
    pub(crate) fn live(&self, time: S) -> Piece<S> {
        match self.held {
            Some(point) if time >= self.end => Piece::at_rest(point, self.end, S::ONE),
            Some(_) | None => self.stage_at(time).piece,
        }
    }

    /// Returns the pieces that the object passes from a time on.
    pub(crate) fn pieces_from(&self, time: S) -> impl Iterator<Item = Piece<S>> + '_ {
        let held = self.held.map(|point| Piece::at_rest(point, self.end, S::ONE));
        let end = if held.is_some() { self.end } else { S::ONE };
        let passed = self
            .stages
            .iter()
            .map(|stage| stage.piece)
            .filter(move |piece| piece.until > time && piece.since < end);
        let clipped = passed.map(move |piece| clip(piece, end));
        clipped.chain(held)
    }

    /// Returns where the object is at the end of the cycle.
    pub(crate) fn final_position(&self, cycle: Cycle) -> S::Vector {
        match self.held {
            Some(point) => point,
            None => self.last().motion.position(cycle.next()).flushed(),
        }
    }

    /// Returns the stage that holds at a time: the last that has begun.
    pub(crate) fn stage_at(&self, time: S) -> &Stage<S> {
        let begun = self.stages.partition_point(|stage| stage.piece.since <= time);
        &self.stages[begun.saturating_sub(1)]
    }

    fn last(&self) -> &Stage<S> {
        &self.stages[self.stages.len() - 1]
    }

    /// When the object has come to rest for the remainder of the cycle.
    fn rest_begins(&self) -> S {
        let moving = self.stages.iter().rev().find(|stage| stage.piece.is_moving());
        moving.map_or(S::ZERO, |stage| stage.piece.until)
    }
}

/// A piece whose end was cut off loses its goal.
fn clip<S: Scalar>(piece: Piece<S>, end: S) -> Piece<S> {
    if piece.until <= end { piece } else { Piece { until: end, goal: None, ..piece } }
}
