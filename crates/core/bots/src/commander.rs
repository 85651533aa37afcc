//! The bot that plays by every rule a scenario has.

mod army;
mod ground;
mod town;
mod trips;
mod workers;

use maniple_view::{Command, Delta, Rules, Seat, Terrain, View};

use crate::bot::Bot;
use crate::seeing::{Block, Item, Memory, Scene, middle};
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
pub struct Commander {
    seed: u64,
    seat: Seat,
    rules: Option<Rules>,
    ground: Ground,
    trips: Trips,
    memory: Memory,
    workers: Workers,
    town: Town,
    /// From the first view on.
    army: Option<Army>,
}

impl Commander {
    pub(crate) const NAME: &str = "commander";

    /// Returns the bot; it has to be started.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self {
            seed,
            seat: Seat(0),
            rules: None,
            ground: Ground::default(),
            trips: Trips::new(seed),
            memory: Memory::default(),
            workers: Workers::default(),
            town: Town::default(),
            army: None,
        }
    }
}

impl Bot for Commander {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn on_start(&mut self, seat: Seat, rules: &Rules, terrain: &Terrain) {
        *self =
            Self { seat, rules: Some(rules.clone()), ground: Ground::new(terrain), ..Self::new(self.seed) };
    }

    fn on_cycle(&mut self, view: &View, delta: &Delta) -> Vec<Command> {
        let Some(rules) = &self.rules else { return Vec::new() };
        let scene = Scene::of(view, rules, self.seat);
        self.memory.refresh(&scene);
        self.ground.reveal(&delta.revealed);
        let stands = |item: &&Item<'_>| item.kind.speed == 0.0;
        let blocks = scene.all().filter(stands).map(Item::block);
        let mut blocks: Vec<Block> = blocks.chain(self.memory.blocks().copied()).collect();
        blocks.sort_by(|one, other| {
            (one.center.y.total_cmp(&other.center.y)).then(one.center.x.total_cmp(&other.center.x))
        });
        blocks.dedup();
        self.ground.stand(blocks);
        self.trips.keep(|object| scene.own(object).is_some());

        let can_train = rules.unit_types.iter().any(|kind| !kind.trains.is_empty());
        let mut commands = Vec::new();
        if can_train {
            commands.extend(self.town.build((&mut self.ground, &mut self.trips), view, rules, &scene));
            commands.extend(town::train(&self.town, (self.seed, view), rules, &scene));
        }
        let town = &self.town;
        let is_taken = |object| town.takes(object);
        commands.extend(self.workers.work((&mut self.ground, &mut self.trips), view, &scene, is_taken));
        let army = self.army.get_or_insert_with(|| Army::new(self.seed, middle(&scene.own), can_train));
        let mut situation = Situation {
            ground: &mut self.ground,
            trips: &mut self.trips,
            memory: &self.memory,
            view,
            scene: &scene,
            friendly_fire: rules.friendly_fire,
        };
        commands.extend(army.fight(&mut situation));
        commands
    }
}
