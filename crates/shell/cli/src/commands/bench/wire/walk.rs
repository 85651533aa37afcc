//! Units that walk from goal to goal, watched by another seat.

use std::f64::consts::TAU;

use maniple_game::{Files, LoadedFile, Overrides, load};
use maniple_geometry::Cycle;
use maniple_referee::Referee;
use maniple_view::{
    ClockMode, Command, Delta, Handle, Positions, Seat, Seen, Sequenced, VELOCITY_BITS, View,
};

use crate::arguments::BenchWire;
use crate::commands::bench::march::{Purpose, unit};
use crate::failure::Failure;
use crate::start;

/// Tiles of the field to each side: 200 circles of radius 0.25 seldom meet in it.
const SIDE: u32 = 128;

/// World units a cycle.
const SPEED: f64 = 0.25;

/// Mean distance of a random point of a square from its centre, in halves of its side: (sqrt 2 + ln(1 + sqrt 2)) / 3.
const MEAN_DISTANCE: f64 = 0.765;

/// Binary digits behind the point of a double from 64 to 128, as half of the coordinates in the field are; smaller ones have more.
const PLACE_DIGITS: f64 = 46.0;

/// The same of a double from an eighth to a quarter, as the larger component of a velocity is.
const VELOCITY_DIGITS: f64 = 55.0;

/// Cycles in which the walkers, who start in a crowd, spread over the field: twice across it.
const SPREADING: u32 = 1000;

/// The walk of one row.
pub(super) struct Walk {
    referee: Referee,
    seed: u64,
    /// Half of the side of the square around a walker in which its next goal is, in world units.
    reach: f64,
    turns_always: bool,
}

impl Walk {
    /// The seat that watches, and has nothing that moves.
    pub(super) const WATCHER: Seat = Seat(0);

    /// The seat of the walkers.
    const WALKERS: Seat = Seat(1);

    /// Returns the walk at its start. From goal to goal it is so many cycles, about; without it everybody turns in every cycle.
    pub(super) fn begin(
        arguments: &BenchWire,
        positions: Positions,
        cycles: Option<u32>,
    ) -> Result<Self, Failure> {
        let overrides = Overrides { positions: Some(positions), ..arguments.overrides() };
        let loaded = load(&files(arguments), "walk.toml", &overrides).map_err(Failure::failed)?;
        let seed = loaded.scenario.seed;
        let mut referee = start::referee(loaded, ClockMode::Lockstep)?;
        for seat in [Self::WATCHER, Self::WALKERS] {
            referee.handle_join(seat, "walk").map_err(Failure::failed)?;
        }
        let reach = f64::from(cycles.unwrap_or(40)) * SPEED / MEAN_DISTANCE;
        let mut walk = Self { referee, seed, reach: f64::from(SIDE) / 2.0, turns_always: false };
        walk.take_deltas();
        for _ in 0..SPREADING {
            walk.step()?;
        }
        walk.reach = reach;
        walk.turns_always = cycles.is_none();
        for _ in 0..2 * cycles.unwrap_or(0) {
            walk.step()?;
        }
        Ok(walk)
    }

    pub(super) fn referee(&self) -> &Referee {
        &self.referee
    }

    /// Returns what the watcher sees.
    pub(super) fn view(&self) -> &View {
        self.referee.view(Self::WATCHER)
    }

    /// Plays a cycle; returns what the watcher is told.
    pub(super) fn step(&mut self) -> Result<Delta, Failure> {
        let cycle = self.referee.cycle();
        let orders = self.orders(cycle);
        self.referee.handle_commands(Self::WALKERS, cycle, orders).map_err(Failure::failed)?;
        self.referee.step();
        Ok(self.take_deltas())
    }

    /// Returns the bits that it takes to say which of all possible walks it is: the goal shows in the end; where everybody turns
    /// before they have arrived, the heading alone does.
    pub(super) fn bits_per_walk(&self) -> f64 {
        let (place, velocity) = match self.referee.loaded().scenario.profile.positions {
            Positions::Exact => (PLACE_DIGITS, VELOCITY_DIGITS),
            Positions::Grid { bits } => (f64::from(bits), f64::from(bits) + f64::from(VELOCITY_BITS)),
        };
        if self.turns_always {
            (TAU * SPEED).log2() + velocity
        } else {
            2.0 * ((2.0 * self.reach).log2() + place)
        }
    }

    fn take_deltas(&mut self) -> Delta {
        self.referee.take_records();
        self.referee.take_delta(Self::WALKERS);
        self.referee.take_delta(Self::WATCHER).expect("each step makes a delta")
    }

    fn orders(&self, cycle: Cycle) -> Vec<Sequenced> {
        let view = self.referee.view(Self::WALKERS);
        let idle =
            view.objects_of(Self::WALKERS).filter(|(_, seen)| self.turns_always || !seen.base.is_moving());
        let go = |(object, _): (Handle, &Seen)| {
            let at = view.position(object)?;
            let aim = |purpose, at: f64| {
                let aside = 2.0 * unit(self.seed, purpose, &[cycle.0.into(), object.0.into()]) - 1.0;
                let goal = at + aside * self.reach;
                // Beyond the edge lies nothing: the goal is as far on the other side.
                let inside = 1.0..=f64::from(SIDE) - 1.0;
                let goal = if inside.contains(&goal) { goal } else { at - aside * self.reach };
                goal.clamp(*inside.start(), *inside.end())
            };
            let (x, y) = (aim(Purpose::GoalX, at.x), aim(Purpose::GoalY, at.y));
            let command = Command::Move { object, x, y, s: None, queue: false, start: None };
            Some(Sequenced { seq: object.0, command })
        };
        idle.filter_map(go).collect()
    }
}

fn files(arguments: &BenchWire) -> Files {
    let scenario = format!(
        "name = 'walk'\nmap = 'walk.map'\nrate = 8\nlength_seconds = 86400\n[objective]\nkind = 'race'\nzone_size = 1\n\
         [unit.walker]\nradius = 0.25\nspeed = {}\nsight = 3\n\
         [[seat]]\ngroups = [{{ unit = 'walker', count = 1 }}]\n\
         [[seat]]\ngroups = [{{ unit = 'walker', count = {} }}]\n",
        SPEED * 8.0,
        arguments.objects
    );
    let rows = format!("{}\n", ".".repeat(SIDE as usize)).repeat(SIDE as usize);
    let map = format!("type octile\nheight {SIDE}\nwidth {SIDE}\nmap\n{rows}");
    let file = |path: &str, text: String| LoadedFile { path: path.to_owned(), bytes: text.into_bytes() };
    Files(vec![file("walk.toml", scenario), file("walk.map", map)])
}
