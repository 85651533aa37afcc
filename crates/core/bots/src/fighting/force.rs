//! Fighters that go and fight together.

use glam::DVec2;
use maniple_geometry::{Cycle, Scalar};
use maniple_pathfinding::Planner;
use maniple_view::{Command, Mode};

use super::aim::{alternate_weapon, is_in_range, is_ready, weapon};
use super::retreat::step_back;
use super::siege::{Siege, Sieges, deploy};
use super::volley::volley;
use crate::moving::Advance;
use crate::post::Post;
use crate::seeing::{Item, Scene, middle, nearest};

/// So near to a fighter, hull to hull in world units, an armed enemy is met.
const CONTACT: f64 = 11.0;

/// How far a force goes at once before it gathers again, in world units.
const BOUND: f64 = 10.0;

/// A force is together where so many of so many are near its middle.
const TOGETHER: (usize, usize) = (3, 4);

/// How many times as strong an enemy is from whom a force flees.
const OUTMATCHED: f64 = 1.5;

/// How many times as strong it has to be where the force is at it already: who turns its back is fired at, and does not fire.
const OUTMATCHED_ENGAGED: f64 = 3.0;

/// How many units a shot with a splash counts for.
const SPLASH: f64 = 2.0;

/// Cycles that a force waits to be together before it goes on as it is.
const PATIENCE: u32 = 200;

/// How much nearer an enemy comes, in world units, while a unit switches its mode.
const CLOSING: f64 = 4.0;

/// What a force sees at the start of a cycle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Battle<'a, 'b> {
    pub(crate) cycle: Cycle,
    pub(crate) scene: &'b Scene<'a>,
    /// Whether splash hurts the own team, too.
    pub(crate) friendly_fire: bool,
}

/// Fighters that gather, go on in bounds, concentrate their fire, keep their range and take back who is hurt.
#[derive(Clone, Debug, Default)]
pub(crate) struct Force {
    advance: Advance,
    /// Where it gathers or goes next.
    stage: Option<Stage>,
    sieges: Sieges,
}

/// Where a force goes next, and since when.
#[derive(Clone, Copy, Debug)]
struct Stage {
    point: DVec2,
    since: u32,
}

