//! Who sees what.

mod knowledge;
mod objects;
mod shadow;
mod stamp;

use std::sync::Arc;

use glam::DVec2;
use maniple_geometry::ObjectId;
use maniple_tilemap::{TileMap, TileShape};
use maniple_view::{Seat, TerrainKnowledge, TileSet};

use crate::scenario::Vision;
use knowledge::{Knowledge, Survey};
use shadow::Shadows;
use stamp::{Scene, Stamp};

pub(crate) use knowledge::Wall;
pub(crate) use objects::Visible;

/// What each seat sees, and saw at the start of the last cycle.
#[derive(Clone, Debug)]
pub(crate) enum Sight {
    /// Everything.
    Perfect,
    /// What is in sight of the seat's team.
    Fog(Box<Fog>),
}

impl Sight {
    /// Takes a look.
    pub(crate) fn look(&mut self, objects: &[Visible]) {
        match self {
            Self::Perfect => {}
            Self::Fog(fog) => fog.look(objects),
        }
    }

    /// Returns whether a seat sees an object that is alive.
    pub(crate) fn sees(&self, seat: Seat, object: ObjectId) -> bool {
        match self {
            Self::Perfect => true,
            Self::Fog(fog) => fog.team(seat).now.binary_search(&object).is_ok(),
        }
    }

    /// Returns whether a seat saw an object at the start of the last cycle that was alive then.
    pub(crate) fn saw(&self, seat: Seat, object: ObjectId) -> bool {
        match self {
            Self::Perfect => true,
            Self::Fog(fog) => fog.team(seat).before.binary_search(&object).is_ok(),
        }
    }

    /// Returns whether a seat knows all tiles under a rectangle, as far as they are on the map.
    pub(crate) fn knows(&self, seat: Seat, low: DVec2, high: DVec2) -> bool {
        let Self::Fog(fog) = self else { return true };
        let Some(knowledge) = &fog.team(seat).knowledge else { return true };
        fog.tiles(low, high).all(|(x, y)| knowledge.is_known(x, y))
    }

    /// Returns whether all tiles under a rectangle are visible to a seat, as far as they are on the map.
    pub(crate) fn overlooks(&self, seat: Seat, low: DVec2, high: DVec2) -> bool {
        let Self::Fog(fog) = self else { return true };
        fog.tiles(low, high).all(|(x, y)| fog.team(seat).visible.contains(x, y))
    }

    /// Returns the tiles that are visible to a seat; `None`: all, there is no fog.
    pub(crate) fn visible(&self, seat: Seat) -> Option<&TileSet> {
        match self {
            Self::Perfect => None,
            Self::Fog(fog) => Some(&fog.team(seat).visible),
        }
    }

    /// Returns the tiles that a seat knows; `None`: all, from the start.
    pub(crate) fn known(&self, seat: Seat) -> Option<&TileSet> {
        match self {
            Self::Perfect => None,
            Self::Fog(fog) => fog.team(seat).knowledge.as_ref().map(Knowledge::known),
        }
    }

    /// Returns what each team has explored, in the order of their numbers, as runs of tiles; nothing where all is known. All else
    /// follows from where everybody is.
    pub(crate) fn explored(&self) -> Vec<Vec<(u32, u32)>> {
        match self {
            Self::Perfect => Vec::new(),
            Self::Fog(fog) => {
                let known = fog.teams.iter().filter_map(|team| team.knowledge.as_ref());
                known.map(|knowledge| knowledge.known().to_runs()).collect()
            }
        }
    }

    /// Takes what each team has explored; `None` where these are other teams, or no tiles of the map.
    pub(crate) fn restore(&mut self, explored: &[Vec<(u32, u32)>]) -> Option<()> {
        let knowledge: Vec<&mut Knowledge> = match self {
            Self::Perfect => Vec::new(),
            Self::Fog(fog) => fog.teams.iter_mut().filter_map(|team| team.knowledge.as_mut()).collect(),
        };
        if knowledge.len() != explored.len() {
            return None;
        }
        knowledge.into_iter().zip(explored).try_for_each(|(knowledge, runs)| knowledge.restore(runs))
    }

    /// Returns the tiles that a seat saw for the first time when it looked last, and the walls.
    pub(crate) fn news(&self, seat: Seat) -> (&[(u32, u32, String)], &[Wall]) {
        match self {
            Self::Perfect => (&[], &[]),
            Self::Fog(fog) => {
                let knowledge = fog.team(seat).knowledge.as_ref();
                knowledge.map_or((&[], &[]), |knowledge| (&knowledge.revealed, &knowledge.walls))
            }
        }
    }
}

/// What teams see where there is fog.
#[derive(Clone, Debug)]
pub(crate) struct Fog {
    map: Arc<TileMap>,
    /// The tiles that block sight; `None`: nothing does.
    blocked: Option<TileSet>,
    /// What there is to be explored; `None`: everything is known.
    survey: Option<Survey>,
    /// By number.
    teams: Vec<Team>,
    /// The place of each seat's team among them.
    places: Vec<usize>,
    /// What each object sees, by its number.
    stamps: Vec<Stamp>,
    shadows: Shadows,
}

