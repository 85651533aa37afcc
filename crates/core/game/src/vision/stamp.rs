//! Which tiles one object sees.

use maniple_tilemap::{SIZE_MAX, TileMap};
use maniple_view::TileSet;

use super::objects::Visible;
use super::shadow::{Look, Shadows, Span};
use crate::scenario::SIGHT_MIN;

/// The tiles that an object sees. They change only when its own tiles do: the one that its centre is on, or, of a rectangle, all that
/// it touches.
///
/// A tile is *within reach* where its square is within sight of the square of an own tile, the radius added: with the gaps `gx` and
/// `gy` between the two squares, in whole columns and rows, `gx^2 + gy^2 <= (radius + sight)^2`. Two squares side by side have no
/// gap. So whatever an object sees of others stands on a tile that it sees.
#[derive(Clone, Debug, Default)]
pub(super) struct Stamp {
    own: Option<Own>,
    /// First tile and count, row by row.
    runs: Vec<(u32, u32)>,
}

/// The own tiles of an object, the last ones included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Own {
    left: u32,
    top: u32,
    right: u32,
    bottom: u32,
}

/// What an object looks at.
pub(super) struct Scene<'a> {
    pub(super) map: &'a TileMap,
    /// The tiles that block sight; `None`: nothing does.
    pub(super) blocked: Option<&'a TileSet>,
}

impl Stamp {
    /// Looks from where an object is now; returns whether its own tiles have changed.
    pub(super) fn look(&mut self, object: &Visible, scene: &Scene<'_>, shadows: &mut Shadows) -> bool {
        let half = object.shape.half();
        let (left, top) = scene.map.tile_at(object.center - half);
        let (right, bottom) = scene.map.tile_at(object.center + half);
        let own = Own { left, top, right, bottom };
        if self.own == Some(own) {
            return false;
        }
        self.own = Some(own);
        self.runs.clear();
        let width = scene.map.width();
        let radius = object.shape.rounding();
        let reach = own.spans(radius + object.sight, scene.map);
        match scene.blocked.filter(|_| !object.is_in_air) {
            None => self.runs.extend(reach.map(|span| (span.y * width + span.from, span.to - span.from + 1))),
            Some(blocked) => {
                let eye = scene.map.tile_at(object.center);
                // Whatever touches the hull is nearer than the shortest sight, and always seen.
                let near = own.spans(radius + SIGHT_MIN, scene.map);
                shadows.cast(&Look { blocked, eye }, reach, near);
                shadows.runs(|first, count| self.runs.push((first, count)));
            }
        }
        true
    }

    /// Puts the tiles into a set.
    pub(super) fn insert_into(&self, tiles: &mut TileSet) {
        for &(first, count) in &self.runs {
            tiles.insert_run(first, count);
        }
    }
}

impl Own {
    /// Returns the tiles of a map whose squares are at most so many world units from those of the own tiles, row by row.
    fn spans(self, reach: f64, map: &TileMap) -> impl Iterator<Item = Span> + use<> {
        let (last_column, last_row) = (map.width() - 1, map.height() - 1);
        let beyond = whole_gap(reach * reach, 0).unwrap_or(0) + 1;
        let rows = self.top.saturating_sub(beyond)..=(self.bottom + beyond).min(last_row);
        rows.filter_map(move |y| {
            let gap = self.top.saturating_sub(y + 1).max(y.saturating_sub(self.bottom + 1));
            let beyond = whole_gap(reach * reach, gap)? + 1;
            let from = self.left.saturating_sub(beyond);
            Some(Span { y, from, to: (self.right + beyond).min(last_column) })
        })
    }
}

/// Returns the largest gap of columns with which a tile is within reach at a gap of so many rows; `None` where none is.
///
/// The root only guesses; what decides is the comparison of squares, which are whole numbers on one side.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates, and is limited")]
fn whole_gap(reach_squared: f64, rows: u32) -> Option<u32> {
    let is_within = |columns: u32| {
        let [x, y] = [columns, rows].map(f64::from);
        x * x + y * y <= reach_squared
    };
    if !is_within(0) {
        return None;
    }
    let mut columns = ((reach_squared - f64::from(rows) * f64::from(rows)).sqrt() as u32).min(SIZE_MAX);
    while columns > 0 && !is_within(columns) {
        columns -= 1;
    }
    while columns < SIZE_MAX && is_within(columns + 1) {
        columns += 1;
    }
    Some(columns)
}
