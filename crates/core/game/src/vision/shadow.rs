//! What walls hide.

use std::cmp::Ordering;

use maniple_view::TileSet;

/// Tiles of a row, the last one included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Span {
    pub(super) y: u32,
    pub(super) from: u32,
    pub(super) to: u32,
}

/// Who looks, and what is in the way.
pub(super) struct Look<'a> {
    pub(super) blocked: &'a TileSet,
    /// Column and row of the tile of the eye.
    pub(super) eye: (u32, u32),
}

/// Works out which tiles are in sight of a tile where blocked tiles block sight.
///
/// The rule: from a tile to another, `n` tiles away along the longer axis (columns or rows) and `d` along the other, the line of sight
/// from centre to centre is walked in steps of one along the longer axis. After step `j` it is `d j / n` aside: on the tile there, or
/// exactly between two. It is blocked where that tile is, or both of the two are, for any `j` from 1 to `n - 1`. The other way round the
/// line passes the same tiles, so seeing is mutual. Besides, a blocked tile is seen where one of the eight tiles around it is seen that
/// is not blocked: it is the face of a wall.
///
/// Shadows are cast instead of walking every line: the slopes `d / n` that are still clear are kept as closed intervals of fractions,
/// row by row away from the eye, and the tiles from `a` to `b` of a row at distance `j` that are blocked take out the open
/// interval from `(a - 1/2) / j` to `(b + 1/2) / j` (after Ford, *Symmetric shadowcasting*, 2017, who keeps one interval a call). All of it is in
/// whole numbers.
#[derive(Clone, Debug, Default)]
pub(super) struct Shadows {
    /// The smallest rectangle around all tiles within reach: its left, top, width, and height.
    left: u32,
    top: u32,
    width: u32,
    height: u32,
    /// The width of the map.
    map_width: u32,
    spans: Vec<Span>,
    /// By row and column of the rectangle: which tiles a line of sight leads to.
    lit: Vec<bool>,
    /// The same, less what is out of reach, and with the faces of walls.
    seen: Vec<bool>,
    /// The slopes that are clear: first and last.
    beams: Vec<(Slope, Slope)>,
    beams_next: Vec<(Slope, Slope)>,
}

/// A fraction; the denominator is positive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Slope {
    numerator: i64,
    denominator: i64,
}

impl Slope {
    fn compare(self, other: Self) -> Ordering {
        (self.numerator * other.denominator).cmp(&(other.numerator * self.denominator))
    }

    fn is_below(self, other: Self) -> bool {
        self.compare(other) == Ordering::Less
    }
}

/// A quarter of what is around the eye: the way from it, and the way across.
type Quarter = ((i64, i64), (i64, i64));

const QUARTERS: [Quarter; 4] = [((0, -1), (1, 0)), ((0, 1), (1, 0)), ((-1, 0), (0, 1)), ((1, 0), (0, 1))];

impl Shadows {
    /// Looks; `near` are tiles within `reach` that are seen whatever is in the way.
    pub(super) fn cast(
        &mut self,
        look: &Look<'_>,
        reach: impl Iterator<Item = Span>,
        near: impl Iterator<Item = Span>,
    ) {
        self.spans.clear();
        self.spans.extend(reach);
        self.surround(look.blocked.width());
        if !self.has_blocked(look.blocked) {
            self.seen.fill(true);
            return;
        }
        self.light(look.eye);
        for quarter in QUARTERS {
            self.cast_quarter(look, quarter);
        }
        for span in near {
            for x in span.from..=span.to {
                self.light((x, span.y));
            }
        }
        self.see(look.blocked);
    }

    /// Calls `each` with first tile and count of the runs of tiles that are seen, row by row.
    pub(super) fn runs(&self, mut each: impl FnMut(u32, u32)) {
        for span in &self.spans {
            let mut count = 0;
            for x in span.from..=span.to {
                if self.seen[self.place(x, span.y)] {
                    count += 1;
                } else if count > 0 {
                    each(span.y * self.map_width + x - count, count);
                    count = 0;
                }
            }
            if count > 0 {
                each(span.y * self.map_width + span.to + 1 - count, count);
            }
        }
    }

