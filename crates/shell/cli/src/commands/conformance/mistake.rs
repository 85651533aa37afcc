//! What a client can do wrong, and how it is mended.

use maniple_protocol::{PROTOCOL, Refused};

/// What a client did wrong.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Mistake {
    /// It broke the protocol, for which the daemon closes the connection.
    Violation(Refused),
    /// The hello has another token than the one that was printed, or none.
    Token,
    /// Commands that were decided on another delta than the last.
    SeenCycle {
        /// What it said.
        found: u32,
    },
    /// `done` for a cycle that is not the present one.
    DoneCycle {
        /// What it said.
        found: u32,
    },
    /// `done` once more for the cycle before.
    DoneTwice,
    /// A command for an object that is not the seat's own.
    UnknownHandle {
        /// The number of the command.
        seq: u32,
        /// The object.
        object: u32,
    },
    /// A command with a target that is not in the view.
    UnknownTarget {
        /// The number of the command.
        seq: u32,
        /// The target.
        target: u32,
    },
    /// A command with a number that is not finite.
    NotFinite {
        /// The number of the command.
        seq: u32,
    },
    /// More commands in a cycle than the rules allow.
    TooManyCommands {
        /// What the rules allow.
        limit: u32,
    },
    /// It computed another check than the server.
    Check {
        /// What it pinged with.
        found: u32,
        /// The low half of the server's.
        expected: u32,
    },
    /// It proved its view in cycles before, and not in this one.
    NoProof,
    /// It resigned, so that most of the story was not told.
    Resigned,
    /// It did not answer in time.
    Silent {
        /// The time that it had.
        seconds: u64,
    },
    /// It closed the connection before the match had ended.
    Closed,
    /// It did not come back after the connection had been cut.
    NoReturn,
}

