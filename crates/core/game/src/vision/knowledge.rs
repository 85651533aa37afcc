//! What terrain a team has seen.

use maniple_geometry::Segment;
use maniple_tilemap::TileMap;
use maniple_view::{Terrain, TileSet};

/// A wall as (x1, y1, x2, y2), the blocked side to the right.
pub(crate) type Wall = (f64, f64, f64, f64);

/// What a map has to be explored.
#[derive(Clone, Debug)]
pub(super) struct Survey {
    /// The tiles in characters.
    rows: Vec<String>,
    /// The parts of free walls and the tiles that they are in, row by row.
    pieces: Vec<((u32, u32), Segment)>,
}

impl Survey {
    pub(super) fn new(map: &TileMap) -> Self {
        Self { rows: Terrain::of(map).tiles, pieces: map.free_wall_pieces() }
    }
}

/// The terrain that a team has seen, and what of it is new.
///
/// A wall between two tiles is known as soon as both are; one at the edge of the map or within a tile, as soon as the tile is. So what is
/// known follows from known tiles alone, and says nothing of others.
#[derive(Clone, Debug)]
pub(super) struct Knowledge {
    known: TileSet,
    /// What was revealed last: column, row, and characters to the right.
    pub(super) revealed: Vec<(u32, u32, String)>,
    /// Walls of which was known last.
    pub(super) walls: Vec<Wall>,
}

impl Knowledge {
    pub(super) fn new(map: &TileMap) -> Self {
        let known = TileSet::new(map.width(), map.height());
        Self { known, revealed: Vec::new(), walls: Vec::new() }
    }

    /// Returns the tiles that were ever seen.
    pub(super) fn known(&self) -> &TileSet {
        &self.known
    }

    /// Takes which tiles were ever seen, as runs; `None` where one goes beyond the last tile.
    pub(super) fn restore(&mut self, runs: &[(u32, u32)]) -> Option<()> {
        self.known.insert_runs(runs)
    }

    /// Takes that nothing is new any more.
    pub(super) fn settle(&mut self) {
        self.revealed.clear();
        self.walls.clear();
    }

    /// Takes what is visible now.
    pub(super) fn explore(&mut self, visible: &TileSet, map: &TileMap, survey: &Survey) {
        let width = map.width();
        let Self { known, revealed, walls } = self;
        visible.runs_without(known, |first, count| {
            let mut at = first;
            while at < first + count {
                let (x, y) = (at % width, at / width);
                let run = (first + count - at).min(width - x);
                revealed.push((x, y, survey.rows[y as usize][x as usize..(x + run) as usize].to_owned()));
                at += run;
            }
        });
        for (x, y, tiles) in &*revealed {
            for x in (*x..).take(tiles.len()) {
                let news = News { known, visible, map };
                news.walls_of(x, *y, |wall| walls.push(ends(&wall)));
                let start = survey.pieces.partition_point(|((column, row), _)| (row, column) < (y, &x));
                let pieces = survey.pieces[start..].iter().take_while(|(tile, _)| *tile == (x, *y));
                walls.extend(pieces.map(|(_, piece)| ends(piece)));
            }
        }
        for (x, y, tiles) in &*revealed {
            known.insert_run(
                y * width + x,
                u32::try_from(tiles.len()).expect("a row is not longer than a map"),
            );
        }
    }

    /// Returns whether a tile has been seen.
    pub(super) fn is_known(&self, x: u32, y: u32) -> bool {
        self.known.contains(x, y)
    }
}

/// What was known before, and what is visible now.
struct News<'a> {
    known: &'a TileSet,
    visible: &'a TileSet,
    map: &'a TileMap,
}

impl News<'_> {
    /// Calls `each` with the walls of a tile that is new, each wall between two new tiles at the first of the two only.
    fn walls_of(&self, x: u32, y: u32, mut each: impl FnMut(Segment)) {
        let (width, height) = (self.map.width(), self.map.height());
        let was_known = |x, y| self.known.contains(x, y);
        let is_known = |x, y| was_known(x, y) || self.visible.contains(x, y);
        let above = (y == 0 || was_known(x, y - 1)).then(|| self.map.wall_above(x, y));
        let left = (x == 0 || was_known(x - 1, y)).then(|| self.map.wall_left_of(x, y));
        let right = (x + 1 == width || is_known(x + 1, y)).then(|| self.map.wall_left_of(x + 1, y));
        let below = (y + 1 == height || is_known(x, y + 1)).then(|| self.map.wall_above(x, y + 1));
        let around = [above, left, right, below].into_iter().flatten().flatten();
        for wall in around.chain(self.map.wall_across(x, y)) {
            each(wall);
        }
    }
}

fn ends(wall: &Segment) -> Wall {
    (wall.start.x, wall.start.y, wall.end.x, wall.end.y)
}
