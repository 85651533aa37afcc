//! The measurement: all engines in turns on one scene.

use std::time::Duration;

use glam::DVec2;
use rustix::time::{ClockId, clock_gettime};

use crate::engines::{Engine, Kind};
use crate::judge::Verdict;
use crate::march::{CONTACT, March, Scene};

/// Cycles before the first that counts: until then the march has reached its steady state, and the engines have grown.
const WARM_UP_CYCLES: usize = 10;

/// Timed cycles of one turn of an engine: short enough for noise of the machine to hit all engines, long enough to
/// work in warm caches.
const TURN_CYCLES: usize = 5;

/// What was measured of an engine on a scene.
#[derive(Clone, Debug)]
pub(crate) struct Measured {
    /// The engine.
    pub(crate) engine: Kind,
    /// CPU time of the step, in nanoseconds per object and cycle: the median over the cycles.
    pub(crate) step_ns: f64,
    /// CPU time of orders and reading back, in nanoseconds per object and cycle: the median over the cycles.
    pub(crate) orders_ns: f64,
    /// What the judge says of the timed cycles.
    pub(crate) verdict: Verdict,
}

/// Lets engines march through a scene for a number of timed cycles, in turns.
pub(crate) fn measure(engines: &[Kind], scene: &Scene, cycles: usize) -> Vec<Measured> {
    let mut marchers: Vec<Marcher<'_>> = engines.iter().map(|&kind| Marcher::new(kind, scene)).collect();
    for marcher in &mut marchers {
        for _ in 0..WARM_UP_CYCLES {
            marcher.rewarm();
        }
    }
    let mut left = cycles;
    while left > 0 {
        let turn = left.min(TURN_CYCLES);
        for marcher in &mut marchers {
            marcher.take_turn(turn);
        }
        left -= turn;
    }
    marchers.into_iter().map(Marcher::measured).collect()
}

/// An engine on its march.
struct Marcher<'a> {
    kind: Kind,
    engine: Box<dyn Engine>,
    march: March<'a>,
    /// The positions at the start of a turn, and after each of its cycles.
    positions: Vec<Vec<DVec2>>,
    times: Vec<Times>,
    verdict: Verdict,
}

/// CPU time of one cycle.
#[derive(Clone, Copy, Debug)]
struct Times {
    step: Duration,
    orders: Duration,
}

impl<'a> Marcher<'a> {
    fn new(kind: Kind, scene: &'a Scene) -> Self {
        Self {
            kind,
            engine: kind.build(scene),
            march: March::new(scene),
            positions: vec![scene.starts.clone(); TURN_CYCLES + 1],
            times: Vec::new(),
            verdict: Verdict::new(CONTACT),
        }
    }

    /// Makes one cycle that does not count.
    fn rewarm(&mut self) {
        self.cycle(0);
        self.positions.swap(0, 1);
    }

    /// Makes a cycle to get the caches back, then cycles that count; judges them in the end.
    fn take_turn(&mut self, cycles: usize) {
        self.rewarm();
        for cycle in 0..cycles {
            let times = self.cycle(cycle);
            self.times.push(times);
        }
        for ends in self.positions[..=cycles].windows(2) {
            self.verdict.add_cycle(&ends[0], &ends[1]);
        }
        self.positions.swap(0, cycles);
    }

    /// Makes the cycle from the positions of index `cycle` to those after them.
    fn cycle(&mut self, cycle: usize) -> Times {
        let (before, after) = self.positions.split_at_mut(cycle + 1);
        let (before, after) = (&before[cycle], &mut after[0]);
        let start = cpu_time();
        self.engine.order(self.march.velocities());
        let ordered = cpu_time();
        self.engine.step();
        let stepped = cpu_time();
        self.engine.read(after);
        let read = cpu_time();
        self.march.turn(before, after);
        Times { step: stepped - ordered, orders: (ordered - start) + (read - stepped) }
    }

    fn measured(self) -> Measured {
        let objects = self.positions[0].len() as f64;
        let per_object = |part: fn(&Times) -> Duration| {
            median(self.times.iter().map(part).collect()).as_secs_f64() * 1e9 / objects
        };
        Measured {
            engine: self.kind,
            step_ns: per_object(|times| times.step),
            orders_ns: per_object(|times| times.orders),
            verdict: self.verdict,
        }
    }
}

/// Returns the middle one, the upper of two; there is at least one.
fn median(mut times: Vec<Duration>) -> Duration {
    times.sort_unstable();
    times[times.len() / 2]
}

/// Returns the CPU time of the whole process, so that a thread that an engine starts is counted.
fn cpu_time() -> Duration {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    Duration::try_from(time).expect("CPU time is not negative")
}
