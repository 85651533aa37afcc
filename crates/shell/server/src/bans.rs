//! Addresses that are let in no more.

use std::collections::BTreeSet;
use std::net::IpAddr;
use std::sync::Arc;

use tokio::sync::watch;

use crate::operation::{Entry, OperationError};

/// Addresses that can be banned at the same time: many times what somebody writes by hand.
pub const BANS_MAX: usize = 4096;

/// Who is let in no more. It is not kept when the daemon ends.
#[derive(Clone, Debug)]
pub(crate) struct Bans(Arc<watch::Sender<BTreeSet<IpAddr>>>);

impl Default for Bans {
    fn default() -> Self {
        Self(Arc::new(watch::Sender::new(BTreeSet::new())))
    }
}

impl Bans {
    /// Lets an address in no more, or again.
    ///
    /// # Errors
    /// As many are banned as can be.
    pub(crate) fn change(&self, address: IpAddr, entry: Entry) -> Result<(), OperationError> {
        let mut outcome = Ok(());
        self.0.send_if_modified(|banned| match entry {
            Entry::Allowed => banned.remove(&address),
            Entry::Denied if banned.len() >= BANS_MAX && !banned.contains(&address) => {
                outcome = Err(OperationError::TooManyBans { limit: BANS_MAX });
                false
            }
            Entry::Denied => banned.insert(address),
        });
        outcome
    }

    /// Returns whether an address is not let in.
    pub(crate) fn is_banned(&self, address: IpAddr) -> bool {
        self.0.borrow().contains(&address)
    }

    /// Waits until an address is let in no more.
    pub(crate) async fn wait(&self, address: IpAddr) {
        let mut receiver = self.0.subscribe();
        let banned = receiver.wait_for(|banned| banned.contains(&address)).await;
        drop(banned.expect("the sender is here"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn who_is_banned_is_told_at_once_and_others_are_not() {
        let bans = Bans::default();
        let [one, other]: [IpAddr; 2] = ["192.0.2.1", "2001:db8::1"].map(|address| address.parse().unwrap());
        let waiting = tokio::spawn({
            let bans = bans.clone();
            async move { bans.wait(one).await }
        });
        bans.change(other, Entry::Denied).unwrap();
        tokio::task::yield_now().await;
        assert!(!waiting.is_finished());
        bans.change(one, Entry::Denied).unwrap();
        waiting.await.unwrap();
        bans.change(other, Entry::Allowed).unwrap();
        assert!(bans.is_banned(one) && !bans.is_banned(other));
    }

    #[test]
    fn there_is_an_end_to_the_number_of_bans() {
        let bans = Bans::default();
        let address = |number: usize| IpAddr::from(u32::try_from(number).unwrap().to_be_bytes());
        for number in 0..BANS_MAX {
            bans.change(address(number), Entry::Denied).unwrap();
        }
        let error = bans.change(address(BANS_MAX), Entry::Denied);
        assert_eq!(error, Err(OperationError::TooManyBans { limit: BANS_MAX }));
        assert_eq!(bans.change(address(7), Entry::Denied), Ok(()), "it is banned already");
        bans.change(address(7), Entry::Allowed).unwrap();
        assert_eq!(bans.change(address(BANS_MAX), Entry::Denied), Ok(()));
    }
}
