//! How much of the server one client may have, and all together.

use std::collections::BTreeMap;
use std::net::IpAddr;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// What whoever runs a server may change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Connections at the same time; more wait in the backlog of the socket.
    pub connections: usize,
    /// Connections of one address at the same time; more are refused.
    pub connections_per_address: usize,
    /// Matches at the same time.
    pub matches: usize,
    /// Matches that clients of one address have created, at the same time.
    pub matches_per_address: usize,
    /// Time for the players of a match in the lobby to come.
    pub begin_within: Duration,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            connections: 8192,
            connections_per_address: 8192,
            matches: 1024,
            matches_per_address: 1024,
            begin_within: Duration::from_secs(600),
        }
    }
}

/// Counts things by the address that has them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Addresses(Arc<Mutex<BTreeMap<IpAddr, usize>>>);

/// One of the things that an address has, until it is dropped.
#[derive(Debug)]
pub(crate) struct Place {
    addresses: Addresses,
    address: IpAddr,
}

impl Addresses {
    /// Takes a place for an address that has fewer than `limit`; `None` where it has as many.
    pub(crate) fn take(&self, address: IpAddr, limit: usize) -> Option<Place> {
        let mut counts = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let count = counts.entry(address).or_default();
        if *count >= limit {
            if *count == 0 {
                counts.remove(&address);
            }
            return None;
        }
        *count += 1;
        Some(Place { addresses: self.clone(), address })
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let mut counts = self.addresses.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(count) = counts.get_mut(&self.address) {
            *count -= 1;
            if *count == 0 {
                counts.remove(&self.address);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_has_so_many_places_and_again_when_one_is_left() {
        let addresses = Addresses::default();
        let [one, other] = ["10.0.0.1", "10.0.0.2"].map(|address| address.parse().unwrap());
        let places: Vec<Place> = (0..3).map(|_| addresses.take(one, 3).unwrap()).collect();
        assert!(addresses.take(one, 3).is_none());
        assert!(addresses.take(other, 3).is_some());
        assert!(addresses.take(other, 0).is_none());
        drop(places);
        assert!(addresses.take(one, 3).is_some());
        assert!(addresses.0.lock().unwrap().is_empty(), "who has nothing is forgotten");
    }
}
