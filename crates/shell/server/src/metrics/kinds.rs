//! Counts by kind.

use std::marker::PhantomData;
use std::sync::atomic::{AtomicU64, Ordering};

use maniple_protocol::Refused;
use maniple_view::{Outcome, Refusal};

use super::Labelled;

/// Room for the kinds of anything that is counted here.
const KINDS_MAX: usize = 32;

/// How many there were of each kind of a thing.
#[derive(Debug)]
pub struct Kinds<T> {
    /// By the place of the kind in [`Kind::ALL`].
    counts: [AtomicU64; KINDS_MAX],
    thing: PhantomData<fn(T)>,
}

/// A thing that comes in kinds.
pub trait Kind {
    /// The names of the kinds, each once.
    const ALL: &'static [&'static str];

    /// Returns the name of its kind.
    fn kind(&self) -> &'static str;
}

/// How a match ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// Somebody won.
    Won,
    /// Nobody won.
    Drawn,
    /// It was broken off: by the administration, or because the daemon went down.
    BrokenOff,
    /// By a mistake of this program; it has a report.
    Failed,
}

impl<T> Default for Kinds<T> {
    fn default() -> Self {
        Self { counts: [const { AtomicU64::new(0) }; KINDS_MAX], thing: PhantomData }
    }
}

impl<T: Kind> Kinds<T> {
    /// Counts one.
    pub fn count(&self, thing: &T) {
        let place = T::ALL.iter().position(|kind| *kind == thing.kind());
        self.counts[place.expect("every kind is among all")].fetch_add(1, Ordering::Relaxed);
    }
}

impl<T: Kind + std::fmt::Debug> Labelled for Kinds<T> {
    fn counts(&self) -> Vec<(&'static str, u64)> {
        let counts = self.counts.iter().map(|count| count.load(Ordering::Relaxed));
        T::ALL.iter().copied().zip(counts).collect()
    }
}

impl Kind for End {
    const ALL: &'static [&'static str] = &["won", "drawn", "broken_off", "failed"];

    fn kind(&self) -> &'static str {
        match self {
            Self::Won => "won",
            Self::Drawn => "drawn",
            Self::BrokenOff => "broken_off",
            Self::Failed => "failed",
        }
    }
}

impl Kind for Refused {
    const ALL: &'static [&'static str] = &[
        "protocol",
        "handshake",
        "timeout",
        "name_too_long",
        "token",
        "full",
        "replaced",
        "malformed",
        "too_large",
        "too_slow",
        "shutdown",
        "no_spectators",
        "seats_only",
        "no_such_seat",
        "spectators_full",
        "spectator",
        "held_too_much",
        "broken",
        "no_match",
        "no_scenario",
        "matches_full",
        "address_full",
        "draining",
        "not_begun",
        "asks_too_much",
        "operator",
        "too_many_commands",
    ];

    fn kind(&self) -> &'static str {
        match self {
            Self::Protocol { .. } => "protocol",
            Self::Handshake => "handshake",
            Self::Timeout { .. } => "timeout",
            Self::NameTooLong { .. } => "name_too_long",
            Self::Token => "token",
            Self::Full => "full",
            Self::Replaced => "replaced",
            Self::Malformed { .. } => "malformed",
            Self::TooLarge { .. } => "too_large",
            Self::TooSlow => "too_slow",
            Self::Shutdown => "shutdown",
            Self::NoSpectators => "no_spectators",
            Self::SeatsOnly => "seats_only",
            Self::NoSuchSeat { .. } => "no_such_seat",
            Self::SpectatorsFull { .. } => "spectators_full",
            Self::Spectator => "spectator",
            Self::HeldTooMuch => "held_too_much",
            Self::Broken => "broken",
            Self::NoMatch => "no_match",
            Self::NoScenario => "no_scenario",
            Self::MatchesFull { .. } => "matches_full",
            Self::AddressFull { .. } => "address_full",
            Self::Draining => "draining",
            Self::NotBegun { .. } => "not_begun",
            Self::AsksTooMuch { .. } => "asks_too_much",
            Self::Operator => "operator",
            Self::TooManyCommands { .. } => "too_many_commands",
        }
    }
}

impl Kind for Outcome {
    const ALL: &'static [&'static str] = &[
        "applied",
        "unknown_handle",
        "out_of_world",
        "bad_number",
        "too_fast",
        "unknown_action",
        "too_many_waypoints",
        "empty_path",
        "too_many_commands",
        "start_in_past",
        "out",
        "unknown_target",
        "bad_target",
        "busy",
        "not_affordable",
        "missing",
        "training_full",
        "too_many_objects",
        "nothing_to_cancel",
        "bad_place",
        "nothing_to_return",
    ];

    fn kind(&self) -> &'static str {
        match self {
            Self::Applied { .. } => "applied",
            Self::Refused { reason } => match reason {
                Refusal::UnknownHandle => "unknown_handle",
                Refusal::OutOfWorld { .. } => "out_of_world",
                Refusal::BadNumber { .. } => "bad_number",
                Refusal::TooFast { .. } => "too_fast",
                Refusal::UnknownAction => "unknown_action",
                Refusal::TooManyWaypoints { .. } => "too_many_waypoints",
                Refusal::EmptyPath => "empty_path",
                Refusal::TooManyCommands { .. } => "too_many_commands",
                Refusal::StartInPast { .. } => "start_in_past",
                Refusal::Out => "out",
                Refusal::UnknownTarget => "unknown_target",
                Refusal::BadTarget => "bad_target",
                Refusal::Busy => "busy",
                Refusal::NotAffordable { .. } => "not_affordable",
                Refusal::Missing { .. } => "missing",
                Refusal::TrainingFull { .. } => "training_full",
                Refusal::TooManyObjects { .. } => "too_many_objects",
                Refusal::NothingToCancel => "nothing_to_cancel",
                Refusal::BadPlace => "bad_place",
                Refusal::NothingToReturn => "nothing_to_return",
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn kinds_have_names_of_their_own_and_room() {
        for all in [Refused::ALL, Outcome::ALL, End::ALL] {
            assert_eq!(all.iter().collect::<BTreeSet<_>>().len(), all.len(), "{all:?}");
            assert!(all.len() <= KINDS_MAX);
        }
    }

    #[test]
    fn each_kind_is_counted_under_its_name() {
        let results = Kinds::<Outcome>::default();
        results.count(&Outcome::Refused { reason: Refusal::NothingToReturn });
        results.count(&Outcome::Refused { reason: Refusal::NothingToReturn });
        let counted: Vec<_> = results.counts().into_iter().filter(|(_, count)| *count > 0).collect();
        assert_eq!(counted, [("nothing_to_return", 2)]);
    }
}
