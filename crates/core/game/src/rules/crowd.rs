//! Who can be hurt, by place.

use glam::DVec2;
use maniple_geometry::ObjectId;

use crate::world::State;

/// Edge of a bucket, in world units: about the range of a weapon, so that a search takes a few of them.
const BUCKET: f64 = 4.0;

/// All living objects that can be hurt, in square buckets by their centres.
pub(crate) struct Crowd {
    columns: usize,
    rows: usize,
    buckets: Vec<Vec<ObjectId>>,
    /// The largest radius of a type, in world units.
    radius_max: f64,
}

impl Crowd {
    /// Returns those of the present state.
    pub(crate) fn of(state: &State) -> Self {
        let mut radius_max = 0.0;
        for kind in &state.scenario.unit_types {
            if kind.shape.radius() > radius_max {
                radius_max = kind.shape.radius();
            }
        }
        let (columns, rows) = (buckets(f64::from(state.map.width())), buckets(f64::from(state.map.height())));
        let mut crowd = Self { columns, rows, buckets: vec![Vec::new(); columns * rows], radius_max };
        for (object, unit) in state.units.alive() {
            if state.unit_type(unit.unit_type).hit_points.is_some() {
                let center = state.center(object);
                let place = crowd.row(center.y) * columns + crowd.column(center.x);
                crowd.buckets[place].push(object);
            }
        }
        crowd
    }

    /// Returns those whose hull may be within `reach` of a point, and some more.
    pub(crate) fn near(&self, point: DVec2, reach: f64) -> impl Iterator<Item = ObjectId> {
        let reach = reach + self.radius_max;
        let columns = self.column(point.x - reach)..=self.column(point.x + reach);
        (self.row(point.y - reach)..=self.row(point.y + reach))
            .flat_map(move |row| columns.clone().map(move |column| row * self.columns + column))
            .flat_map(|place| &self.buckets[place])
            .copied()
    }

    fn column(&self, x: f64) -> usize {
        bucket(x).min(self.columns - 1)
    }

    fn row(&self, y: f64) -> usize {
        bucket(y).min(self.rows - 1)
    }
}

/// Returns how many buckets a length takes.
fn buckets(length: f64) -> usize {
    bucket(length) + 1
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "below 0 it saturates to the first bucket, which is meant; a map ends far below 2^32"
)]
fn bucket(value: f64) -> usize {
    (value / BUCKET) as usize
}
