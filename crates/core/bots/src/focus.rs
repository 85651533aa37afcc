//! The bot that fights with care.

use maniple_view::{Command, Delta, Rules, Seat, Terrain, View};

use crate::bot::Bot;
use crate::fighting::{Battle, Force, is_fighter};
use crate::post::Post;
use crate::seeing::{Item, Search, middle};

/// Goes for the enemy as `rush` does, but gathers its fighters first, lets them concentrate their fire, keep their range while they
/// reload, and step back when they are hurt.
#[derive(Clone, Debug)]
pub struct Focus {
    seed: u64,
    seat: Seat,
    rules: Option<Rules>,
    post: Post,
    force: Force,
    /// From the first view on.
    search: Option<Search>,
}

impl Focus {
    pub(crate) const NAME: &str = "focus";

    /// Returns the bot; it has to be started.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self {
            seed,
            seat: Seat(0),
            rules: None,
            post: Post::default(),
            force: Force::default(),
            search: None,
        }
    }
}

impl Bot for Focus {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn on_start(&mut self, seat: Seat, rules: &Rules, _terrain: &Terrain) {
        *self = Self { seat, rules: Some(rules.clone()), ..Self::new(self.seed) };
    }

    fn on_cycle(&mut self, view: &View, _delta: &Delta) -> Vec<Command> {
        let Some(rules) = &self.rules else { return Vec::new() };
        let scene = self.post.look(view, rules, self.seat);
        let seed = self.seed;
        let search = self.search.get_or_insert_with(|| Search::new(seed, middle(&scene.own)));
        let fighters: Vec<&Item<'_>> = scene.own.iter().filter(|item| is_fighter(item)).collect();
        if fighters.is_empty() {
            return Vec::new();
        }
        let center = middle(fighters.iter().copied());
        let goal = Search::known(&scene, &self.post.memory, center)
            .unwrap_or_else(|| search.place(self.post.roads.size(), fighters.iter().map(|item| item.center)));
        let battle = Battle { cycle: view.cycle(), scene: &scene, friendly_fire: rules.friendly_fire };
        self.force.fight(&mut self.post, battle, &fighters, (goal.center, None))
    }
}
