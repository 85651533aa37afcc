//! The bot that goes for the enemy at once.

use maniple_view::{Command, Delta, View};

use crate::fighting::{is_fighter, is_in_range, weapon};
use crate::moving::Advance;
use crate::player::{Play, Start};
use crate::post::Post;
use crate::seeing::{Item, Scene, Search, middle};

/// Sends all its fighters together at the nearest enemy that it knows of, or to where one might be, and lets each fire at the
/// nearest enemy in range. Where it has no fighters, all who have a weapon go.
#[derive(Clone, Debug)]
pub(crate) struct Rush {
    post: Post,
    advance: Advance,
    search: Search,
}

impl Rush {
    pub(crate) const NAME: &str = "rush";

    pub(crate) fn begin(start: &Start, view: &View) -> Self {
        Self { post: Post::default(), advance: Advance::default(), search: Search::from_home(start, view) }
    }
}

impl Play for Rush {
    fn play(&mut self, start: &Start, view: &View, _delta: &Delta) -> Vec<Command> {
        let Self { post, advance, search } = self;
        let scene = post.look(start, view);
        let Post { roads, memory, orders } = post;
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
        let marching = advance.lead(roads, (view.cycle(), &scene), (&fighters, &free), goal.center);
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
