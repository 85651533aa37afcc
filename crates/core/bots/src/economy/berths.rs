//! Berths: a place beside a patch and one beside a building that takes loads, for one worker to go to and fro between them.

use glam::DVec2;
use maniple_pathfinding::{Ground, Planner, length};
use maniple_view::Handle;

use crate::moving::AROUND;
use crate::seeing::{Block, Item, nearest_point};

/// How far from a hull a place beside it is, in world units: half of what counts as in reach.
const BESIDE: f64 = 1.0 / 32.0;

/// Room between two workers in places side by side, as a part of their diameter.
const GAP: f64 = 0.2;

/// Most docks of a store that are compared for one place, nearest first.
const DOCKS_COMPARED: usize = 4;

/// A place beside a patch and one beside a store.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Berth {
    pub(crate) patch: Handle,
    /// Beside the patch.
    pub(crate) place: DVec2,
    pub(crate) store: Handle,
    /// Beside the store.
    pub(crate) dock: DVec2,
    /// Of the way from one to the other, in world units.
    pub(crate) length: f64,
}

/// Returns the berths of all patches that can be reached, the shortest first: no more for each patch than it has places, none nearer to
/// one of those that are `taken` than two workers have room, and no dock twice.
pub(crate) fn berths(
    ground: &Ground,
    patches: &[&Item<'_>],
    stores: &[&Item<'_>],
    taken: &[Berth],
) -> Vec<Berth> {
    let docks: Vec<(Handle, DVec2)> = stores.iter().flat_map(|store| docks(ground, store)).collect();
    let apart = 2.0 * ground.radius() * (1.0 + GAP);
    let mut places: Vec<(f64, Handle, DVec2)> = Vec::new();
    for patch in patches {
        for place in places_around(ground, patch, patches) {
            let nearest = docks.iter().map(|(_, dock)| dock.distance_squared(place));
            let nearest = nearest.fold(f64::INFINITY, |least, it| if it < least { it } else { least });
            places.push((nearest, patch.object, place));
        }
    }
    places.sort_by(|one, other| {
        one.0.total_cmp(&other.0).then(one.2.y.total_cmp(&other.2.y)).then(one.2.x.total_cmp(&other.2.x))
    });
    let mut all = taken.to_vec();
    for (_, object, place) in places {
        let patch_places = patches.iter().find(|patch| patch.object == object);
        let most = patch_places.and_then(|patch| patch.kind.patch_places).unwrap_or(0) as usize;
        let is_full = all.iter().filter(|berth| berth.patch == object).count() >= most;
        if is_full || all.iter().any(|berth| berth.place.distance(place) < apart) {
            continue;
        }
        let free =
            docks.iter().filter(|(_, dock)| all.iter().all(|berth| berth.dock.distance(*dock) > BESIDE));
        let mut free: Vec<(Handle, DVec2)> = free.copied().collect();
        free.sort_by(|one, other| {
            one.1
                .distance_squared(place)
                .total_cmp(&other.1.distance_squared(place))
                .then(one.0.cmp(&other.0))
        });
        let ways = free.iter().take(DOCKS_COMPARED).filter_map(|&(store, dock)| {
            let length = way_length(ground, dock, place)?;
            Some(Berth { patch: object, place, store, dock, length })
        });
        all.extend(ways.min_by(|one, other| one.length.total_cmp(&other.length)));
    }
    let mut berths = all.split_off(taken.len());
    berths.sort_by(|one, other| {
        one.length.total_cmp(&other.length).then((one.patch, one.store).cmp(&(other.patch, other.store)))
    });
    berths
}

fn way_length(ground: &Ground, from: DVec2, to: DVec2) -> Option<f64> {
    if ground.is_clear(from, to) {
        return Some(from.distance(to));
    }
    Planner::new(ground).path(from, to).ok().map(|legs| length(from, legs))
}

/// Returns the places all around a patch that have room between walls and patches.
fn places_around(ground: &Ground, patch: &Item<'_>, patches: &[&Item<'_>]) -> Vec<DVec2> {
    let touching = |other: &Item<'_>| other.kind.shape.radius() + ground.radius();
    let reach = touching(patch) + BESIDE;
    let places = AROUND.iter().map(|&direction| patch.center + DVec2::from(direction) * reach);
    let is_free = |place: &DVec2| {
        ground.holds(*place)
            && patches.iter().all(|other| {
                other.object == patch.object || other.center.distance(*place) > touching(other) + BESIDE
            })
    };
    places.filter(is_free).collect()
}

/// Returns the places along the sides of a store, as near to each other as workers have room.
fn docks(ground: &Ground, store: &Item<'_>) -> Vec<(Handle, DVec2)> {
    let Block { center, half } = store.block();
    let out = half + DVec2::splat(ground.radius() + BESIDE);
    let apart = 2.0 * ground.radius() * (1.0 + GAP);
    let mut docks = Vec::new();
    for (along, across) in [(DVec2::X, DVec2::Y), (DVec2::Y, DVec2::X)] {
        let length = 2.0 * half.dot(along);
        let count = steps(length, apart);
        for number in 0..=count {
            let offset = along * (length * (f64::from(number) / f64::from(count)) - length * 0.5);
            docks.extend([-1.0, 1.0].map(|side| center + offset + across * (out * side).dot(across)));
        }
    }
    // The corners are reached from both sides.
    docks.retain(|&dock| {
        let hull = nearest_point(&store.block(), dock);
        ground.holds(dock) && hull.distance(dock) <= ground.radius() + 2.0 * BESIDE
    });
    docks.into_iter().map(|dock| (store.object, dock)).collect()
}

/// Returns how many whole steps fit along a length; at least one.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "not negative; saturates")]
fn steps(length: f64, step: f64) -> u32 {
    ((length / step) as u32).max(1)
}
