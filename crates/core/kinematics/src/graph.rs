//! The motion-sphere intersection graph: who is near whom, and which collisions lie ahead if nobody is stopped.

use maniple_geometry::contact::{
    COUPLES, Couples, Glance, Mover, Straight, Window, circle_contact, segment_contact, straight_contact,
};
use maniple_geometry::{Cycle, Piece, Planar, Scalar, Segment};

use crate::bands::{Band, Bands};
use crate::lanes::{Pairs, add_pairs_of_row, add_pairs_with_level};
use crate::objects::Objects;
use crate::resting::Resting;
use crate::room::keep_room;
use crate::runner::{Halt, straight};
use crate::settings::{Method, Settings};
use crate::wall::Wall;
use crate::walls::Walls;

/// Two spheres that intersect, as nodes: numbers among those of all bands.
pub(crate) type Edge = (u32, u32);

/// Walls that are asked for one right after the other before they are looked at, so that the memory answers all at once.
const AT_ONCE: usize = 64;

/// What is the same for everybody in a cycle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Setting<'a, S: Scalar> {
    pub(crate) cycle: Cycle,
    pub(crate) objects: &'a Objects<S>,
    pub(crate) resting: &'a Resting,
    pub(crate) walls: &'a Walls<S>,
    pub(crate) bands: &'a Bands<S>,
    pub(crate) skin: S,
    /// The skin that follows from the limits, whatever the settings ask for: no rounding is larger.
    pub(crate) rounding: S,
    pub(crate) settings: Settings,
    /// Whether there are objects or walls that share no layer.
    pub(crate) is_layered: bool,
}

impl<S: Scalar> Setting<'_, S> {
    /// Whether collisions are only looked for now and then, and not predicted.
    pub(crate) fn is_stepped(&self) -> bool {
        matches!(self.settings.method, Method::Stepped { .. })
    }
}

/// A collision of an object with something at rest.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FixedHit<S: Scalar> {
    pub(crate) node: u32,
    pub(crate) time: S,
    pub(crate) halt: Halt,
}

/// The part of the graph that begins in one band.
#[derive(Clone, Debug)]
pub(crate) struct Graph<S: Scalar> {
    /// Pairs whose spheres intersect.
    pub(crate) edges: Vec<Edge>,
    /// For each pair when it collides; infinity if it does not.
    pub(crate) times: Vec<S>,
    /// Pairs that are not known to collide but have to be looked at: they end near each other, one of them turns, or nothing
    /// is predicted.
    pub(crate) close: Vec<Edge>,
    /// The first collision of each object that goes straight with anything at rest.
    pub(crate) fixed: Vec<FixedHit<S>>,
    /// Objects that have to be looked at: they turn, end near something at rest, or nothing is predicted.
    pub(crate) watched: Vec<u32>,
    /// Objects with something at rest near their way, so that their end has to be certified beside it.
    pub(crate) beside: Vec<u32>,
    /// Pairs of spheres that were tested.
    pub(crate) tested: usize,
    pairs: Pairs,
}

impl<S: Scalar> Graph<S> {
    pub(crate) fn new() -> Self {
        Self {
            edges: Vec::new(),
            times: Vec::new(),
            close: Vec::new(),
            fixed: Vec::new(),
            watched: Vec::new(),
            beside: Vec::new(),
            tested: 0,
            pairs: Pairs::default(),
        }
    }

    /// Makes the part of a band.
    pub(crate) fn connect(&mut self, band: usize, setting: &Setting<'_, S>) {
        self.edges.clear();
        self.times.clear();
        self.close.clear();
        self.fixed.clear();
        self.watched.clear();
        self.beside.clear();
        self.tested = 0;
        for row in setting.bands.bands[band].rows() {
            self.pairs.clear();
            self.tested += add_pairs_of_row(setting.bands, band, row, &mut self.pairs);
            self.judge_pairs(band, setting);
        }
        self.connect_to_levels(band, setting);
        self.look_around(band, setting);
        keep_room(&mut self.edges);
        keep_room(&mut self.times);
        keep_room(&mut self.close);
        keep_room(&mut self.fixed);
        keep_room(&mut self.watched);
        keep_room(&mut self.beside);
    }

    /// The pairs of the spheres of a band with those of the other levels that they look through.
    fn connect_to_levels(&mut self, band: usize, setting: &Setting<'_, S>) {
        let bands = setting.bands;
        let this = &bands.bands[band];
        for level in bands.levels_seen_from(band) {
            for (place, node) in (0u32..).zip(this.base..).take(this.tags.len()) {
                self.pairs.clear();
                self.tested +=
                    add_pairs_with_level(bands, level, (node, this.sphere(place)), &mut self.pairs);
                self.judge_pairs(band, setting);
            }
        }
    }

