//! Production: building sites, training, costs and prerequisites.

use glam::DVec2;
use maniple_geometry::ObjectId;
use maniple_view::{EndOfTask, Layer, Mode, Refusal, Seat, Shape, UnitTypeId, hull_distance};

use super::approach::{Approach, Goal, TOUCH, approach};
use crate::keyed::Purpose;
use crate::placement::{START_GAP, StartUnit};
use crate::room::{Rings, is_nearer, is_open};
use crate::scenario::{TRAINING_MAX, UNITS_MAX};
use crate::world::{Job, State};

/// Least distance of a building site from everything else, in world units; less than what a builder reaches.
pub(crate) const SITE_GAP: f64 = 1.0 / 64.0;

/// Tells an object to build. What it costs is paid, and whether there is room decided, when it has come there.
pub(crate) fn build(
    state: &mut State,
    object: ObjectId,
    unit_type: UnitTypeId,
    center: DVec2,
) -> Result<(), Refusal> {
    if !state.kind(object).builds.contains(&unit_type) {
        return Err(Refusal::UnknownAction);
    }
    let kind = state.unit_type(unit_type);
    let site = site_at(state, object, unit_type, center);
    let owner = state.units.at(object).owner.ok_or(Refusal::UnknownHandle)?;
    let half = kind.shape.half() + kind.shape.rounding() + SITE_GAP;
    // Who has not seen the place must not learn from the answer what is there.
    let is_known = state.sight.knows(owner, center - half, center + half);
    if site.is_none() && is_known && !is_on_open_ground(state, &kind.shape, center, kind.layer, SITE_GAP) {
        return Err(Refusal::BadPlace);
    }
    let center = site.unwrap_or(center);
    state.set_job(object, Job::Build { unit_type, center, site: None });
    Ok(())
}

/// Returns the centre of a site of a builder's seat that covers a point; what a client knows of it may be rounded.
fn site_at(state: &State, builder: ObjectId, unit_type: UnitTypeId, point: DVec2) -> Option<DVec2> {
    let (owner, shape) = (state.units.at(builder).owner, state.unit_type(unit_type).shape);
    let spot = Shape::Circle { radius: 0.0 };
    let mut centers = state.units.alive().filter_map(|(site, unit)| {
        let is_meant = unit.mode == Mode::Site && unit.owner == owner && unit.unit_type == unit_type;
        is_meant.then(|| state.center(site))
    });
    centers.find(|&center| hull_distance(point - center, &spot, &shape) <= 0.0)
}

/// Tells a building to train a unit behind those that wait; it is paid at once.
pub(crate) fn train(state: &mut State, object: ObjectId, unit_type: UnitTypeId) -> Result<(), Refusal> {
    if !state.kind(object).trains.contains(&unit_type) {
        return Err(Refusal::UnknownAction);
    }
    if state.units.at(object).training.len() >= TRAINING_MAX as usize {
        return Err(Refusal::TrainingFull { max: TRAINING_MAX });
    }
    let owner = state.units.at(object).owner.ok_or(Refusal::UnknownHandle)?;
    pay(state, owner, unit_type).map_err(Unpaid::refusal)?;
    let building = state.units.edit(object);
    if building.training.is_empty() {
        building.made = 0;
    }
    building.training.push(unit_type);
    Ok(())
}

/// Gives up what was ordered last, or a site, and gives back what was paid.
pub(crate) fn cancel(state: &mut State, object: ObjectId) -> Result<(), Refusal> {
    let unit = state.units.at(object);
    let owner = unit.owner.ok_or(Refusal::UnknownHandle)?;
    if unit.mode == Mode::Site {
        let cost = state.kind(object).making.cost;
        if state.given_up.contains(&object) {
            return Err(Refusal::NothingToCancel);
        }
        refund(state, owner, cost);
        state.given_up.push(object);
        return Ok(());
    }
    let last = state.units.edit(object).training.pop().ok_or(Refusal::NothingToCancel)?;
    let cost = state.unit_type(last).making.cost;
    refund(state, owner, cost);
    state.seats[owner.index()].has -= 1;
    Ok(())
}

/// Takes the sites out of the world that have been given up, when all commands are applied: no command sees more of another
/// one than its refund.
pub(crate) fn clear(state: &mut State) {
    for site in std::mem::take(&mut state.given_up) {
        state.remove(site);
    }
}

/// Lets all who are to build go on at the start of a cycle.
pub(crate) fn walk(state: &mut State, busy: &[ObjectId]) {
    for &object in busy {
        let Job::Build { unit_type, center, site } = state.units.at(object).job else { continue };
        if let Some(site) = site {
            if !state.units.is_alive(site) {
                state.end_job(object, EndOfTask::Lost);
            }
            continue;
        }
        let goal = Goal { center, shape: state.unit_type(unit_type).shape, reach: TOUCH };
        if approach(state, object, &goal) == Approach::Blocked {
            state.end_job(object, EndOfTask::Blocked);
        }
    }
}