/// What a team sees.
#[derive(Clone, Debug)]
struct Team {
    number: u16,
    /// The objects that it sees, in ascending order.
    now: Vec<ObjectId>,
    /// Those that it saw when it looked the time before.
    before: Vec<ObjectId>,
    visible: TileSet,
    /// How many objects saw for it when it looked last.
    eyes: usize,
    /// `None`: all terrain is known.
    knowledge: Option<Knowledge>,
}

impl Fog {
    /// Returns what is seen by seats of these teams, nothing yet.
    pub(crate) fn new(vision: &Vision, map: &Arc<TileMap>, seats: &[u16]) -> Self {
        let is_explored = vision.terrain == TerrainKnowledge::Explored;
        let mut numbers = seats.to_vec();
        numbers.sort_unstable();
        numbers.dedup();
        let team = |&number: &u16| Team {
            number,
            now: Vec::new(),
            before: Vec::new(),
            visible: TileSet::new(map.width(), map.height()),
            eyes: 0,
            knowledge: is_explored.then(|| Knowledge::new(map)),
        };
        let place = |team| numbers.binary_search(team).expect("each team is in the list");
        Self {
            blocked: vision.walls_block.then(|| blocked(map)),
            survey: is_explored.then(|| Survey::new(map)),
            places: seats.iter().map(place).collect(),
            teams: numbers.iter().map(team).collect(),
            stamps: Vec::new(),
            shadows: Shadows::default(),
            map: Arc::clone(map),
        }
    }

    /// Returns the objects that a seat sees, in ascending order.
    pub(crate) fn objects(&self, seat: Seat) -> &[ObjectId] {
        &self.team(seat).now
    }

    /// Returns the tiles under a rectangle.
    fn tiles(&self, low: DVec2, high: DVec2) -> impl Iterator<Item = (u32, u32)> + use<> {
        let ((left, top), (right, bottom)) = (self.map.tile_at(low), self.map.tile_at(high));
        (top..=bottom).flat_map(move |y| (left..=right).map(move |x| (x, y)))
    }

    fn team(&self, seat: Seat) -> &Team {
        &self.teams[self.places[seat.index()]]
    }

    fn look(&mut self, objects: &[Visible]) {
        self.look_at_tiles(objects);
        let bucket = objects::bucket(objects);
        for team in &mut self.teams {
            let hides = self.blocked.as_ref().map(|_| &team.visible);
            let eyes = objects::Eyes::of(team.number, objects, bucket);
            std::mem::swap(&mut team.before, &mut team.now);
            team.now.clear();
            let is_seen = |object: &&Visible| {
                eyes.see(object) && hides.is_none_or(|visible| is_on(object, visible, &self.map))
            };
            let seen = objects.iter().filter(|object| object.team == Some(team.number) || is_seen(object));
            team.now.extend(seen.map(|object| object.object));
        }
    }

    fn look_at_tiles(&mut self, objects: &[Visible]) {
        let scene = Scene { map: &self.map, blocked: self.blocked.as_ref() };
        let last = objects.last().map_or(0, |object| object.object.0 as usize + 1);
        if self.stamps.len() < last {
            self.stamps.resize_with(last, Stamp::default);
        }
        for team in &mut self.teams {
            let (mut eyes, mut is_stale) = (0, false);
            let own = || objects.iter().filter(|object| object.team == Some(team.number));
            for object in own() {
                eyes += 1;
                is_stale |= self.stamps[object.object.0 as usize].look(object, &scene, &mut self.shadows);
            }
            if let Some(knowledge) = &mut team.knowledge {
                knowledge.settle();
            }
            // Who is new has a new stamp; where none has and as many look as before, all are the same.
            if !is_stale && team.eyes == eyes {
                continue;
            }
            team.eyes = eyes;
            team.visible.clear();
            for object in own() {
                self.stamps[object.object.0 as usize].insert_into(&mut team.visible);
            }
            if let (Some(knowledge), Some(survey)) = (&mut team.knowledge, &self.survey) {
                knowledge.explore(&team.visible, &self.map, survey);
            }
        }
    }
}

/// Returns the tiles that block sight: those that are blocked as a whole. Through the open half of others one looks.
fn blocked(map: &TileMap) -> TileSet {
    let mut blocked = TileSet::new(map.width(), map.height());
    for (number, tile) in (0..).zip(map.tiles()) {
        if tile.shape == TileShape::Blocked {
            blocked.insert_run(number, 1);
        }
    }
    blocked
}

/// Returns whether an object covers or touches a tile of a set.
fn is_on(object: &Visible, tiles: &TileSet, map: &TileMap) -> bool {
    let (half, radius) = (object.shape.half(), object.shape.rounding());
    let (left, top) = map.tile_at(object.center - half - radius);
    // Whose hull ends on the edge of a tile touches the one before, too.
    let (left, top) = (left.saturating_sub(1), top.saturating_sub(1));
    let (right, bottom) = map.tile_at(object.center + half + radius);
    let covers = |x: u32, y: u32| {
        let middle = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let beyond = (object.center - middle).abs() - half - 0.5;
        let beyond = DVec2::new(positive(beyond.x), positive(beyond.y));
        beyond.length_squared() <= radius * radius
    };
    (top..=bottom).any(|y| (left..=right).any(|x| tiles.contains(x, y) && covers(x, y)))
}

fn positive(value: f64) -> f64 {
    if value > 0.0 { value } else { 0.0 }
}

#[cfg(test)]
mod tests;
