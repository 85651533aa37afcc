//! What goes out to one connection, in its encoding.

use maniple_view::{Delta, Rules};

use crate::encoding::{EncodeError, Encoding, encode_server};
use crate::message::ServerMessage;
use crate::packed::Packer;

/// Turns the messages to one client, or the deltas to all who watch one view in one encoding, into bytes: deltas into packed ones
/// where binary frames are read.
#[derive(Clone, Debug)]
pub struct Outbound {
    encoding: Encoding,
    /// On binary connections, from the welcome on.
    packer: Option<Packer>,
}

impl Outbound {
    /// Returns the state of a connection to which nothing was said yet.
    #[must_use]
    pub fn new(encoding: Encoding) -> Self {
        Self { encoding, packer: None }
    }

    /// Returns the state of a connection whose welcome was said, and no delta yet.
    #[must_use]
    pub fn for_deltas(encoding: Encoding, rules: &Rules) -> Self {
        let mut outbound = Self::new(encoding);
        outbound.expect_deltas(rules);
        outbound
    }

    /// Returns the whole frame or line of the next message. A delta that cannot be sent is lost, and with it the connection.
    ///
    /// # Errors
    /// A message that the client would refuse: longer than [`crate::FRAME_FROM_SERVER_MAX`].
    ///
    /// # Panics
    /// If a delta does not follow those before; the first behind a welcome is a keyframe.
    pub fn encode(&mut self, message: &ServerMessage) -> Result<Vec<u8>, EncodeError> {
        if let ServerMessage::Welcome(welcome) = message {
            self.expect_deltas(&welcome.rules);
        }
        match (message, &mut self.packer) {
            (ServerMessage::Delta(delta), Some(packer)) => {
                encode_server(self.encoding, &ServerMessage::Packed(packer.pack(delta)))
            }
            _ => encode_server(self.encoding, message),
        }
    }

    /// Returns the whole frame or line of a merged delta, for who has missed some of the deltas so far, up to the last.
    ///
    /// # Errors
    /// As [`Self::encode`].
    ///
    /// # Panics
    /// If the merged delta does not end with the last delta.
    pub fn encode_merged(&self, merged: Delta) -> Result<Vec<u8>, EncodeError> {
        let message = match &self.packer {
            Some(packer) => ServerMessage::Packed(packer.pack_merged(&merged)),
            None => ServerMessage::Delta(merged),
        };
        encode_server(self.encoding, &message)
    }

    /// Returns the encoding.
    #[must_use]
    pub fn encoding(&self) -> Encoding {
        self.encoding
    }

    fn expect_deltas(&mut self, rules: &Rules) {
        self.packer = match self.encoding {
            Encoding::Binary => Some(Packer::new(rules)),
            Encoding::Json => None,
        };
    }
}

#[cfg(test)]
mod tests {
    use maniple_view::View;

    use super::*;
    use crate::arbitrary::Random;
    use crate::encoding::decode_server;

    #[test]
    fn deltas_are_packed_behind_a_welcome_in_binary_frames_alone() {
        let welcome = Random::new(1).welcome();
        let delta = Delta { stock: Some(5), ..Delta::default() };
        for encoding in [Encoding::Json, Encoding::Binary] {
            let mut outbound = Outbound::new(encoding);
            let body = |bytes: &[u8]| match encoding {
                Encoding::Binary => bytes[4..].to_vec(),
                Encoding::Json => bytes[..bytes.len() - 1].to_vec(),
            };
            let greeting = ServerMessage::Welcome(welcome.clone());
            let bytes = outbound.encode(&greeting).unwrap();
            assert_eq!(decode_server(encoding, &body(&bytes)), Ok(greeting));
            let bytes = outbound.encode(&ServerMessage::Delta(delta.clone())).unwrap();
            let message = decode_server(encoding, &body(&bytes)).unwrap();
            let found = if let ServerMessage::Packed(packed) = message {
                assert_eq!(encoding, Encoding::Binary);
                packed.unpack(&View::default(), &welcome.rules).unwrap()
            } else {
                let expected = ServerMessage::Delta(delta.clone());
                assert_eq!((message, encoding), (expected, Encoding::Json));
                continue;
            };
            assert_eq!(found, delta);
        }
    }
}
