//! What goes out to one connection, in its encoding.

use maniple_view::Rules;

use crate::encoding::{EncodeError, Encoding, encode_server};
use crate::message::ServerMessage;
use crate::packed::Packer;

/// Turns the messages to one client into bytes, and its deltas into packed ones if it reads binary frames.
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

    /// Returns the state of a binary connection whose welcome was said, and no delta yet.
    #[must_use]
    pub fn for_deltas(rules: &Rules) -> Self {
        Self { encoding: Encoding::Binary, packer: Some(Packer::new(rules)) }
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

    fn expect_deltas(&mut self, rules: &Rules) {
        self.packer = match self.encoding {
            Encoding::Binary => Some(Packer::new(rules)),
            Encoding::Json => None,
        };
    }
}

#[cfg(test)]
mod tests {
    use maniple_view::{Delta, View};

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