    /// Decides which of the pairs collide, a few at a time.
    fn judge_pairs(&mut self, band: usize, setting: &Setting<'_, S>) {
        let mut couples = Couples::default();
        let mut edges = [(0, 0); COUPLES];
        let mut count = 0;
        for index in 0..self.pairs.len() {
            let edge = self.pairs.at(index);
            let [(first, a), (second, b)] = find_both(setting.bands, edge, band);
            let (first_tag, second_tag) = (first.tags[a], second.tags[b]);
            if setting.is_layered && !setting.objects.share_layer(first_tag.slot(), second_tag.slot()) {
                continue;
            }
            if first_tag.turns() || second_tag.turns() || setting.is_stepped() {
                self.edges.push(edge);
                self.times.push(S::INFINITY);
                self.close.push(edge);
                continue;
            }
            couples.set(count, &first.straights[a], &second.straights[b]);
            edges[count] = edge;
            count += 1;
            if count == COUPLES {
                self.judge_couples(band, (&couples, &edges), setting);
                count = 0;
            }
        }
        self.judge_couples(band, (&couples, &edges[..count]), setting);
    }

    /// Decides about a few pairs who go straight.
    fn judge_couples(
        &mut self,
        band: usize,
        (couples, edges): (&Couples<S>, &[Edge]),
        setting: &Setting<'_, S>,
    ) {
        let mut glances = [Glance { time: S::INFINITY, is_sure: true, ends_near: false }; COUPLES];
        couples.glance((setting.skin, setting.objects.margin), &mut glances);
        for (&edge, Glance { mut time, is_sure, ends_near }) in edges.iter().zip(glances) {
            if !is_sure {
                let [(first, a), (second, b)] = find_both(setting.bands, edge, band);
                let contact = straight_contact(&first.straights[a], &second.straights[b], setting.skin);
                time = contact.unwrap_or(S::INFINITY);
            }
            self.edges.push(edge);
            self.times.push(time);
            // Few who do not collide end so near, so that this can be guessed.
            if ends_near & (time == S::INFINITY) {
                self.close.push(edge);
            }
        }
    }

    /// Finds out who has anything at rest near its way. Who does cannot be guessed, so all are written down, and most over
    /// again.
    fn find_beside(&mut self, band: usize, setting: &Setting<'_, S>) {
        let this = &setting.bands.bands[band];
        self.beside.resize(this.tags.len(), 0);
        let mut count = 0;
        for (place, (node, tag)) in (0u32..).zip((this.base..).zip(&this.tags)) {
            let sphere = this.sphere(place);
            let center = setting.bands.center(&sphere);
            let reach = f64::from(sphere.radius);
            let is_clear = setting.walls.is_clear(center, reach) && setting.resting.is_clear(center, reach);
            self.beside[count] = node;
            count += usize::from(!is_clear | tag.turns());
            if tag.turns() || (setting.is_stepped() && !is_clear) {
                self.watched.push(node);
            }
        }
        self.beside.truncate(count);
    }

    /// Finds out who collides with anything at rest; whoever has nothing near its way after all is beside nothing.
    fn look_around(&mut self, band: usize, setting: &Setting<'_, S>) {
        self.find_beside(band, setting);
        let this = &setting.bands.bands[band];
        let mut kept = 0;
        for at in (0..self.beside.len()).step_by(AT_ONCE) {
            let some = at..self.beside.len().min(at + AT_ONCE);
            let center = |&node: &u32| setting.bands.center(&this.sphere(node - this.base));
            setting.walls.fetch(self.beside[some.clone()].iter().map(center));
            for index in some {
                let node = self.beside[index];
                let place = (node - this.base) as usize;
                let (tag, Straight { point, velocity, radius }) = (this.tags[place], this.straights[place]);
                self.beside[kept] = node;
                if tag.turns() || setting.is_stepped() {
                    kept += 1;
                    continue;
                }
                let mut around = Around::new(tag.slot(), radius, setting);
                let reach = f64::from(setting.objects.states[tag.slot() as usize].reach);
                around.meet(&straight(point, velocity), reach, setting);
                kept += usize::from(around.is_beside);
                match around.first {
                    Some((time, halt)) => self.fixed.push(FixedHit { node, time, halt }),
                    None if around.ends_near => self.watched.push(node),
                    None => {}
                }
            }
        }
        self.beside.truncate(kept);
    }

    /// Bytes on the heap.
    pub(crate) fn bytes(&self) -> usize {
        size_of::<Edge>() * (self.edges.capacity() + self.close.capacity())
            + self.pairs.bytes()
            + size_of::<S>() * self.times.capacity()
            + size_of::<FixedHit<S>>() * self.fixed.capacity()
            + size_of::<u32>() * (self.watched.capacity() + self.beside.capacity())
    }
}

