//! Hand to hand: those whose weapons reach hardly beyond their hulls, each to a place of its own beside an enemy.

use glam::DVec2;
use maniple_geometry::{Cycle, Segment};
use maniple_pathfinding::Ground;
use maniple_view::Command;

use super::aim::weapon;
use super::volley::volley;
use crate::moving::{AROUND, around};
use crate::post::Post;
use crate::seeing::{Item, Scene};

/// Most who go at one enemy: a circle has room for six others of its size around it.
const AT_ONE_MAX: usize = 4;

/// Part of the range at which a place beside an enemy is, hull to hull.
const DEPTH: f64 = 0.5;

/// How far an enemy may go, in world units, before who is on its way to it goes elsewhere.
const DRIFT: f64 = 0.75;

/// Most ways around others that are looked for in a cycle: where there are more, somebody may have gone by the next.
const DETOURS_MAX: usize = 2;

/// Returns the commands of a cycle to fighters, by handle, that go at enemies: who has one in range fires at the weakest, the others go to
/// the nearest that not too many go at.
pub(crate) fn melee(
    post: &mut Post,
    (cycle, scene): (Cycle, &Scene<'_>),
    fighters: &[&Item<'_>],
    enemies: &[Item<'_>],
) -> Vec<Command> {
    let targets = volley(fighters, enemies);
    let mut crowding = vec![0; enemies.len()];
    let mut taken: Vec<DVec2> = Vec::new();
    let mut detours = 0;
    let mut commands = Vec::new();
    for &fighter in fighters {
        let object = fighter.object;
        if let Some(&target) = targets.get(&object) {
            commands.extend(post.orders.give(fighter, Command::Attack { object, target }));
            continue;
        }
        let distance = |place: &usize| enemies[*place].center.distance_squared(fighter.center);
        let open = (0..enemies.len()).filter(|&place| crowding[place] < AT_ONE_MAX);
        let Some(nearest) = open.min_by(|one, other| distance(one).total_cmp(&distance(other))) else {
            continue;
        };
        crowding[nearest] += 1;
        let enemy = &enemies[nearest];
        let is_on_its_way = fighter.seen.base.is_moving()
            && post
                .orders
                .goal(fighter)
                .is_some_and(|goal| reach(fighter, enemy) + DRIFT > goal.distance(enemy.center));
        if is_on_its_way {
            continue;
        }
        let Some(ground) = post.roads.ground(fighter.kind.shape.radius()) else { continue };
        let places = places((&ground, scene), fighter, enemy, &taken);
        let Some(&place) = places.first() else { continue };
        let straight = places.iter().copied().find(|&place| is_open((&ground, scene), fighter, place));
        let legs = match straight {
            Some(place) => Some(vec![place]),
            None if detours < DETOURS_MAX && cycle.0.wrapping_add(object.0).is_multiple_of(2) => {
                detours += 1;
                around(&ground, scene, fighter, place)
            }
            None => None,
        };
        let Some(legs) = legs else { continue };
        taken.extend(legs.last());
        let points = legs.iter().map(|leg| (leg.x, leg.y, None)).collect();
        commands.extend(post.orders.give(fighter, Command::Path { object, points, start: None }));
    }
    commands
}

/// Returns how far from the middle of an enemy a fighter stands that goes at it.
fn reach(fighter: &Item<'_>, enemy: &Item<'_>) -> f64 {
    let range = weapon(fighter).map_or(0.0, |weapon| weapon.range);
    fighter.kind.shape.radius() + enemy.kind.shape.radius() + range * DEPTH
}

/// Returns the places beside an enemy that nobody has taken, the nearest first.
fn places(
    (ground, scene): (&Ground, &Scene<'_>),
    fighter: &Item<'_>,
    enemy: &Item<'_>,
    taken: &[DVec2],
) -> Vec<DVec2> {
    let reach = reach(fighter, enemy);
    let radius = fighter.kind.shape.radius();
    let is_free = |place: &DVec2| {
        let is_apart = |other: &Item<'_>| {
            other.object == fighter.object
                || other.object == enemy.object
                || !other.is_in_the_way()
                || other.center.distance(*place) > radius + other.kind.shape.radius()
        };
        ground.holds(*place)
            && taken.iter().all(|other| other.distance(*place) > 2.0 * radius)
            && scene.all().all(is_apart)
    };
    let mut places: Vec<DVec2> = AROUND
        .iter()
        .map(|&direction| enemy.center + DVec2::from(direction) * reach)
        .filter(is_free)
        .collect();
    let distance = |place: &DVec2| place.distance_squared(fighter.center);
    places.sort_by(|one, other| distance(one).total_cmp(&distance(other)));
    places
}

/// Returns whether a fighter gets straight to a place past walls and all who rest.
fn is_open((ground, scene): (&Ground, &Scene<'_>), fighter: &Item<'_>, place: DVec2) -> bool {
    let line: Segment = Segment::new(fighter.center, place);
    let is_apart = |other: &Item<'_>| {
        let is_behind = (other.center - fighter.center).dot(place - fighter.center) <= 0.0;
        let distance = line.nearest(other.center).distance(other.center);
        is_behind || distance > fighter.kind.shape.radius() + other.kind.shape.radius()
    };
    let others = scene.all().filter(|other| other.object != fighter.object && other.is_in_the_way());
    ground.is_clear(fighter.center, place) && others.into_iter().all(is_apart)
}

#[cfg(test)]
mod tests {
    use maniple_view::Terrain;

    use super::*;
    use crate::test_items::{armed, item, resting};

    #[test]
    fn each_goes_to_a_place_of_its_own_in_reach_of_the_enemy() {
        let terrain =
            Terrain { width: 20, height: 10, tiles: vec![".".repeat(20); 10], segments: Vec::new() };
        let ground = Ground::new(&terrain.map().unwrap(), 0.5).unwrap();
        let kind = armed(0.125);
        let (own, other) = (resting(5.0, 100), resting(10.0, 100));
        let (fighter, enemy) = (item(0, &own, &kind), item(1, &other, &kind));
        let scene = Scene { enemies: vec![enemy], ..Scene::default() };
        let mut taken = Vec::new();
        while let Some(&place) = places((&ground, &scene), &fighter, &enemy, &taken).first() {
            let gap = place.distance(enemy.center) - 1.0;
            assert!(gap > 0.0 && gap < 0.125, "{place}");
            assert!(taken.iter().all(|other: &DVec2| other.distance(place) > 1.0), "{place} {taken:?}");
            taken.push(place);
        }
        // The nearest first.
        assert_eq!(taken[0], DVec2::new(10.0 - 1.0625, 5.0));
        assert!(taken.len() >= AT_ONE_MAX, "{taken:?}");
    }

    #[test]
    fn who_rests_between_closes_the_straight_way_and_who_is_behind_does_not() {
        let terrain =
            Terrain { width: 20, height: 10, tiles: vec![".".repeat(20); 10], segments: Vec::new() };
        let ground = Ground::new(&terrain.map().unwrap(), 0.5).unwrap();
        let kind = armed(0.125);
        let check = |x: f64, expected: bool| {
            let (own, other) = (resting(5.0, 100), resting(x, 100));
            let (fighter, between) = (item(0, &own, &kind), item(1, &other, &kind));
            let scene = Scene { own: vec![fighter, between], ..Scene::default() };
            assert_eq!(is_open((&ground, &scene), &fighter, DVec2::new(10.0, 5.0)), expected, "{x}");
        };
        check(7.0, false);
        check(10.5, false);
        check(11.25, true);
        check(3.5, true);
    }
}
