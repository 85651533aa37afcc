//! The bot that gathers.

use maniple_view::{Command, Delta, Rules, Seat, Terrain, View};

use crate::bot::Bot;
use crate::economy::Miners;
use crate::post::Post;
use crate::seeing::Item;

/// Lets all its workers gather, each between a place beside a patch and one beside a building that are its own, and does nothing
/// else.
#[derive(Clone, Debug)]
pub struct Gather {
    seed: u64,
    seat: Seat,
    rules: Option<Rules>,
    post: Post,
    miners: Miners,
}

impl Gather {
    pub(crate) const NAME: &str = "gather";

    /// Returns the bot; it has to be started.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self { seed, seat: Seat(0), rules: None, post: Post::default(), miners: Miners::new(seed) }
    }
}

impl Bot for Gather {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn on_start(&mut self, seat: Seat, rules: &Rules, _terrain: &Terrain) {
        *self = Self { seat, rules: Some(rules.clone()), ..Self::new(self.seed) };
    }

    fn on_cycle(&mut self, view: &View, _delta: &Delta) -> Vec<Command> {
        let Some(rules) = &self.rules else { return Vec::new() };
        let scene = self.post.look(view, rules, self.seat);
        let workers: Vec<&Item<'_>> = scene.own.iter().filter(|item| item.kind.harvest.is_some()).collect();
        self.miners.work(&mut self.post, view.cycle(), &scene, &workers)
    }
}
