//! Counts what a seat is told.

use maniple_bots::Bot;
use maniple_protocol::{Encoding, Outbound, ServerMessage, encode_server};
use maniple_view::{Command, Delta, Rules, Seat, Terrain, View};

/// Bytes of a frame before its list of absolute positions: length, tag and how many.
const ABSOLUTE_HEAD: usize = 4 + 1 + 1;

/// Bytes of two doubles.
const POINT: usize = 16;

/// What was told. Doubles, because everything is divided by something.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Count {
    pub(super) deltas: f64,
    /// Moving objects in the view, summed over the deltas.
    pub(super) moving: f64,
    /// Motions that began or ended.
    pub(super) events: f64,
    /// Motions that began.
    pub(super) begun: f64,
    /// Bytes of absolute positions.
    pub(super) absolute: f64,
    /// Bytes of plain deltas.
    pub(super) plain: f64,
    /// Bytes of packed deltas.
    pub(super) packed: f64,
}

impl Count {
    /// Adds what another seat was told.
    pub(super) fn add(&mut self, other: &Self) {
        self.deltas += other.deltas;
        self.moving += other.moving;
        self.events += other.events;
        self.begun += other.begun;
        self.absolute += other.absolute;
        self.plain += other.plain;
        self.packed += other.packed;
    }
}

/// What goes to a seat, in each way to write it.
pub(super) struct Meter {
    outbound: Outbound,
    has_begun: bool,
    pub(super) count: Count,
}

impl Meter {
    /// Returns the meter of a seat that was told nothing yet.
    pub(super) fn new(rules: &Rules) -> Self {
        Self {
            outbound: Outbound::for_deltas(Encoding::Binary, rules),
            has_begun: false,
            count: Count::default(),
        }
    }

    /// Counts the next delta, which leads to this view; the first is a keyframe, and is not counted.
    pub(super) fn take(&mut self, view: &View, delta: &Delta) {
        let message = ServerMessage::Delta(delta.clone());
        let length = "a delta of a bench is far shorter than a frame may be";
        let packed = self.outbound.encode(&message).expect(length);
        if !std::mem::replace(&mut self.has_begun, true) {
            return;
        }
        let plain = encode_server(Encoding::Binary, &message).expect(length);
        let moving = || view.objects().filter(|(_, seen)| seen.base.is_moving());
        let positions: usize = moving().map(|(handle, _)| varint(handle.0) + POINT).sum();
        let (moved, stopped) = (delta.moved.len() as f64, delta.stopped.len() as f64);
        self.count.add(&Count {
            deltas: 1.0,
            moving: moving().count() as f64,
            events: moved + stopped,
            begun: moved,
            absolute: (ABSOLUTE_HEAD + varint(delta.cycle.0) + positions) as f64,
            plain: plain.len() as f64,
            packed: packed.len() as f64,
        });
    }
}

/// A bot, and what its seat is told.
pub(super) struct Metered<B> {
    bot: B,
    meter: Option<Meter>,
}

impl<B> Metered<B> {
    pub(super) fn new(bot: B) -> Self {
        Self { bot, meter: None }
    }

    /// Returns what the seat was told.
    pub(super) fn count(&self) -> Count {
        self.meter.as_ref().map_or_else(Count::default, |meter| meter.count)
    }
}

impl<B: Bot> Bot for Metered<B> {
    fn name(&self) -> &'static str {
        self.bot.name()
    }

    fn on_start(&mut self, seat: Seat, rules: &Rules, terrain: &Terrain) {
        self.meter = Some(Meter::new(rules));
        self.bot.on_start(seat, rules, terrain);
    }

    fn on_cycle(&mut self, view: &View, delta: &Delta) -> Vec<Command> {
        if let Some(meter) = &mut self.meter {
            meter.take(view, delta);
        }
        self.bot.on_cycle(view, delta)
    }
}

/// Returns the bytes of a number as the general codec writes it.
fn varint(number: u32) -> usize {
    match number {
        0..=250 => 1,
        251..=65_535 => 3,
        65_536.. => 5,
    }
}
