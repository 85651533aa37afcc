//! What spectators are told: their view, which stands back, and nothing of the present.

use bytes::Bytes;
use maniple_protocol::{EncodeError, Encoding, Input, Refused, ServerMessage, Watch, encode_server};
use maniple_referee::WatchError;
use maniple_view::{Delta, Vantage};

use super::Simulation;
use crate::connection::ConnectionId;
use crate::link::{Link, unsendable};

impl Simulation {
    pub(super) fn handle_watch(&mut self, connection: ConnectionId, watch: &Watch, link: Link) {
        let vantage = watch.view;
        let admitted = self.audience.check_room().and_then(|()| {
            let stand = self.referee.stand(vantage).map_err(refusal)?;
            Ok((self.welcome(vantage, Some(stand)), stand.keyframe()))
        });
        let (welcome, keyframe) = match admitted {
            Ok(beginning) => beginning,
            Err(reason) => {
                tracing::info!(connection = connection.0, client = watch.client, %reason, "refused");
                return link.refuse(reason);
            }
        };
        tracing::info!(connection = connection.0, client = watch.client, %vantage, "watches");
        self.audience.join(connection, vantage, link);
        self.send_to_spectator(connection, &ServerMessage::Welcome(welcome));
        if let Some(keyframe) = keyframe {
            let message = self.message_of(self.audience.encoding(connection), keyframe);
            self.send_to_spectator(connection, &message);
        }
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
            Input::Violation(reason) => self.remove_spectator(connection, reason),
            Input::Hello(_) | Input::Watch(_) => self.remove_spectator(connection, Refused::Handshake),
            Input::Commands { .. } | Input::Done { .. } | Input::Pause { .. } => {
                self.remove_spectator(connection, Refused::Spectator);
            }
        }
    }

    /// Sends what spectators get after a step; what is the same for several is written once.
    pub(super) fn send_to_spectators(&mut self) {
        for vantage in self.audience.vantages() {
            if self.referee.stand(vantage).is_ok_and(|stand| stand.shown().is_empty()) {
                continue;
            }
            let watching = self.audience.watching(vantage);
            let mut written: [Option<Result<Bytes, Refused>>; 2] = [None, None];
            for (connection, encoding) in watching {
                let place = match encoding {
                    Encoding::Binary => 0,
                    Encoding::Json => 1,
                };
                let bytes = written[place].get_or_insert_with(|| self.written(vantage, encoding)).clone();
                let sent = bytes.and_then(|bytes| self.audience.push_written(connection, bytes));
                if let Err(reason) = sent {
                    self.remove_spectator(connection, reason);
                }
            }
        }
    }

    /// Returns what those who watch a view get after a step, in one piece: at the end of a match it is all that was held
    /// back, which are more messages than may wait.
    fn written(&self, vantage: Vantage, encoding: Encoding) -> Result<Bytes, Refused> {
        let mut bytes = Vec::new();
        for delta in self.referee.stand(vantage).map_err(refusal)?.shown() {
            bytes.extend(self.write(encoding, delta).map_err(|error| unsendable(&error))?);
        }
        Ok(bytes.into())
    }

    fn write(&self, encoding: Encoding, delta: &Delta) -> Result<Vec<u8>, EncodeError> {
        encode_server(encoding, &self.message_of(Some(encoding), delta.clone()))
    }

    fn send_to_spectator(&mut self, connection: ConnectionId, message: &ServerMessage) {
        if let Err(reason) = self.audience.push(connection, message) {
            self.remove_spectator(connection, reason);
        }
    }

    fn remove_spectator(&mut self, connection: ConnectionId, reason: Refused) {
        if let Some(link) = self.audience.leave(connection) {
            tracing::warn!(connection = connection.0, %reason, "a spectator is removed");
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
