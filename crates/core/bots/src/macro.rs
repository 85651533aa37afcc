//! The bot that plays the whole game.

mod waves;

use maniple_view::{Command, Delta, View};

use self::waves::Waves;
use crate::economy::{Miners, Plans, Town};
use crate::fighting::{Battle, Force, is_fighter, melee};
use crate::moving::around;
use crate::player::{Play, Start};
use crate::post::Post;
use crate::seeing::{Item, Scene, Search, middle, nearest};

/// Fighters from which on one of them looks for the enemy while the others wait.
const SCOUTED_FROM: usize = 4;

/// Enemies as near to a building as this, in world units, are a threat.
const THREAT: f64 = 14.0;

/// Workers that defend the base: so many for each enemy, and so many more.
const MILITIA: (usize, usize) = (2, 2);

/// How far from home a force waits, as a part of the way to the middle of the map.
const RALLY: f64 = 0.2;

/// Gathers as `gather` does, builds what it takes to train the fighter that is worth most, looks for the enemy, and fights as `focus` does,
/// as far as the scenario lets it.
#[derive(Clone, Debug)]
pub(crate) struct Macro {
    post: Post,
    miners: Miners,
    town: Town,
    /// Those at home, and those who are out.
    guard: Force,
    wave: Force,
    waves: Waves,
    search: Search,
}

impl Macro {
    pub(crate) const NAME: &str = "macro";

    pub(crate) fn begin(start: &Start, view: &View) -> Self {
        Self {
            post: Post::default(),
            miners: Miners::new(start.seed),
            town: Town::default(),
            guard: Force::default(),
            wave: Force::default(),
            waves: Waves::default(),
            search: Search::from_home(start, view),
        }
    }
}

impl Play for Macro {
    fn play(&mut self, start: &Start, view: &View, delta: &Delta) -> Vec<Command> {
        let Self { post, miners, town, guard, wave, waves, search } = self;
        let scene = post.look(start, view);
        let grows = start.can_train();
        let mut commands = Vec::new();
        let threats = threats(&scene);
        let militia = militia(&scene, &threats);
        let serves = |item: &Item<'_>| militia.iter().any(|other| other.object == item.object);
        let is_miner =
            |item: &&Item<'_>| item.kind.harvest.is_some() && !town.takes(item.object) && !serves(item);
        let workers: Vec<&Item<'_>> = scene.own.iter().filter(is_miner).collect();
        commands.extend(miners.work(post, view.cycle(), &scene, &workers));
        if grows {
            let lanes = miners.lanes();
            let plans = Plans { view, start, scene: &scene, lanes: &lanes };
            commands.extend(town.grow(post, plans));
        }

        waves.refresh(view, delta, &scene);
        let fighters = scene.own.iter().filter(|item| is_fighter(item));
        let (away, mut home): (Vec<&Item<'_>>, Vec<&Item<'_>>) =
            fighters.partition(|item| !grows || waves.has(item));
        let size = post.roads.size();
        let rally = search.home() + (size * 0.5 - search.home()) * RALLY;
        let battle = Battle { cycle: view.cycle(), scene: &scene, friendly_fire: start.rules.friendly_fire };
        let known = Search::known(&scene, &post.memory, search.home());
        if known.is_none() && away.is_empty() && home.len() >= SCOUTED_FROM {
            commands.extend(look_around(post, &scene, home.remove(0), search));
        }
        if !away.is_empty() {
            let known = Search::known(&scene, &post.memory, middle(away.iter().copied()));
            let goal = known.unwrap_or_else(|| search.place(size, away.iter().map(|item| item.center)));
            let fallback = grows.then_some(rally);
            commands.extend(wave.fight(post, battle, &away, (goal.center, fallback)));
        }
        let enemies: Vec<Item<'_>> = threats.iter().copied().copied().collect();
        commands.extend(melee(post, (view.cycle(), &scene), &militia, &enemies));
        let goal = nearest(threats.iter().copied(), search.home()).map_or(rally, |threat| threat.center);
        commands.extend(guard.fight(post, battle, &home, (goal, None)));
        commands
    }
}

/// Returns the armed enemies near the buildings of the seat.
fn threats<'a, 'b>(scene: &'b Scene<'a>) -> Vec<&'b Item<'a>> {
    let is_threat = |enemy: &&Item<'_>| enemy.kind.weapon.is_some() && scene.is_near_buildings(enemy, THREAT);
    scene.enemies.iter().filter(is_threat).collect()
}

/// Returns the workers that defend the buildings against who reaches no farther than they do, where fighters are fewer than those: the nearest,
/// by handle.
fn militia<'a, 'b>(scene: &'b Scene<'a>, threats: &[&Item<'_>]) -> Vec<&'b Item<'a>> {
    let range = |item: &Item<'_>| item.kind.weapon.as_ref().map_or(0.0, |weapon| weapon.range);
    let fighters = scene.own.iter().filter(|item| is_fighter(item)).count();
    let is_fit = |item: &&Item<'_>| {
        item.kind.harvest.is_some()
            && item.kind.weapon.is_some()
            && threats.iter().all(|threat| range(threat) <= range(item))
    };
    if fighters >= threats.len() {
        return Vec::new();
    }
    let mut militia: Vec<&Item<'_>> = scene.own.iter().filter(is_fit).collect();
    let distance = |item: &Item<'_>| {
        let threat = nearest(threats.iter().copied(), item.center);
        threat.map_or(f64::INFINITY, |threat| threat.center.distance_squared(item.center))
    };
    militia.sort_by(|one, other| distance(one).total_cmp(&distance(other)));
    militia.truncate(threats.len() * MILITIA.0 + MILITIA.1);
    militia.sort_by_key(|item| item.object);
    militia
}

/// Sends a scout to where the enemy might be.
fn look_around(post: &mut Post, scene: &Scene<'_>, scout: &Item<'_>, search: &mut Search) -> Option<Command> {
    let place = search.place(post.roads.size(), [scout.center]).center;
    if scout.seen.base.is_moving() && post.orders.goal(scout).is_some() {
        return None;
    }
    let ground = post.roads.ground(scout.kind.shape.radius())?;
    let goal = crate::moving::slots_around(&post.roads, &ground, (scout.center, place), 1).pop()?;
    let legs = around(&ground, scene, scout, goal)?;
    let points = legs.iter().map(|leg| (leg.x, leg.y, None)).collect();
    post.orders.give(scout, Command::Path { object: scout.object, points, start: None })
}
