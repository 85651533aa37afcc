//! The bot that fights with care.

use maniple_view::{Command, Delta, View};

use crate::fighting::{Battle, Force, is_fighter};
use crate::player::{Play, Start};
use crate::post::Post;
use crate::seeing::{Item, Search, middle};

/// Goes for the enemy as `rush` does, but gathers its fighters first, lets them concentrate their fire, keep their range while they
/// reload, and step back when they are hurt.
#[derive(Clone, Debug)]
pub(crate) struct Focus {
    post: Post,
    force: Force,
    search: Search,
}

impl Focus {
    pub(crate) const NAME: &str = "focus";

    pub(crate) fn begin(start: &Start, view: &View) -> Self {
        Self { post: Post::default(), force: Force::default(), search: Search::from_home(start, view) }
    }
}

impl Play for Focus {
    fn play(&mut self, start: &Start, view: &View, _delta: &Delta) -> Vec<Command> {
        let Self { post, force, search } = self;
        let scene = post.look(start, view);
        let fighters: Vec<&Item<'_>> = scene.own.iter().filter(|item| is_fighter(item)).collect();
        if fighters.is_empty() {
            return Vec::new();
        }
        let center = middle(fighters.iter().copied());
        let goal = Search::known(&scene, &post.memory, center)
            .unwrap_or_else(|| search.place(post.roads.size(), fighters.iter().map(|item| item.center)));
        let battle = Battle { cycle: view.cycle(), scene: &scene, friendly_fire: start.rules.friendly_fire };
        force.fight(post, battle, &fighters, (goal.center, None))
    }
}