impl Force {
    /// Returns the commands of a cycle for fighters that shall get to a goal and fight whoever they meet; where they are outmatched they
    /// go to the fallback, if there is one.
    pub(crate) fn fight(
        &mut self,
        post: &mut Post,
        battle: Battle<'_, '_>,
        fighters: &[&Item<'_>],
        (goal, fallback): (DVec2, Option<DVec2>),
    ) -> Vec<Command> {
        let Battle { cycle, scene, .. } = battle;
        self.sieges.refresh(scene);
        let shooters: Vec<&Item<'_>> =
            fighters.iter().copied().filter(|item| is_ready(item, cycle) && is_direct(item)).collect();
        let targets = volley(&shooters, &scene.enemies);
        let flight = fallback.filter(|_| is_outmatched(fighters, scene));
        let point = match flight {
            Some(fallback) => fallback,
            None => self.point(post, battle, fighters, goal),
        };
        let mut commands = Vec::new();
        let mut marchers = Vec::new();
        for &item in fighters {
            let command = match item.seen.status.mode {
                Mode::Switching | Mode::SwitchingBack | Mode::Site => None,
                Mode::Alternate => self.besiege(battle, item, point),
                Mode::Normal => {
                    if let Some(switch) = deploy(item, &scene.enemies, CLOSING) {
                        Some(switch)
                    } else if flight.is_some() && is_far(item, point) {
                        marchers.push(item.object);
                        None
                    } else if let Some(&target) = targets.get(&item.object) {
                        Some(Command::Attack { object: item.object, target })
                    } else {
                        let has = has_in_range(item, scene);
                        let back = if has { reload(post, battle, item) } else { None };
                        if back.is_none() && !steps_back(post, item) && !has {
                            marchers.push(item.object);
                        }
                        back
                    }
                }
            };
            commands.extend(command.and_then(|command| post.orders.give(item, command)));
        }
        let Post { roads, orders, .. } = post;
        let mobile: Vec<&Item<'_>> =
            fighters.iter().copied().filter(|item| item.seen.status.mode == Mode::Normal).collect();
        for command in self.advance.lead(roads, (cycle, scene), (&mobile, &marchers), point) {
            let item = command.object().and_then(|object| scene.own(object));
            commands.extend(item.and_then(|item| orders.give(item, command)));
        }
        commands
    }

    /// Returns where all go who have nobody in range.
    fn point(
        &mut self,
        post: &mut Post,
        battle: Battle<'_, '_>,
        fighters: &[&Item<'_>],
        goal: DVec2,
    ) -> DVec2 {
        let center = middle(fighters.iter().copied());
        let meets = |enemy: &&Item<'_>| {
            weapon(enemy).is_some() && fighters.iter().any(|item| item.distance(enemy) < CONTACT)
        };
        if let Some(enemy) = nearest(battle.scene.enemies.iter().filter(meets), center) {
            self.stage = None;
            let deployed = |item: &&&Item<'_>| item.seen.status.mode == Mode::Alternate;
            let mut deployed = fighters.iter().filter(deployed).copied().peekable();
            return if deployed.peek().is_some() { middle(deployed) } else { enemy.center };
        }
        let now = battle.cycle.0;
        let is_together = is_together(fighters, center);
        match self.stage {
            Some(stage) if now < stage.since + PATIENCE => {
                let is_there = is_together && center.distance(stage.point) < BOUND * 0.5;
                if !is_there {
                    return stage.point;
                }
            }
            Some(_) | None => {}
        }
        let is_late = self.stage.is_some_and(|stage| now >= stage.since + PATIENCE);
        let point = if is_together || is_late {
            bound(post, fighters, center, goal)
        } else {
            nearest(fighters.iter().copied(), center).map_or(center, |item| item.center)
        };
        self.stage = Some(Stage { point, since: now });
        point
    }

    /// Fires from the other mode at where it hits most; goes back when there has been nobody in range for a while, and the force is
    /// elsewhere.
    fn besiege(&mut self, battle: Battle<'_, '_>, item: &Item<'_>, point: DVec2) -> Option<Command> {
        let Battle { cycle, scene, friendly_fire } = battle;
        let object = item.object;
        let reach = alternate_weapon(item.kind)?.range;
        match self.sieges.next(item, scene, cycle, friendly_fire)? {
            Siege::Fire(point) => Some(Command::AttackAt { object, x: point.x, y: point.y }),
            Siege::Spare => Some(Command::Stop { object }),
            Siege::Over => (item.center.distance(point) > reach).then_some(Command::Switch { object }),
            Siege::Wait => None,
        }
    }
}

/// Returns whether the enemies near a force are so much stronger that it should not fight: by the damage a cycle of each side times its hit
/// points (Lanchester, *Aircraft in Warfare*, 1916).
fn is_outmatched(fighters: &[&Item<'_>], scene: &Scene<'_>) -> bool {
    let meets = |enemy: &&Item<'_>| fighters.iter().any(|item| item.distance(enemy) < CONTACT);
    let enemies = strength(scene.enemies.iter().filter(meets));
    let is_engaged = fighters.iter().any(|item| has_in_range(item, scene));
    let factor = if is_engaged { OUTMATCHED_ENGAGED } else { OUTMATCHED };
    enemies > strength(fighters.iter().copied()) * factor
}

/// Returns the damage a cycle of all times the hit points of all.
fn strength<'a, 'b>(items: impl Iterator<Item = &'b Item<'a>>) -> f64
where
    'a: 'b,
{
    let (mut damage, mut left) = (0.0, 0.0);
    for item in items {
        let weapon = weapon(item).or(item.kind.weapon.as_ref());
        let Some(weapon) = weapon else { continue };
        let splash = if weapon.splash.is_some() { SPLASH } else { 1.0 };
        damage +=
            splash * f64::from(weapon.damage_min.midpoint(weapon.damage_max)) / f64::from(weapon.cooldown);
        left += f64::from(item.seen.status.hit_points.unwrap_or(0));
    }
    damage * left
}

/// Returns whether a unit has to go on to get to where all flee to.
fn is_far(item: &Item<'_>, point: DVec2) -> bool {
    item.center.distance(point) > BOUND * 0.5
}

/// Returns what a unit does that has somebody in range and reloads.
fn reload(post: &mut Post, battle: Battle<'_, '_>, item: &Item<'_>) -> Option<Command> {
    let ready = item.seen.own?.ready.0;
    if steps_back(post, item) {
        return None;
    }
    let ground = post.roads.ground(item.kind.shape.radius())?;
    step_back(item, &battle.scene.enemies, &ground, (battle.cycle.0, ready))
}

/// Returns whether a unit is stepping back.
fn steps_back(post: &Post, item: &Item<'_>) -> bool {
    item.seen.base.is_moving() && matches!(post.orders.told(item), Some(Command::Move { .. }))
}

/// Returns whether it fires at objects, in the mode in which it goes.
fn is_direct(item: &Item<'_>) -> bool {
    item.seen.status.mode == Mode::Normal
}

fn has_in_range(item: &Item<'_>, scene: &Scene<'_>) -> bool {
    weapon(item).is_some_and(|weapon| scene.enemies.iter().any(|enemy| is_in_range(item, enemy, weapon)))
}

/// Returns whether most fighters are near their middle: nearer than one and a half times the radius of a disc that they fill.
fn is_together(fighters: &[&Item<'_>], center: DVec2) -> bool {
    let widest = fighters.iter().fold(0.0, |most: f64, item| most.greater(item.kind.shape.radius()));
    let reach = 3.0 + 2.0 * widest * (fighters.len() as f64).sqrt();
    let near = fighters.iter().filter(|item| item.center.distance(center) < reach).count();
    near * TOGETHER.1 >= fighters.len() * TOGETHER.0
}

/// Returns the point on the way to a goal that is a bound ahead of the middle of a force, or the goal.
fn bound(post: &mut Post, fighters: &[&Item<'_>], center: DVec2, goal: DVec2) -> DVec2 {
    let widest = fighters.iter().fold(0.0, |most: f64, item| most.greater(item.kind.shape.radius()));
    let Some(ground) = post.roads.ground(widest) else { return goal };
    let Some(first) = nearest(fighters.iter().copied(), center) else { return goal };
    let Some(end) = crate::moving::slots_around(&post.roads, &ground, (first.center, goal), 1).pop() else {
        return goal;
    };
    let mut planner = Planner::new(&ground);
    let Ok(legs) = planner.path(first.center, end) else { return goal };
    let (mut here, mut left) = (first.center, BOUND);
    for &leg in legs {
        let length = here.distance(leg);
        if length > left {
            return here + (leg - here) * (left / length);
        }
        left -= length;
        here = leg;
    }
    goal
}
