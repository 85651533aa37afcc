//! Where patches of resources lie.

use super::canvas::Spot;
use super::dice::Dice;
use super::spawns::square_distance;
use super::{Layout, Request};

/// How many places are rolled for a cluster before there is no room for it.
const ROLLS_MAX: i32 = 192;

/// Among how many fitting places the one far from all else is taken.
const CHOICE: usize = 12;

/// Most patches in one row of a cluster.
const ROW_MAX: i32 = 6;

/// Half tiles between neighbours of a cluster along their row, and between rows: two tiles, and three.
const ALONG: i32 = 4;
const ROWS_APART: i32 = 6;

/// Between which squares of the distance, in half tiles, patches lie around a spawn: 5.5 and 7 tiles.
const RING: (i32, i32) = (11 * 11, 14 * 14);

/// The eight directions in which patches can lie from a spawn, in half tiles of nearly the same length.
const DIRECTIONS: [Spot; 8] = [(7, 0), (5, 5), (0, 7), (-5, 5), (-7, 0), (-5, -5), (0, -7), (5, -5)];

/// Returns the tiles that a patch lies on, from the first up to but without the second; the place is in half tiles.
pub(super) fn tiles_of((x, y): Spot) -> (Spot, Spot) {
    // A patch is a circle of radius 0.375: it reaches into the next tile only where it lies on an edge.
    let first = |place: i32| (place - 1).div_euclid(2);
    let last = |place: i32| place.div_euclid(2);
    ((first(x), first(y)), (last(x) + 1, last(y) + 1))
}

/// Adds clusters to the spawns; `None` where they found no room.
pub(super) fn place(request: &Request, dice: Dice, spawns: Vec<(u32, Spot)>) -> Option<Layout> {
    let layout = Layout { spawns, patches: Vec::new(), neutral: Vec::new() };
    let mut placing = Placing { request, dice, layout };
    let mut left = request.clusters;
    let is_symmetric = request.is_symmetric();
    let step = if is_symmetric { 2 } else { 1 };
    if left >= request.players {
        for player in (0..request.players).step_by(step) {
            let patches = placing.beside_spawn(player)?;
            placing.add(patches);
        }
        left -= request.players;
    }
    if is_symmetric && left % 2 == 1 {
        let patches = placing.around_the_centre()?;
        let middle = (request.width.cast_signed() / 2, request.height.cast_signed() / 2);
        placing.layout.patches.extend(patches);
        placing.layout.neutral.push(middle);
        left -= 1;
    }
    for number in (0..left).step_by(step) {
        let (middle, patches) = placing.best(number)?;
        placing.add(patches);
        placing.layout.neutral.push(middle);
        if is_symmetric {
            let (width, height) = (request.width.cast_signed(), request.height.cast_signed());
            placing.layout.neutral.push((width - 1 - middle.0, height - 1 - middle.1));
        }
    }
    Some(placing.layout)
}

/// Returns the larger of the distances along the two axes.
fn separation(a: Spot, b: Spot) -> i32 {
    (a.0 - b.0).abs().max((a.1 - b.1).abs())
}

struct Placing<'a> {
    request: &'a Request,
    dice: Dice,
    layout: Layout,
}

