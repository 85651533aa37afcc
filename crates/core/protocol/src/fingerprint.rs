//! A state as a tree of hashes, so that where two differ has a name.
//!
//! The hash of a cycle is one number, which says that two states differ and not where. This tree is made on demand, from the
//! snapshots of both: whole, part, object, field.

use std::fmt;

use maniple_view::Digest;
use serde::Serialize;
use serde_json::Value;
use twox_hash::XxHash3_64;

/// A node of the tree. Its hash is the xxh3-64 of the names and hashes of its children, or of its text where it has none.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fingerprint {
    /// The name of the field, the number of the object, or the place in the list; empty for the whole.
    pub name: String,
    /// The hash of all below.
    pub hash: Digest,
    /// What it is.
    pub content: Content,
}

/// What a node is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Content {
    /// A number or a text, as JSON has it.
    Leaf(String),
    /// Parts: those that have parts themselves before numbers and texts, so that a sum is not named before its summands;
    /// numbered ones by number, others by name.
    Parts(Vec<Fingerprint>),
}

/// Where two states differ.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// The names from the whole to where they differ, as in `world/field/objects/17/start/x`.
    pub path: String,
    /// What the first has there; `None`: nothing.
    pub first: Option<String>,
    /// What the second has there; `None`: nothing.
    pub second: Option<String>,
}

/// What is told follows from the world, so it is looked at first.
const FIRST: &str = "world";

impl Fingerprint {
    /// Returns the tree of a value; numbers and texts are its leaves.
    ///
    /// # Panics
    /// Where a map has keys that are neither texts nor numbers.
    #[must_use]
    pub fn of<T: Serialize>(value: &T) -> Self {
        let value =
            serde_json::to_value(value).expect("no map of ours has keys that are not texts or numbers");
        Self::node(String::new(), value)
    }

    fn node(name: String, value: Value) -> Self {
        let mut parts: Vec<Self> = match value {
            Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {
                let text = value.to_string();
                let hash = Digest(XxHash3_64::oneshot(text.as_bytes()));
                return Self { name, hash, content: Content::Leaf(text) };
            }
            Value::Array(items) => {
                (0..items.len()).zip(items).map(|(place, item)| Self::node(place.to_string(), item)).collect()
            }
            Value::Object(fields) => {
                fields.into_iter().map(|(name, field)| Self::node(name, field)).collect()
            }
        };
        parts.sort_by(|one, other| one.key().cmp(&other.key()));
        let mut bytes = Vec::new();
        for part in &parts {
            bytes.extend_from_slice(part.name.as_bytes());
            bytes.push(0);
            bytes.extend_from_slice(&part.hash.0.to_le_bytes());
        }
        Self { name, hash: Digest(XxHash3_64::oneshot(&bytes)), content: Content::Parts(parts) }
    }

    /// Returns where this state and another one differ, at most `limit` places; nothing where they do not.
    #[must_use]
    pub fn differences(&self, other: &Self, limit: usize) -> Vec<Difference> {
        let mut found = Vec::new();
        compare(String::new(), Some(self), Some(other), &mut found, limit);
        found
    }

    /// By what it is ordered among its siblings.
    fn key(&self) -> (bool, bool, Option<u64>, &str) {
        let is_leaf = matches!(self.content, Content::Leaf(_));
        (is_leaf, self.name != FIRST, self.name.parse().ok(), &self.name)
    }

    fn parts(&self) -> &[Self] {
        match &self.content {
            Content::Leaf(_) => &[],
            Content::Parts(parts) => parts,
        }
    }

    /// The text of a leaf, or how many parts there are.
    fn text(&self) -> String {
        match &self.content {
            Content::Leaf(text) => text.clone(),
            Content::Parts(parts) => format!("{} parts", parts.len()),
        }
    }
}

/// Adds where two nodes of one name differ, of which at least one is there.
fn compare(
    path: String,
    first: Option<&Fingerprint>,
    second: Option<&Fingerprint>,
    found: &mut Vec<Difference>,
    limit: usize,
) {
    if found.len() >= limit || first.map(|node| node.hash) == second.map(|node| node.hash) {
        return;
    }
    let (Some(one), Some(other)) = (first, second) else {
        let text = |node: Option<&Fingerprint>| node.map(Fingerprint::text);
        found.push(Difference { path, first: text(first), second: text(second) });
        return;
    };
    if one.parts().is_empty() && other.parts().is_empty() {
        found.push(Difference { path, first: Some(one.text()), second: Some(other.text()) });
        return;
    }
    let is_at = |name: &str| if path.is_empty() { name.to_owned() } else { format!("{path}/{name}") };
    let named = |node: &Fingerprint, name: &str| node.parts().iter().position(|part| part.name == name);
    for part in one.parts() {
        let twin = named(other, &part.name).map(|place| &other.parts()[place]);
        compare(is_at(&part.name), Some(part), twin, found, limit);
    }
    for part in other.parts().iter().filter(|part| named(one, &part.name).is_none()) {
        compare(is_at(&part.name), None, Some(part), found, limit);
    }
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = |side: &Option<String>| side.clone().unwrap_or_else(|| "nothing".to_owned());
        write!(f, "{}: {} against {}", self.path, text(&self.first), text(&self.second))
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    #[derive(Clone, Serialize)]
    struct State {
        digest: u64,
        told: Vec<u32>,
        world: BTreeMap<u32, (f64, Option<u32>)>,
    }

    #[test]
    fn differences_are_named_by_object_and_field_the_world_before_what_is_told_and_sums_last() {
        let state = || State {
            digest: 5,
            told: vec![1, 2],
            world: (0..20).map(|object| (object, (f64::from(object), None))).collect(),
        };
        let check = |change: fn(&mut State), expected: &[&str]| {
            let mut other = state();
            change(&mut other);
            let found = Fingerprint::of(&state()).differences(&Fingerprint::of(&other), 3);
            let found: Vec<String> = found.iter().map(Difference::to_string).collect();
            assert_eq!(found, expected);
        };
        check(|_| (), &[]);
        check(|state| state.world.get_mut(&17).unwrap().0 = 1e-300, &["world/17/0: 17.0 against 1e-300"]);
        check(|state| state.world.get_mut(&0).unwrap().0 = -0.0, &["world/0/0: 0.0 against -0.0"]);
        check(|state| state.world.get_mut(&3).unwrap().1 = Some(9), &["world/3/1: null against 9"]);
        check(
            |state| {
                state.digest = 6;
                state.told.push(4);
                state.world.get_mut(&10).unwrap().0 = 0.5;
                state.world.get_mut(&9).unwrap().0 = 0.5;
            },
            &["world/9/0: 9.0 against 0.5", "world/10/0: 10.0 against 0.5", "told/2: nothing against 4"],
        );
        check(
            |state| {
                state.digest = 6;
                state.world.remove(&4);
            },
            &["world/4: 2 parts against nothing", "digest: 5 against 6"],
        );
    }
}
