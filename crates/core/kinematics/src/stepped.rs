//! The solver that only looks now and then: what most games do, to be compared with.

use maniple_geometry::predicate::{circle_overlaps_segment, circles_overlap};
use maniple_geometry::{Planar, Scalar};

use crate::graph::Setting;
use crate::runner::Halt;
use crate::solve::{Solver, is_stopped_by};

impl<S: Scalar> Solver<S> {
    /// Looks so many times who overlaps. Whoever does, and has come nearer since the time before, stops where it was then.
    pub(crate) fn step_through(&mut self, substeps: u32, setting: &Setting<'_, S>) {
        let time = |step: u32| S::from_f64(f64::from(step) / f64::from(substeps));
        for step in 1..=substeps {
            let (before, now) = (time(step - 1), time(step));
            self.halts.clear();
            for edge in 0..self.edges.len() {
                self.look_at_pair(self.edges[edge], (before, now), setting);
            }
            for place in 0..self.beside.len() {
                self.look_at_rest(self.beside[place], (before, now), setting);
            }
            self.stop_all(before);
        }
    }

    fn look_at_pair(&mut self, (a, b): (u32, u32), (before, now): (S, S), setting: &Setting<'_, S>) {
        let (first, second) = (&self.runners[a as usize], &self.runners[b as usize]);
        if first.halt.is_some() && second.halt.is_some() {
            return;
        }
        let places = |time: S| (first.place(time, &self.arena), second.place(time, &self.arena));
        let distance = |(p, q): (S::Vector, S::Vector)| (q - p).dot(q - p);
        let (old, new) = (places(before), places(now));
        if !circles_overlap::<S>(new.0, first.radius, new.1, second.radius) || distance(new) >= distance(old)
        {
            return;
        }
        for (runner, pair) in [(a, (first, second)), (b, (second, first))] {
            if pair.0.halt.is_none() && is_stopped_by(pair, setting.settings.stops, before, &self.arena) {
                self.halts.push((runner, Halt::beside(pair.1.id)));
            }
        }
    }

    fn look_at_rest(&mut self, index: u32, (before, now): (S, S), setting: &Setting<'_, S>) {
        let Self { runners, arena, halts, .. } = self;
        let this = &runners[index as usize];
        if this.halt.is_some() || !this.is_moving(before, arena) {
            return;
        }
        let (old, new) = (this.place(before, arena), this.place(now, arena));
        let (center, reach) = (new.to_dvec2(), (this.radius + setting.objects.margin).to_f64());
        let layers = setting.objects.layers[this.slot as usize];
        setting.walls.near(center, reach, |wall| {
            let (from, to) = (wall.segment.nearest(old) - old, wall.segment.nearest(new) - new);
            if to.dot(to) < from.dot(from)
                && wall.layers.share(layers)
                && circle_overlaps_segment(new, this.radius, &wall.segment)
            {
                halts.push((index, Halt::at_wall(wall.kind.event())));
            }
        });
        setting.resting.near(center, reach, |slot| {
            let (state, intent) = setting.objects.of(slot);
            let (from, to) = (state.start - old, state.start - new);
            if to.dot(to) < from.dot(from)
                && setting.objects.layers[slot as usize].share(layers)
                && circles_overlap::<S>(new, this.radius, state.start, state.radius)
            {
                halts.push((index, Halt::beside(intent.id)));
            }
        });
    }
}
