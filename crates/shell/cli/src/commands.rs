//! One file a command.

pub(crate) mod admin;
pub(crate) mod bench;
pub(crate) mod bot;
pub(crate) mod conformance;
pub(crate) mod map;
pub(crate) mod play;
pub(crate) mod replay;
pub(crate) mod serve;
pub(crate) mod simulate;
pub(crate) mod tournament;
pub(crate) mod watch;