impl Mistake {
    /// Returns its name, for programs.
    pub(crate) fn name(&self) -> &'static str {
        match self {
            Self::Violation(_) => "violation",
            Self::Token => "token",
            Self::SeenCycle { .. } => "seen_cycle",
            Self::DoneCycle { .. } => "done_cycle",
            Self::DoneTwice => "done_twice",
            Self::UnknownHandle { .. } => "unknown_handle",
            Self::UnknownTarget { .. } => "unknown_target",
            Self::NotFinite { .. } => "not_finite",
            Self::TooManyCommands { .. } => "too_many_commands",
            Self::Check { .. } => "check",
            Self::NoProof => "no_proof",
            Self::Resigned => "resigned",
            Self::Silent { .. } => "silent",
            Self::Closed => "closed",
            Self::NoReturn => "no_return",
        }
    }

    /// Returns what was seen.
    pub(crate) fn what(&self) -> String {
        match self {
            Self::Violation(Refused::Malformed { place, problem }) => format!("{place}: {problem}"),
            Self::Violation(reason) => format!("the client was refused: {reason}"),
            Self::Token => "the token of the hello opens no seat here".to_owned(),
            Self::SeenCycle { found } => format!("commands with seen_cycle {found}"),
            Self::DoneCycle { found } => format!("done with cycle {found}"),
            Self::DoneTwice => "done for the cycle before, once more".to_owned(),
            Self::UnknownHandle { seq, object } => {
                format!("command {seq} is for object {object}, which is none of the client's own in its view")
            }
            Self::UnknownTarget { seq, target } => {
                format!("command {seq} has the target {target}, which is not in the view")
            }
            Self::NotFinite { seq } => format!("command {seq} has a number that is not finite"),
            Self::TooManyCommands { limit } => format!("more than {limit} commands in a cycle"),
            Self::Check { found, .. } => format!("the client's check ends in {found:08x}"),
            Self::NoProof => "no ping with the check, which there was in cycles before".to_owned(),
            Self::Resigned => "the client resigned".to_owned(),
            Self::Silent { seconds } => format!("the client said nothing that ends its turn for {seconds} s"),
            Self::Closed => "the client closed the connection".to_owned(),
            Self::NoReturn => "the client did not connect again".to_owned(),
        }
    }

    /// Returns what should have been seen in a cycle.
    pub(crate) fn expected(&self, cycle: u32) -> String {
        match self {
            Self::Violation(reason) => expected_instead(reason),
            Self::Token => "the 32 hex digits that were printed at the start".to_owned(),
            Self::SeenCycle { .. } | Self::DoneCycle { .. } => {
                format!("{cycle}, the cycle of the last delta")
            }
            Self::DoneTwice => "one done for each delta".to_owned(),
            Self::UnknownHandle { .. } => {
                "a handle that came in appeared with own, and did not die".to_owned()
            }
            Self::UnknownTarget { .. } => {
                "a handle that came in appeared, and neither vanished nor died".to_owned()
            }
            Self::NotFinite { .. } => "numbers that are neither NaN nor infinite".to_owned(),
            Self::TooManyCommands { limit } => format!("at most {limit}, commands_a_cycle_max of the rules"),
            Self::Check { expected, .. } => format!("{expected:08x}, the low half of the check of the delta"),
            Self::NoProof => "a ping with the low half of the check after each delta, before done".to_owned(),
            Self::Resigned => "the match played to its end".to_owned(),
            Self::Silent { .. } => {
                "hello at once, and done after each delta, whatever the delta says".to_owned()
            }
            Self::Closed => "the connection open until the message ended".to_owned(),
            Self::NoReturn => "a new connection with the same token, after one that was cut".to_owned(),
        }
    }

    /// Returns how it is mended.
    pub(crate) fn remedy(&self) -> &'static str {
        match self {
            Self::Violation(_) => {
                "compare the bytes with sections 2 to 4 of docs/PROTOCOL.md and with tests/golden/protocol"
            }
            Self::Token => "hand the printed token to the client, and send it in hello",
            Self::SeenCycle { .. } => "take seen_cycle from the delta on which the commands were decided",
            Self::DoneCycle { .. } => "take the cycle of done from the delta that it answers",
            Self::DoneTwice => "say done once when a delta was taken in, not for every message",
            Self::UnknownHandle { .. } => {
                "take what is in died and vanished out of the view, and command only objects whose owner is the seat"
            }
            Self::UnknownTarget { .. } => "take what is in died and vanished out of the view",
            Self::NotFinite { .. } => "look for a division by zero before the command",
            Self::TooManyCommands { .. } => "command an object only when there is something new to say",
            Self::Check { .. } => {
                "follow section 8 of docs/PROTOCOL.md; tests/golden/transcripts shows deltas and the views after them"
            }
            Self::NoProof => {
                "send the ping for every delta: refused commands, a pause and a keyframe change nothing"
            }
            Self::Resigned => "do not resign in this test",
            Self::Silent { .. } => {
                "send hello first and answer every delta; set TCP_NODELAY, and flush what is buffered"
            }
            Self::Closed => {
                "go on after results that are refused and messages that need no answer, until ended"
            }
            Self::NoReturn => "connect again with the token when a connection ends without ended or refused",
        }
    }
}

fn expected_instead(reason: &Refused) -> String {
    match reason {
        Refused::Protocol { .. } => format!("protocol {PROTOCOL}"),
        Refused::Handshake => "one hello, as the first message".to_owned(),
        Refused::Malformed { place, .. } if place == "the first bytes" => {
            "`{` for JSON lines, or `MNPL` for binary frames".to_owned()
        }
        Refused::Malformed { .. } => "a message of section 4 of docs/PROTOCOL.md".to_owned(),
        Refused::NameTooLong { limit } => format!("names of at most {limit} bytes"),
        Refused::Token => "no token, or one of 32 hex digits".to_owned(),
        Refused::TooLarge { limit } => format!("messages of at most {limit} bytes"),
        Refused::Timeout { seconds } => format!("a hello within {seconds} s"),
        Refused::Spectator => "a hello, because this is for players".to_owned(),
        Refused::NoMatch => {
            "a hello without `list`, `create` or `enter` before: there is one match".to_owned()
        }
        Refused::Full
        | Refused::Broken
        | Refused::NoScenario
        | Refused::MatchesFull { .. }
        | Refused::AddressFull { .. }
        | Refused::Draining
        | Refused::NotBegun { .. }
        | Refused::AsksTooMuch { .. }
        | Refused::Operator
        | Refused::Replaced
        | Refused::TooSlow
        | Refused::Shutdown
        | Refused::NoSpectators
        | Refused::SeatsOnly
        | Refused::NoSuchSeat { .. }
        | Refused::SpectatorsFull { .. }
        | Refused::HeldTooMuch
        | Refused::TooManyCommands { .. } => "a connection that plays to the end".to_owned(),
    }
}
