//! The name of an object.

use serde::{Deserialize, Serialize};

/// The world's own name for an object. It never reaches a player: snapshots hold it, messages do not.
#[doc(alias = "unit")]
#[doc(alias = "body")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct ObjectId(pub u32);

impl std::fmt::Display for ObjectId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.fmt(f)
    }
}
