//! Maps that follow from a seed.

mod canvas;
mod choke;
mod cliffs;
mod clusters;
mod dice;
mod error;
mod islands;
mod kind;
mod maze;
mod noise;
mod obstacles;
mod slopes;
mod spawns;
#[cfg(test)]
mod tests;
mod ways;

use glam::DVec2;

use crate::map::Builder;
use crate::{Resource, Spawn, TileMap, TileShape};

use canvas::{Canvas, Spot};
use dice::Dice;
pub use error::GenerateError;
pub use kind::Kind;
use slopes::slopes;
use ways::Ways;

/// Least width and height of a generated map, in tiles: smaller ones have no room for a spawn and what is around it.
pub const GENERATED_SIDE_MIN: u32 = 16;

/// Largest width and height of a generated map, in tiles: the time grows with the area times the number of islands.
pub const GENERATED_SIDE_MAX: u32 = 512;

/// Most players of a generated map.
pub const GENERATED_PLAYERS_MAX: u32 = 8;

/// Most spawns of a player on a generated map.
pub const GENERATED_SPAWNS_MAX: u32 = 8;

/// Most clusters of patches on a generated map.
pub const GENERATED_CLUSTERS_MAX: u32 = 64;

/// Most patches of a cluster: more would close the ring around a spawn.
pub const GENERATED_PATCHES_MAX: u32 = 12;

/// Largest amount of a patch: what an int property of Tiled holds.
pub const GENERATED_AMOUNT_MAX: u32 = i32::MAX.cast_unsigned();

/// Largest radius that ways are made for, in tiles.
pub const GENERATED_RADIUS_MAX: f64 = 4.0;

/// How often a map is tried before it is given up, each time with other numbers of the same seed.
const ATTEMPTS_MAX: u32 = 64;

/// Room beside the largest unit where it goes through, in tiles, so that it does not scrape along both walls.
const MARGIN: f64 = 0.25;

/// Wanted width and height of the open ground around a spawn, in tiles; see [`Request::clearing`].
const CLEARING_WANTED: i32 = 12;

/// Least width and height of the open ground around a spawn, in tiles.
const CLEARING_MIN: i32 = 6;

/// What a generated map shall be like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Request {
    /// What kind of ground it has.
    pub kind: Kind,
    /// The width in tiles, [`GENERATED_SIDE_MIN`]`..=`[`GENERATED_SIDE_MAX`].
    pub width: u32,
    /// The height in tiles, in the same range.
    pub height: u32,
    /// How many players have spawns, `0..=`[`GENERATED_PLAYERS_MAX`]. With an even number the map is the same after half
    /// a turn, and the spawns of player 0 lie on those of player 1, those of 2 on those of 3.
    pub players: u32,
    /// Spawns of each player, `1..=`[`GENERATED_SPAWNS_MAX`].
    pub spawns: u32,
    /// Clusters of patches in all, `0..=`[`GENERATED_CLUSTERS_MAX`]. If each player can have one, one lies beside a spawn
    /// of each; all others are nobody's.
    pub clusters: u32,
    /// Patches of a cluster, `1..=`[`GENERATED_PATCHES_MAX`].
    pub patches: u32,
    /// How much there is of each patch, `0..=`[`GENERATED_AMOUNT_MAX`].
    pub amount: u32,
    /// The radius of the largest unit, in world units; above 0, at most [`GENERATED_RADIUS_MAX`].
    pub radius: f64,
}

impl Request {
    /// Returns the width of a way on which the largest unit gets through, in whole tiles: `2 radius + 0.25`,
    /// rounded up.
    #[must_use]
    pub fn lane(&self) -> u32 {
        let wanted = 2.0 * self.radius + MARGIN;
        (1..=2 * GENERATED_SIDE_MAX)
            .find(|&tiles| f64::from(tiles) >= wanted)
            .unwrap_or(2 * GENERATED_SIDE_MAX)
    }

    /// Returns the width and height of the open square around each spawn, in tiles, an even number: 12, or as much
    /// less as makes all squares together a quarter of the map, but no less than 6, nor than what the largest unit
    /// needs.
    #[must_use]
    pub fn clearing(&self) -> u32 {
        let squares = (self.players * self.spawns).cast_signed();
        let area = self.width.cast_signed() * self.height.cast_signed();
        let is_fitting = |side: &i32| 4 * squares * side * side <= area;
        let sides = (CLEARING_MIN..=CLEARING_WANTED).rev().step_by(2);
        let side = sides.into_iter().find(is_fitting).unwrap_or(CLEARING_MIN).cast_unsigned();
        side.max((self.lane() + 2).next_multiple_of(2))
    }

    /// Whether the map is the same after half a turn.
    fn is_symmetric(&self) -> bool {
        self.players.is_multiple_of(2)
    }

