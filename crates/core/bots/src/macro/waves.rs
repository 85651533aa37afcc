//! When fighters set out, and who is out.

use std::collections::BTreeSet;

use maniple_view::{Delta, Handle, View};

use crate::fighting::is_fighter;
use crate::seeing::{Item, Scene};

/// Fighters with which a wave sets out where more can be trained.
const WAVE: usize = 12;

/// Fighters to which waves shrink before they come home, and with which one sets out against who has just lost as many.
const WAVE_LEAST: usize = 5;

/// Cycles without another fighter after which those at home set out however few they are: there is nothing to wait for.
const LULL: u32 = 640;

/// Cycles after which fighters that an enemy has lost count no more: it has trained others.
const RECOVERY: u32 = 320;

/// Who is out, and what decides when others set out.
#[derive(Clone, Debug, Default)]
pub(super) struct Waves {
    out: BTreeSet<Handle>,
    /// How many waited at home in the last cycle, and since when there have been no more.
    waiting: usize,
    since: u32,
    /// The fighters of enemies that were in sight in the last cycle.
    sighted: BTreeSet<Handle>,
    /// How many of them have died, and when the last one did.
    beaten: usize,
    beaten_at: u32,
}

impl Waves {
    /// Decides who is out in a cycle: nobody comes home before a wave is nearly gone.
    pub(super) fn refresh(&mut self, view: &View, delta: &Delta, scene: &Scene<'_>) {
        let now = view.cycle().0;
        self.count_beaten(now, delta, scene);
        self.out.retain(|&object| scene.own(object).is_some());
        if self.out.len() < WAVE_LEAST {
            self.out.clear();
        }
        let home = || scene.own.iter().filter(|item| is_fighter(item)).map(|item| item.object);
        let home: Vec<Handle> = home().filter(|object| !self.out.contains(object)).collect();
        if home.len() > self.waiting || home.is_empty() {
            self.since = now;
        }
        self.waiting = home.len();
        let is_stronger = home.len() >= WAVE_LEAST && self.beaten >= home.len();
        if home.len() >= WAVE || is_stronger || now > self.since + LULL {
            self.out.extend(home);
        }
    }

    /// Returns whether a fighter is out.
    pub(super) fn has(&self, item: &Item<'_>) -> bool {
        self.out.contains(&item.object)
    }

    fn count_beaten(&mut self, now: u32, delta: &Delta, scene: &Scene<'_>) {
        let died = delta.died.iter().filter(|object| self.sighted.contains(object)).count();
        if died > 0 {
            self.beaten_at = now;
        } else if now > self.beaten_at + RECOVERY {
            self.beaten = 0;
        }
        self.beaten += died;
        self.sighted = scene.enemies.iter().filter(|item| is_fighter(item)).map(|item| item.object).collect();
    }
}