impl Placing<'_> {
    fn add(&mut self, patches: Vec<Spot>) {
        let twins: Vec<Spot> = patches.iter().filter_map(|&patch| self.twin(patch)).collect();
        self.layout.patches.extend(patches);
        self.layout.patches.extend(twins);
    }

    /// Returns where a place in half tiles goes by half a turn; `None` on a map without symmetry.
    fn twin(&self, (x, y): Spot) -> Option<Spot> {
        let (width, height) = (self.request.width.cast_signed(), self.request.height.cast_signed());
        self.request.is_symmetric().then_some((2 * width - x, 2 * height - y))
    }

    /// Returns patches in an arc beside the first spawn of a player, away from the middle of the map.
    fn beside_spawn(&self, player: u32) -> Option<Vec<Spot>> {
        let (_, home) = *self.layout.spawns.iter().find(|(owner, _)| *owner == player)?;
        let (width, height) = (self.request.width.cast_signed(), self.request.height.cast_signed());
        let outwards = (2 * home.0 - width, 2 * home.1 - height);
        let mut directions = DIRECTIONS;
        directions.sort_by_key(|direction| -(direction.0 * outwards.0 + direction.1 * outwards.1));
        let direction =
            directions[self.dice.below("beside spawn", u64::from(player), 3).unsigned_abs() as usize];
        let middle = (2 * home.0, 2 * home.1);
        let mut ring: Vec<(f64, Spot)> = Vec::new();
        for down in -15..15 {
            for right in -15..15 {
                // Middles of tiles are at odd numbers of half tiles.
                let (right, down) = (2 * right + 1, 2 * down + 1);
                let square = right * right + down * down;
                let patch = (middle.0 + right, middle.1 + down);
                if (RING.0..=RING.1).contains(&square) && self.is_free(patch, Some(home)) {
                    let along = f64::from(right * direction.0 + down * direction.1);
                    ring.push((along / f64::from(square).sqrt(), patch));
                }
            }
        }
        ring.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut patches: Vec<Spot> = Vec::new();
        for (_, patch) in ring {
            let is_apart = patches.iter().all(|&other| separation(patch, other) >= ALONG);
            if is_apart && patches.len() < self.request.patches as usize {
                patches.push(patch);
            }
        }
        (patches.len() == self.request.patches as usize && self.is_apart_from_twins(&patches))
            .then_some(patches)
    }

    /// Returns the middle tile and the patches of the one, of some places that fit, farthest from all else.
    fn best(&self, number: u32) -> Option<(Spot, Vec<Spot>)> {
        let rolled = (0..ROLLS_MAX).map(|roll| self.roll(number, roll));
        let fitting = rolled.filter(|(_, patches)| {
            patches.iter().all(|&patch| self.is_free(patch, None)) && self.is_apart_from_twins(patches)
        });
        let mut best = None;
        for (middle, patches) in fitting.take(CHOICE) {
            let place = (2 * middle.0 + 1, 2 * middle.1 + 1);
            let spawns = self.layout.spawns.iter().map(|&(_, (x, y))| (2 * x, 2 * y));
            let others = spawns.chain(self.layout.patches.iter().copied()).chain(self.twin(place));
            let distance = others.map(|other| square_distance(place, other)).min().unwrap_or(i32::MAX);
            if best.as_ref().is_none_or(|&(_, _, farthest)| distance > farthest) {
                best = Some((middle, patches, distance));
            }
        }
        best.map(|(middle, patches, _)| (middle, patches))
    }

    fn roll(&self, number: u32, roll: i32) -> (Spot, Vec<Spot>) {
        let index = u64::from(number) << 32 | u64::from(roll.cast_unsigned());
        let (width, height) = (self.request.width.cast_signed(), self.request.height.cast_signed());
        let middle =
            (self.dice.below("cluster x", index, width), self.dice.below("cluster y", index, height));
        let turns = self.dice.below("cluster turns", index, 4);
        let place = (2 * middle.0 + 1, 2 * middle.1 + 1);
        let patches =
            arc(self.request.patches.cast_signed()).map(|offset| moved(place, turned(offset, turns)));
        (middle, patches.collect())
    }

    /// Returns patches in an S around the middle of the map, where half a turn maps them onto each other.
    fn around_the_centre(&self) -> Option<Vec<Spot>> {
        let centre = (self.request.width.cast_signed(), self.request.height.cast_signed());
        let turns = self.dice.below("centre turns", 0, 4);
        let count = self.request.patches.cast_signed();
        // Middles of tiles are at odd numbers of half tiles; the centre may lie on an edge.
        let (across, down) = if turns % 2 == 0 { centre } else { (centre.1, centre.0) };
        let (odd_across, odd_down) = ((across + 1) % 2, (down + 1) % 2);
        let mut patches = Vec::new();
        if count % 2 == 1 {
            patches.push(centre);
        }
        for pair in 0..count / 2 {
            let along = ALONG * pair + if count % 2 == 1 { ALONG } else { 2 } + odd_across;
            let offset = turned((along, odd_down + 2 * ((pair + 1) * (pair + 1) / 6)), turns);
            patches.push(moved(centre, offset));
            patches.push(moved(centre, (-offset.0, -offset.1)));
        }
        patches.iter().all(|&patch| self.is_free(patch, None)).then_some(patches)
    }

    /// Whether a patch is a tile away from the edge of the map, beside the squares of all spawns but `home`, and not in
    /// the way of other clusters.
    fn is_free(&self, patch: Spot, home: Option<Spot>) -> bool {
        let request = self.request;
        let (width, height) = (2 * request.width.cast_signed(), 2 * request.height.cast_signed());
        let is_inside = (3..=width - 3).contains(&patch.0) && (3..=height - 3).contains(&patch.1);
        let square = request.clearing().cast_signed() + 2;
        let mut spawns = self.layout.spawns.iter().filter(|&&(_, spawn)| Some(spawn) != home);
        is_inside
            && spawns.all(|&(_, spawn)| separation(patch, (2 * spawn.0, 2 * spawn.1)) > square)
            && self.layout.patches.iter().all(|&other| separation(patch, other) >= self.clusters_apart())
    }

    /// Returns how far apart patches of different clusters are, in half tiles, so that a way fits between them.
    fn clusters_apart(&self) -> i32 {
        2 * (self.request.lane().cast_signed() + 2)
    }

    fn is_apart_from_twins(&self, patches: &[Spot]) -> bool {
        let mut twins = patches.iter().filter_map(|&patch| self.twin(patch));
        twins.all(|twin| patches.iter().all(|&patch| separation(patch, twin) >= self.clusters_apart()))
    }
}

/// Returns the offsets of patches from their middle, in half tiles, an even number: rows that bend towards their ends.
fn arc(count: i32) -> impl Iterator<Item = Spot> {
    let rows = (count + ROW_MAX - 1) / ROW_MAX;
    let row_length = (count + rows - 1) / rows;
    (0..count).map(move |number| {
        let (row, place) = (number / row_length, number % row_length);
        let length = row_length.min(count - row * row_length);
        // Twice the number of places from the middle of the row.
        let from_middle = 2 * place - (length - 1);
        let across = from_middle * ALONG / 2;
        (across, 2 * (from_middle * from_middle / 10) + ROWS_APART * row)
    })
}

fn turned((x, y): Spot, turns: i32) -> Spot {
    (0..turns).fold((x, y), |(x, y), _| (-y, x))
}

fn moved(place: Spot, offset: Spot) -> Spot {
    (place.0 + offset.0, place.1 + offset.1)
}