    fn checked(&self) -> Result<(), GenerateError> {
        for (what, found, least, most) in [
            ("width", self.width, GENERATED_SIDE_MIN, GENERATED_SIDE_MAX),
            ("height", self.height, GENERATED_SIDE_MIN, GENERATED_SIDE_MAX),
            ("players", self.players, 0, GENERATED_PLAYERS_MAX),
            ("spawns", self.spawns, 1, GENERATED_SPAWNS_MAX),
            ("clusters", self.clusters, 0, GENERATED_CLUSTERS_MAX),
            ("patches", self.patches, 1, GENERATED_PATCHES_MAX),
            ("amount", self.amount, 0, GENERATED_AMOUNT_MAX),
        ] {
            if !(least..=most).contains(&found) {
                return Err(GenerateError::Number { what, found, least, most });
            }
        }
        // Written so that what is not a number fails too.
        if self.radius > 0.0 && self.radius <= GENERATED_RADIUS_MAX {
            return Ok(());
        }
        Err(GenerateError::Radius { found: self.radius.to_string(), most: GENERATED_RADIUS_MAX.to_string() })
    }
}

/// Returns the map that follows from a request and a seed: the same on every machine.
///
/// Every spawn has open ground around it ([`Request::clearing`]). From every spawn and every patch a circle of the
/// given radius gets to every other, with patches (circles of radius 0.375) in the way as well as walls, and to every
/// tile that is open; so the map has one region. Patches of a cluster are at least 1 tile apart, as they are from
/// walls.
///
/// # Errors
/// A number out of range; or no room for the spawns or clusters, or no way between them, in any of 64 attempts.
pub fn generate(request: &Request, seed: u64) -> Result<TileMap, GenerateError> {
    request.checked()?;
    let mut failure = GenerateError::no_way(request);
    for attempt in 0..ATTEMPTS_MAX {
        match Draft::new(request, Dice::new(seed, request.kind, attempt)) {
            Ok(draft) => return Ok(draft.finish()),
            Err(error) => failure = error,
        }
    }
    Err(failure)
}

/// What lies on the ground.
struct Layout {
    /// Player and place; the place is the corner that four tiles share.
    spawns: Vec<(u32, Spot)>,
    /// The places of all patches, in half tiles.
    patches: Vec<Spot>,
    /// The middle tile of each cluster that is nobody's.
    neutral: Vec<Spot>,
}

/// A map in the making.
struct Draft<'a> {
    request: &'a Request,
    dice: Dice,
    layout: Layout,
    canvas: Canvas,
}

impl<'a> Draft<'a> {
    /// Draws a map in which everything can be reached.
    fn new(request: &'a Request, dice: Dice) -> Result<Self, GenerateError> {
        let spawns = spawns::place(request, dice).ok_or(GenerateError::no_room_for_spawns(request))?;
        let layout =
            clusters::place(request, dice, spawns).ok_or(GenerateError::no_room_for_clusters(request))?;
        let mut canvas = Canvas::new(request.width, request.height, request.is_symmetric());
        let mut draft = Self { request, dice, layout, canvas: canvas.clone() };
        draft.keep_open(&mut canvas);
        let bridge = match request.kind {
            Kind::Plain => canvas::Material::Ground,
            Kind::Obstacles => obstacles::draw(&mut canvas, request, dice),
            Kind::Maze => maze::draw(&mut canvas, request, dice),
            Kind::Islands => islands::draw(&mut canvas, request, dice, &draft.layout),
            Kind::Cliffs => cliffs::draw(&mut canvas, request, dice),
            Kind::Choke => choke::draw(&mut canvas, request, dice),
        };
        let mut ways = Ways::new(canvas, request, &draft.layout);
        if !ways.connect(bridge) {
            return Err(GenerateError::no_way(request));
        }
        draft.canvas = ways.into_canvas();
        Ok(draft)
    }

    /// Marks the ground around spawns and patches, which nothing may block.
    fn keep_open(&self, canvas: &mut Canvas) {
        let half = self.request.clearing().cast_signed() / 2;
        for &(_, (x, y)) in &self.layout.spawns {
            canvas.keep((x - half, y - half), (x + half, y + half));
        }
        let reach = self.request.lane().cast_signed();
        for &patch in &self.layout.patches {
            let (min, max) = clusters::tiles_of(patch);
            canvas.keep((min.0 - reach, min.1 - reach), (max.0 + reach, max.1 + reach));
        }
    }

    fn finish(self) -> TileMap {
        let (canvas, layout) = (&self.canvas, &self.layout);
        let mut builder = Builder::new(self.request.width, self.request.height);
        let corners = slopes(canvas, self.dice, self.request.kind);
        for (spot, corner) in canvas.spots().zip(corners) {
            let material = canvas.material(spot);
            // The open half of a half-blocked tile is what a unit can stand on.
            let (shape, name) = match (corner, material.is_open()) {
                (Some(corner), _) => (TileShape::Diagonal(corner), canvas::Material::Ground.name()),
                (None, true) => (TileShape::Open, material.name()),
                (None, false) => (TileShape::Blocked, material.name()),
            };
            let terrain = builder.terrain(name).ok();
            builder.put(spot.0.cast_unsigned(), spot.1.cast_unsigned(), shape, terrain);
        }
        for &(player, (x, y)) in &layout.spawns {
            builder.add_spawn(Spawn { player, position: DVec2::new(f64::from(x), f64::from(y)) });
        }
        for &(x, y) in &layout.patches {
            let position = DVec2::new(f64::from(x) / 2.0, f64::from(y) / 2.0);
            builder.add_resource(Resource { position, amount: self.request.amount });
        }
        builder.finish()
    }
}
