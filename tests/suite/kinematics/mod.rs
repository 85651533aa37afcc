//! The kinematic core: its promises, and its agreement with a slow twin.

mod agreement;
mod changes;
mod extremes;
mod maps;
mod march;
mod metamorphic;
mod oracle;
mod promises;
mod scene;
mod settings;
mod threads;
mod twin;
mod uneven;

pub(crate) use scene::{Random, Scene};