/// Lets sites be founded, sites and units be worked at, and what is finished appear. The kinematic cycle is over.
pub(crate) fn work(state: &mut State, busy: &[ObjectId]) {
    let mut founders = Vec::new();
    for &object in busy {
        let Job::Build { unit_type, center, site: None } = state.units.at(object).job else { continue };
        let goal = Goal { center, shape: state.unit_type(unit_type).shape, reach: TOUCH };
        if !state.is_moving(object) && goal.is_in_reach(state, object) {
            let fraction = state.stops.get(&object).map_or(0.0, |(moment, _)| moment.fraction);
            founders.push((fraction, state.random(object, Purpose::Precedence), object));
        }
    }
    founders.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    for (.., object) in founders {
        if let Err(why) = found(state, object) {
            state.end_job(object, why);
        }
    }
    work_on_sites(state, busy);
    let mut finished = Vec::new();
    for &object in busy {
        let unit = state.units.at(object);
        let is_switching = matches!(unit.mode, Mode::Switching | Mode::SwitchingBack);
        let Some(&unit_type) = unit.training.first().filter(|_| !is_switching) else { continue };
        let cycles = state.unit_type(unit_type).making.cycles;
        if unit.made < cycles {
            state.units.edit(object).made += 1;
        }
        if state.units.at(object).made >= cycles {
            finished.push((state.random(object, Purpose::Precedence), object));
        }
    }
    finished.sort_unstable();
    for (_, object) in finished {
        release(state, object);
    }
}

/// Founds the site of a builder who is there, or joins one of its seat.
fn found(state: &mut State, builder: ObjectId) -> Result<(), EndOfTask> {
    let unit = state.units.at(builder);
    let Job::Build { unit_type, center, .. } = unit.job else { return Ok(()) };
    let owner = unit.owner.ok_or(EndOfTask::Lost)?;
    let is_meant = |&(id, unit): &(ObjectId, &crate::world::Unit)| {
        unit.owner == Some(owner)
            && unit.unit_type == unit_type
            && unit.mode == Mode::Site
            && state.center(id) == center
    };
    let mut site = state.units.alive().find(is_meant).map(|(id, _)| id);
    if site.is_none() {
        let kind = state.unit_type(unit_type);
        let (shape, layer) = (kind.shape, kind.layer);
        if !has_room(state, &shape, center, layer, Room { gap: SITE_GAP, but: Some(builder) }) {
            return Err(EndOfTask::NoRoom);
        }
        pay(state, owner, unit_type).map_err(Unpaid::end_of_task)?;
        let start = StartUnit { seat: Some(owner), unit_type, position: center, amount: 0 };
        let id = state.add(&start).expect("there is room, and more than a skin of it");
        state.units.edit(id).mode = Mode::Site;
        site = Some(id);
    }
    state.units.edit(builder).job = Job::Build { unit_type, center, site };
    Ok(())
}

/// Lets each site at which somebody works come a cycle further, however many they are.
fn work_on_sites(state: &mut State, busy: &[ObjectId]) {
    let mut sites = Vec::new();
    for &object in busy {
        if let Job::Build { site: Some(site), .. } = state.units.at(object).job {
            sites.push(site);
        }
    }
    sites.sort_unstable();
    sites.dedup();
    let sites_all: Vec<ObjectId> =
        state.units.alive().filter(|(_, unit)| unit.mode == Mode::Site).map(|(id, _)| id).collect();
    for site in sites_all {
        let is_worked_on = sites.binary_search(&site).is_ok();
        if state.units.at(site).is_worked_on != is_worked_on {
            state.units.edit(site).is_worked_on = is_worked_on;
        }
        if !is_worked_on {
            continue;
        }
        let cycles = state.kind(site).making.cycles;
        let unit = state.units.edit(site);
        unit.made += 1;
        if unit.made >= cycles {
            unit.mode = Mode::Normal;
            unit.made = 0;
            unit.is_worked_on = false;
            finish(state, site, busy);
        }
    }
}

/// Counts a finished building and frees its builders.
fn finish(state: &mut State, building: ObjectId, busy: &[ObjectId]) {
    if let Some(owner) = state.units.at(building).owner {
        state.seats[owner.index()].tally.made += 1;
    }
    for &object in busy {
        if matches!(state.units.at(object).job, Job::Build { site: Some(site), .. } if site == building) {
            state.end_job(object, EndOfTask::Done);
        }
    }
}

/// Lets a unit whose training is over appear beside its building; where there is no room it waits for some.
fn release(state: &mut State, building: ObjectId) {
    let unit = state.units.at(building);
    let (Some(owner), Some(&unit_type)) = (unit.owner, unit.training.first()) else { return };
    let Some(position) = place_beside(state, building, unit_type) else { return };
    let start = StartUnit { seat: Some(owner), unit_type, position, amount: 0 };
    state.add(&start).expect("there is room, and more than a skin of it");
    state.seats[owner.index()].tally.made += 1;
    let unit = state.units.edit(building);
    unit.training.remove(0);
    unit.made = 0;
}