    fn surround(&mut self, map_width: u32) {
        let (left, right) = self
            .spans
            .iter()
            .fold((u32::MAX, 0), |(left, right), span| (left.min(span.from), right.max(span.to)));
        let (Some(first), Some(last)) = (self.spans.first(), self.spans.last()) else {
            panic!("an object's own tile is within reach");
        };
        (self.left, self.top, self.map_width) = (left, first.y, map_width);
        (self.width, self.height) = (right - left + 1, last.y - first.y + 1);
        let area = self.width as usize * self.height as usize;
        for cells in [&mut self.lit, &mut self.seen] {
            cells.clear();
            cells.resize(area, false);
        }
    }

    fn has_blocked(&self, blocked: &TileSet) -> bool {
        self.spans.iter().any(|span| (span.from..=span.to).any(|x| blocked.contains(x, span.y)))
    }

    fn cast_quarter(&mut self, look: &Look<'_>, (away, across): Quarter) {
        self.beams.clear();
        let whole = |numerator| Slope { numerator, denominator: 1 };
        self.beams.push((whole(-1), whole(1)));
        let eye = (i64::from(look.eye.0), i64::from(look.eye.1));
        for distance in 1.. {
            let start = (eye.0 + away.0 * distance, eye.1 + away.1 * distance);
            if self.beams.is_empty() || self.inside(start).is_none() {
                return;
            }
            let tile = |aside: i64| (start.0 + across.0 * aside, start.1 + across.1 * aside);
            for index in 0..self.beams.len() {
                let (from, to) = self.beams[index];
                let first = -(-from.numerator * distance).div_euclid(from.denominator);
                let last = (to.numerator * distance).div_euclid(to.denominator);
                for aside in first..=last {
                    if let Some(tile) = self.inside(tile(aside)) {
                        self.light(tile);
                    }
                }
            }
            let is_blocked = |shadows: &Self, aside| {
                shadows.inside(tile(aside)).is_some_and(|(x, y)| look.blocked.contains(x, y))
            };
            let mut aside = -distance;
            while aside <= distance {
                let from = aside;
                while aside <= distance && is_blocked(self, aside) {
                    aside += 1;
                }
                if from < aside {
                    let half = |numerator| Slope { numerator, denominator: 2 * distance };
                    self.shade(half(2 * from - 1), half(2 * aside - 1));
                }
                aside += 1;
            }
        }
    }

    /// Takes the slopes strictly between two out of those that are clear.
    fn shade(&mut self, from: Slope, to: Slope) {
        self.beams_next.clear();
        for &(first, last) in &self.beams {
            if !from.is_below(last) || !first.is_below(to) {
                self.beams_next.push((first, last));
                continue;
            }
            if !from.is_below(first) {
                self.beams_next.push((first, from));
            }
            if !last.is_below(to) {
                self.beams_next.push((to, last));
            }
        }
        std::mem::swap(&mut self.beams, &mut self.beams_next);
    }

    fn see(&mut self, blocked: &TileSet) {
        for index in 0..self.spans.len() {
            let Span { y, from, to } = self.spans[index];
            for x in from..=to {
                let place = self.place(x, y);
                self.seen[place] = self.lit[place];
            }
        }
        for index in 0..self.spans.len() {
            let Span { y, from, to } = self.spans[index];
            for x in from..=to {
                if blocked.contains(x, y) && self.is_face(x, y, blocked) {
                    let place = self.place(x, y);
                    self.seen[place] = true;
                }
            }
        }
    }

    /// Returns whether one of the tiles around one is seen that is not blocked.
    fn is_face(&self, x: u32, y: u32, blocked: &TileSet) -> bool {
        let around = (-1..=1).flat_map(|down| (-1..=1).map(move |right| (right, down)));
        around
            .filter_map(|(right, down)| self.inside((i64::from(x) + right, i64::from(y) + down)))
            .any(|(x, y)| !blocked.contains(x, y) && self.seen[self.place(x, y)])
    }

    fn light(&mut self, (x, y): (u32, u32)) {
        let place = self.place(x, y);
        self.lit[place] = true;
    }

    /// Returns the tile if it is in the rectangle.
    fn inside(&self, (x, y): (i64, i64)) -> Option<(u32, u32)> {
        let (x, y) = (u32::try_from(x).ok()?, u32::try_from(y).ok()?);
        let is_inside = (self.left..self.left + self.width).contains(&x)
            && (self.top..self.top + self.height).contains(&y);
        is_inside.then_some((x, y))
    }

    fn place(&self, x: u32, y: u32) -> usize {
        (y - self.top) as usize * self.width as usize + (x - self.left) as usize
    }
}
