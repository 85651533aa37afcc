//! The bot that goes for the enemy at once.

use maniple_view::{Command, Delta, Rules, Seat, Terrain, View};

use crate::bot::Bot;
use crate::fighting::{is_fighter, is_in_range, weapon};
use crate::moving::Advance;
use crate::post::Post;
use crate::seeing::{Item, Scene, Search, middle};

/// Sends all its fighters together at the nearest enemy that it knows of, or to where one might be, and lets each fire at the
/// nearest enemy in range. Where it has no fighters, all who have a weapon go.
#[derive(Clone, Debug)]
pub struct Rush {
    seed: u64,
    seat: Seat,
    rules: Option<Rules>,
    post: Post,
    advance: Advance,
    /// From the first view on.
    search: Option<Search>,
}

impl Rush {
    pub(crate) const NAME: &str = "rush";

    /// Returns the bot; it has to be started.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self {
            seed,
            seat: Seat(0),
            rules: None,
            post: Post::default(),
            advance: Advance::default(),
            search: None,
        }
    }
}

impl Bot for Rush {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn on_start(&mut self, seat: Seat, rules: &Rules, _terrain: &Terrain) {
        *self = Self { seat, rules: Some(rules.clone()), ..Self::new(self.seed) };
    }

    fn on_cycle(&mut self, view: &View, _delta: &Delta) -> Vec<Command> {
        let Some(rules) = &self.rules else { return Vec::new() };
        let scene = self.post.look(view, rules, self.seat);
        let Post { roads, memory, orders } = &mut self.post;
        let seed = self.seed;
        let search = self.search.get_or_insert_with(|| Search::new(seed, middle(&scene.own)));
        let fighters = fighters(&scene);
        let mut commands = Vec::new();
        let mut free = Vec::new();
        for &item in &fighters {
            match nearest_in_range(item, &scene) {
                Some(enemy) => {
                    let command = Command::Attack { object: item.object, target: enemy.object };
                    commands.extend(orders.give(item, command));
                }
                None => free.push(item.object),
            }
        }
        let center = middle(fighters.iter().copied());
        let goal = Search::known(&scene, memory, center)
            .unwrap_or_else(|| search.place(roads.size(), fighters.iter().map(|item| item.center)));
        let marching = self.advance.lead(roads, (view.cycle(), &scene), (&fighters, &free), goal.center);
        for command in marching {
            let item = command.object().and_then(|object| scene.own(object));
            commands.extend(item.and_then(|item| orders.give(item, command)));
        }
        commands
    }
}

/// Returns the fighters, or, where there are none, all who could be.
fn fighters<'a, 'b>(scene: &'b Scene<'a>) -> Vec<&'b Item<'a>> {
    let fighters: Vec<&Item<'_>> = scene.own.iter().filter(|item| is_fighter(item)).collect();
    if !fighters.is_empty() {
        return fighters;
    }
    scene.own.iter().filter(|item| item.kind.weapon.is_some()).collect()
}

/// Returns the enemy in range that is nearest, hull to hull; of several the one with the smallest handle.
fn nearest_in_range<'a, 'b>(item: &Item<'a>, scene: &'b Scene<'a>) -> Option<&'b Item<'a>> {
    let weapon = weapon(item)?;
    let in_range = scene.enemies.iter().filter(|enemy| is_in_range(item, enemy, weapon));
    in_range.min_by(|one, other| item.distance(one).total_cmp(&item.distance(other)))
}