/// Returns a place for a unit beside a building: on a lattice as wide as the unit, from the building outwards, and not beyond what
/// the building sees, so that the place says nothing of what is hidden, and on the ground not behind a wall that nobody gets round.
/// `None` where there is no room.
fn place_beside(state: &State, building: ObjectId, unit_type: UnitTypeId) -> Option<DVec2> {
    let (home, house) = (state.center(building), state.kind(building));
    let kind = state.unit_type(unit_type);
    let radius = kind.shape.radius();
    let spacing = 2.0 * radius + START_GAP;
    let reach = house.shape.radius() + house.sight;
    let room = Room { gap: START_GAP, but: None };
    let half = kind.shape.half() + kind.shape.rounding() + START_GAP;
    let owner = state.units.at(building).owner?;
    let region = state.region(home);
    let is_within_reach =
        |point: DVec2| kind.layer == Layer::Air || region.is_none() || state.region(point) == region;
    Rings::new(reach / spacing)
        .map(|(x, y)| home + DVec2::new(f64::from(x), f64::from(y)) * spacing)
        .filter(|&point| hull_distance(point - home, &kind.shape, &house.shape) + spacing <= house.sight)
        .filter(|&point| state.sight.overlooks(owner, point - half, point + half))
        .find(|&point| is_within_reach(point) && has_room(state, &kind.shape, point, kind.layer, room))
}

/// What counts as room.
#[derive(Clone, Copy, Debug)]
struct Room {
    /// Least distance from everything else, hull to hull, in world units.
    gap: f64,
    /// Who may be nearer, though not overlap.
    but: Option<ObjectId>,
}

/// Returns whether a shape has room at a place.
fn has_room(state: &State, shape: &Shape, center: DVec2, layer: Layer, room: Room) -> bool {
    is_on_open_ground(state, shape, center, layer, room.gap)
        && state.units.alive().all(|(other, unit)| {
            let kind = state.unit_type(unit.unit_type);
            let gap = if room.but == Some(other) { SITE_GAP } else { room.gap };
            kind.layer != layer || hull_distance(state.center(other) - center, shape, &kind.shape) >= gap
        })
}

/// Returns whether a shape is clear of walls and within the map at a place; in the air only within the map.
fn is_on_open_ground(state: &State, shape: &Shape, center: DVec2, layer: Layer, gap: f64) -> bool {
    let half = shape.half() + DVec2::splat(shape.rounding() + gap);
    match layer {
        Layer::Ground => {
            let reach = shape.radius() + gap;
            is_open(&state.map, center, half)
                && state.map.free_walls().iter().all(|wall| !is_nearer(center, wall, reach))
        }
        Layer::Air => {
            let (low, high) = (center - half, center + half);
            let (width, height) = (f64::from(state.map.width()), f64::from(state.map.height()));
            low.x >= 0.0 && low.y >= 0.0 && high.x <= width && high.y <= height
        }
    }
}

/// Why a seat cannot have something made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Unpaid {
    /// It lacks a finished building.
    Missing { unit_type: UnitTypeId },
    /// It has as many objects as it may have.
    TooMany,
    /// It lacks resources.
    NotAffordable { cost: u32, stock: u32 },
}

impl Unpaid {
    fn refusal(self) -> Refusal {
        match self {
            Self::Missing { unit_type } => Refusal::Missing { unit_type },
            Self::TooMany => Refusal::TooManyObjects { max: UNITS_MAX },
            Self::NotAffordable { cost, stock } => Refusal::NotAffordable { cost, stock },
        }
    }

    fn end_of_task(self) -> EndOfTask {
        match self {
            Self::Missing { .. } => EndOfTask::Missing,
            Self::TooMany => EndOfTask::TooMany,
            Self::NotAffordable { .. } => EndOfTask::NotAffordable,
        }
    }
}

/// Lets a seat pay for something that it has all that is required for.
fn pay(state: &mut State, seat: Seat, unit_type: UnitTypeId) -> Result<(), Unpaid> {
    let making = &state.unit_type(unit_type).making;
    let cost = making.cost;
    let has = |wanted: UnitTypeId| {
        state
            .units
            .alive()
            .any(|(_, unit)| unit.owner == Some(seat) && unit.unit_type == wanted && unit.mode != Mode::Site)
    };
    if let Some(&unit_type) = making.requires.iter().find(|&&wanted| !has(wanted)) {
        return Err(Unpaid::Missing { unit_type });
    }
    let seat = &mut state.seats[seat.index()];
    if seat.has >= UNITS_MAX {
        return Err(Unpaid::TooMany);
    }
    seat.stock = seat.stock.checked_sub(cost).ok_or(Unpaid::NotAffordable { cost, stock: seat.stock })?;
    seat.has += 1;
    Ok(())
}

fn refund(state: &mut State, seat: Seat, cost: u32) {
    let stock = &mut state.seats[seat.index()].stock;
    *stock = stock.saturating_add(cost);
}
