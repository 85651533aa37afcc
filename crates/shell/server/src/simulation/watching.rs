//! What spectators are told: their view, which stands back, and nothing of the present.

use maniple_protocol::{Encoding, Input, Refused, ServerMessage, Watch};
use maniple_referee::WatchError;
use maniple_view::Vantage;

use super::Simulation;
use crate::connection::ConnectionId;
use crate::link::Link;

impl Simulation {
    pub(super) fn handle_watch(&mut self, connection: ConnectionId, watch: &Watch, link: Link) {
        let vantage = watch.view;
        let admitted = self.audience.check_room().and_then(|()| self.prepare(vantage, link.encoding()));
        if let Err(reason) = admitted {
            tracing::info!(connection = connection.0, client = watch.client, %reason, "refused");
            self.metrics.refused.count(&reason);
            return link.refuse(reason);
        }
        tracing::info!(connection = connection.0, client = watch.client, %vantage, "watches");
        self.audience.join(connection, vantage, link);
    }

    /// Writes what who comes now to watch a view is told, unless that was done for another already.
    fn prepare(&mut self, vantage: Vantage, encoding: Encoding) -> Result<(), Refused> {
        let stand = self.referee.stand(vantage).map_err(refusal)?;
        if self.audience.knows_beginning(vantage, encoding, &self.referee.rules_of(vantage).players) {
            return Ok(());
        }
        let (welcome, keyframe) = (self.welcome(vantage, Some(stand)), stand.keyframe());
        self.audience.handle_beginning(vantage, encoding, welcome, keyframe)
    }

    /// Handles what a spectator says. It is never told how far the match is: a pong names the cycle of its view.
    pub(super) fn handle_spectator(&mut self, connection: ConnectionId, vantage: Vantage, input: Input) {
        match input {
            Input::Ping { id } => match self.referee.stand(vantage) {
                Ok(stand) => {
                    let fraction = if stand.has_begun() { self.fraction() } else { 0.0 };
                    let pong = ServerMessage::Pong { id, cycle: stand.cycle(), fraction };
                    self.send_to_spectator(connection, &pong);
                }
                Err(error) => self.remove_spectator(connection, refusal(error)),
            },
            Input::Dropped(reason) => {
                let warned = self.audience.handle_violation(connection, reason);
                self.check_sent_to_spectator(connection, warned);
            }
            Input::Violation(reason) => self.remove_spectator(connection, reason),
            Input::Hello(_) | Input::Watch(_) | Input::List | Input::Create(_) | Input::Enter { .. } => {
                self.remove_spectator(connection, Refused::Handshake);
            }
            Input::Commands { .. } | Input::Done { .. } | Input::Pause { .. } => {
                self.remove_spectator(connection, Refused::Spectator);
            }
        }
    }

    /// Sends what spectators get after a step: at the end of a match it is all that was held back.
    pub(super) fn send_to_spectators(&mut self) {
        for vantage in self.audience.vantages() {
            let removed = match self.referee.stand(vantage) {
                Ok(stand) => self.audience.push_deltas(vantage, stand.shown(), &|| stand.view().keyframe()),
                Err(error) => {
                    let watching = self.audience.watching(vantage).into_iter();
                    watching.map(|connection| (connection, refusal(error))).collect()
                }
            };
            for (connection, reason) in removed {
                self.remove_spectator(connection, reason);
            }
        }
    }

    fn send_to_spectator(&mut self, connection: ConnectionId, message: &ServerMessage) {
        let sent = self.audience.push(connection, message);
        self.check_sent_to_spectator(connection, sent);
    }

    fn check_sent_to_spectator(&mut self, connection: ConnectionId, sent: Result<(), Refused>) {
        if let Err(reason) = sent {
            self.remove_spectator(connection, reason);
        }
    }

    fn remove_spectator(&mut self, connection: ConnectionId, reason: Refused) {
        if let Some(link) = self.audience.leave(connection) {
            tracing::warn!(connection = connection.0, %reason, "a spectator is removed");
            self.metrics.refused.count(&reason);
            link.refuse(reason);
        }
    }
}

fn refusal(error: WatchError) -> Refused {
    match error {
        WatchError::NotPermitted => Refused::NoSpectators,
        WatchError::SeatsOnly => Refused::SeatsOnly,
        WatchError::NoSuchSeat { seats } => Refused::NoSuchSeat { seats },
        WatchError::TooMuch => Refused::HeldTooMuch,
    }
}