/// Returns where both nodes of an edge are; the first of each, and most of the second, are in a band.
#[inline]
fn find_both<S: Scalar>(bands: &Bands<S>, (a, b): Edge, band: usize) -> [(&Band<S>, usize); 2] {
    [bands.find(a, band), bands.find(b, band)]
}

/// What at rest an object meets in a cycle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Around<S: Scalar> {
    layers: u32,
    radius: S,
    /// The first collision.
    pub(crate) first: Option<(S, Halt)>,
    /// Whether anything reaches into a motion sphere.
    is_beside: bool,
    /// Whether a piece ends so near to something that rounding could make it overlap.
    pub(crate) ends_near: bool,
}

impl<S: Scalar> Around<S> {
    pub(crate) fn new(slot: u32, radius: S, setting: &Setting<'_, S>) -> Self {
        let layers = if setting.is_layered { setting.objects.layers[slot as usize].0 } else { u32::MAX };
        Self { layers, radius, first: None, is_beside: false, ends_near: false }
    }

    /// Adds what a piece meets; `reach` is the radius of its motion sphere.
    #[inline]
    pub(crate) fn meet(&mut self, piece: &Piece<S>, reach: f64, setting: &Setting<'_, S>) {
        let (from, to) = (piece.point, piece.position(piece.until));
        let center = (from.to_dvec2() + to.to_dvec2()) * 0.5;
        setting.walls.near(center, reach, |wall| {
            if wall.layers.0 & self.layers != 0 {
                self.meet_wall(piece, to, wall, (setting.skin, setting.objects.margin));
            }
        });
        setting.resting.near(center, reach, |slot| {
            if !setting.is_layered || setting.objects.layers[slot as usize].0 & self.layers != 0 {
                self.meet_object(piece, to, slot, setting);
            }
        });
    }

    fn meet_wall(&mut self, piece: &Piece<S>, to: S::Vector, wall: &Wall<S>, (skin, margin): (S, S)) {
        self.is_beside = true;
        let reach = self.radius + margin;
        let way = (piece.point, to);
        if is_box_clear(way, &wall.segment, reach) || is_line_clear(way, &wall.segment, reach) {
            return;
        }
        let window = Window { from: piece.since, to: piece.until, skin };
        match segment_contact(Mover { piece, radius: self.radius }, &wall.segment, window) {
            Some(time) => {
                self.add(time, Halt::at_wall(wall.kind.event()));
            }
            None => self.ends_near |= is_within(to, &wall.segment, reach),
        }
    }

    fn meet_object(&mut self, piece: &Piece<S>, to: S::Vector, slot: u32, setting: &Setting<'_, S>) {
        self.is_beside = true;
        let (state, intent) = setting.objects.of(slot);
        let window = Window { from: piece.since, to: piece.until, skin: setting.skin };
        let still = Piece::at_rest(state.start, piece.since, piece.until);
        let movers = (Mover { piece, radius: self.radius }, Mover { piece: &still, radius: state.radius });
        match circle_contact(movers.0, movers.1, window) {
            Some(time) => self.add(time, Halt::beside(intent.id)),
            None => {
                let near = self.radius + state.radius + setting.objects.margin;
                let between = state.start - to;
                self.ends_near |= between.dot(between) < near * near;
            }
        }
    }

    fn add(&mut self, time: S, halt: Halt) {
        self.first = match self.first {
            Some((first, other)) if first == time => Some((time, other.merged(halt))),
            Some((first, other)) if first < time => Some((first, other)),
            _ => Some((time, halt)),
        };
    }
}

/// Whether the boxes of a way and of a segment are further apart than `reach`.
fn is_box_clear<S: Scalar>((from, to): (S::Vector, S::Vector), segment: &Segment<S>, reach: S) -> bool {
    let apart =
        |a: S, b: S, c: S, d: S| a.lesser(b) > c.greater(d) + reach || a.greater(b) < c.lesser(d) - reach;
    apart(from.x(), to.x(), segment.start.x(), segment.end.x())
        || apart(from.y(), to.y(), segment.start.y(), segment.end.y())
}

/// Whether a way stays on one side of the line of a segment, further than `reach` from it: `(e × q)² > reach² e²` at both
/// ends, with the same sign. The reach has two skins of room, which outweigh the rounding.
fn is_line_clear<S: Scalar>((from, to): (S::Vector, S::Vector), segment: &Segment<S>, reach: S) -> bool {
    let e = segment.direction();
    let bound = reach * reach * e.dot(e);
    let (before, after) = (e.cross(from - segment.start), e.cross(to - segment.start));
    before * before > bound && after * after > bound && (before > S::ZERO) == (after > S::ZERO)
}

/// Whether a point is within `reach` of a segment, up to rounding.
fn is_within<S: Scalar>(point: S::Vector, segment: &Segment<S>, reach: S) -> bool {
    let between = segment.nearest(point) - point;
    between.dot(between) < reach * reach
}
