//! The bot that plays by every rule a scenario has.

mod army;
mod ground;
mod town;
mod trips;
mod workers;

use maniple_view::{Command, Delta, View};

use crate::player::{Play, Start};
use crate::seeing::{Item, Memory, Search};
use army::{Army, Situation};
use ground::Ground;
use town::Town;
use trips::Trips;
use workers::Workers;

/// Gathers, builds, trains, and sends all fighters at the enemy, as far as the scenario lets it.
///
/// It finds ways over tiles, goes aside by chance where others stand in the way, remembers buildings that it saw, and
/// searches the map where it knows of no enemy. It is no strong player: it is the least that uses every rule.
#[derive(Clone, Debug)]
pub(crate) struct Commander {
    ground: Ground,
    trips: Trips,
    memory: Memory,
    workers: Workers,
    town: Town,
    army: Army,
}

impl Commander {
    pub(crate) const NAME: &str = "commander";

    pub(crate) fn begin(start: &Start, view: &View) -> Self {
        Self {
            ground: Ground::new(view.terrain()),
            trips: Trips::new(start.seed),
            memory: Memory::default(),
            workers: Workers::default(),
            town: Town::default(),
            army: Army::new(start.seed, Search::from_home(start, view), start.can_train()),
        }
    }
}

impl Play for Commander {
    fn play(&mut self, start: &Start, view: &View, delta: &Delta) -> Vec<Command> {
        let scene = start.scene(view);
        self.memory.refresh(&scene);
        self.ground.reveal(&delta.revealed);
        let stands = |item: &&Item<'_>| item.kind.speed == 0.0;
        self.ground.stand(self.memory.with(scene.all().filter(stands)));
        self.trips.keep(|object| scene.own(object).is_some());

        let mut commands = Vec::new();
        if start.can_train() {
            commands.extend(self.town.build((&mut self.ground, &mut self.trips), start, view, &scene));
            commands.extend(self.town.train(start, view, &scene));
        }
        let town = &self.town;
        let is_taken = |object| town.takes(object);
        commands.extend(self.workers.work((&mut self.ground, &mut self.trips), view, &scene, is_taken));
        let mut situation = Situation {
            ground: &mut self.ground,
            trips: &mut self.trips,
            memory: &self.memory,
            view,
            scene: &scene,
            friendly_fire: start.rules.friendly_fire,
        };
        commands.extend(self.army.fight(&mut situation));
        commands
    }
}
