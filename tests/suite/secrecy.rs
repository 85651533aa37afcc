//! Fog leaks nothing: generated pairs of worlds that differ only in what a seat cannot see give it the same bytes.
//!
//! In each pair everything that its team may know is worked out by a slow twin of sight, in both worlds, after each cycle. As long as
//! all of it is alike, the bytes are. At the first difference the pair ends; but it must have a cause: what others chose to do, or what
//! hidden ones did to somebody. Answers to commands are alike in that cycle, too.

mod dice;
mod judge;
mod players;
mod scene;
mod script;
mod twin;

use std::collections::{BTreeMap, BTreeSet};
use std::ops::AddAssign;

use maniple_geometry::{Cycle, ObjectId};
use maniple_protocol::{Encoding, Outbound, ServerMessage, Welcome, encode_server};
use maniple_referee::Referee;
use maniple_view::{
    ClockMode, Command, CommandResult, Delta, Digest, Handle, Outcome, Refusal, Scalar, Seat, Sequenced, View,
};
use rayon::prelude::*;

use dice::Dice;
use judge::{Judge, Look, Verdict};
use players::{Gone, Names, Secret, Watcher};
use scene::{Role, Scene};
use twin::Twin;

/// Scenes of the ordinary run; `MANIPLE_LONG=1` plays thirty times as many, `MANIPLE_SCENE=7` only the one with this seed.
const SCENES: u64 = 1000;

/// Most cycles of a pair.
const CYCLES: u32 = 110;

#[test]
fn worlds_that_differ_only_in_what_a_seat_cannot_see_give_it_the_same_bytes() {
    if let Some(seed) = std::env::var_os("MANIPLE_SCENE") {
        let seed = seed.into_string().unwrap().parse().unwrap();
        println!("{}", Scene::new(seed).text);
        println!("{:#?}", play(seed));
        return;
    }
    let scenes = if std::env::var_os("MANIPLE_LONG").is_some() { 30 * SCENES } else { SCENES };
    let tally = (0..scenes).into_par_iter().map(play).reduce(Tally::default, |mut one, other| {
        one += other;
        one
    });
    println!("{scenes} scenes: {tally:#?}");
    let least = |part: u64| scenes * part / 100;
    for (name, part) in LEAST {
        let count = tally.scenes_with.get(name).copied().unwrap_or(0);
        assert!(count >= least(part), "{name} in {count} of {scenes} scenes only");
    }
    assert!(tally.cycles > 40 * scenes, "{} cycles", tally.cycles);
}

/// What scenes have to have, and of how many in a hundred.
const LEAST: [(&str, u64); 15] = [
    ("hidden fight", 60),
    ("hidden death", 30),
    ("death of somebody who vanished", 4),
    ("hidden production", 60),
    ("crossing into sight", 60),
    ("crossing out of sight", 50),
    ("several came at once", 10),
    ("shot in sight", 40),
    ("death in sight", 20),
    ("own production", 40),
    ("command to somebody in sight", 60),
    ("command to somebody who vanished", 50),
    ("command to somebody who died", 20),
    ("command to nobody", 90),
    ("worlds differ", 95),
];

/// What was played.
#[derive(Debug, Default)]
struct Tally {
    /// How many cycles were compared.
    cycles: u64,
    bytes: u64,
    /// How many scenes had what.
    scenes_with: BTreeMap<&'static str, u64>,
    /// Why pairs ended.
    ends: BTreeMap<&'static str, u64>,
}

impl AddAssign for Tally {
    fn add_assign(&mut self, other: Self) {
        self.cycles += other.cycles;
        self.bytes += other.bytes;
        for (name, count) in other.scenes_with {
            *self.scenes_with.entry(name).or_default() += count;
        }
        for (name, count) in other.ends {
            *self.ends.entry(name).or_default() += count;
        }
    }
}

impl Tally {
    fn note(&mut self, name: &'static str, is_there: bool) {
        if is_there {
            self.scenes_with.insert(name, 1);
        }
    }
}

/// Plays the pair of a seed.
fn play(seed: u64) -> Tally {
    let result = std::panic::catch_unwind(|| Pair::new(seed).play());
    result.unwrap_or_else(|panic| {
        eprintln!("with MANIPLE_SCENE={seed} the test plays this scene alone");
        std::panic::resume_unwind(panic)
    })
}

/// Two worlds that are played side by side.
struct Pair {
    seed: u64,
    scene: Scene,
    sides: [Side; 2],
    judge: Judge,
    watcher: Watcher,
    gone: Gone,
    /// By world, everybody whom the watcher has seen.
    seen: [BTreeSet<ObjectId>; 2],
    tally: Tally,
}

/// One of the worlds.
struct Side {
    world: usize,
    referee: Referee,
    names: Vec<Names>,
    /// The roles, and where they have been told to go.
    roles: BTreeMap<ObjectId, (Role, Option<glam::DVec2>)>,
    secret: Dice,
    /// What the watcher was told last.
    delta: Delta,
    /// A binary connection of the watcher, and what it carried last.
    outbound: Outbound,
    frame: Vec<u8>,
}

impl Side {
    fn new(scene: &Scene, world: usize, seed: u64) -> Self {
        let mut referee = Referee::new(scene.loaded[world].clone(), ClockMode::Lockstep).unwrap();
        referee.handle_join(scene.watcher, "watcher").unwrap();
        let delta = referee.take_delta(scene.watcher).unwrap();
        referee.take_records();
        let names = vec![Names::default(); referee.seats()];
        let roles = scene.numbers[world].iter().enumerate();
        let roles = roles.map(|(role, &number)| (ObjectId(number), (role, None))).collect();
        let secret = Dice::new(seed, 100 + world as u64);
        let mut outbound = Outbound::for_deltas(Encoding::Binary, &referee.rules());
        let frame = outbound.encode(&ServerMessage::Delta(delta.clone())).unwrap();
        let mut side = Self { world, referee, names, roles, secret, delta, outbound, frame };
        side.name();
        side
    }

    fn name(&mut self) {
        let world = self.referee.world();
        for (seat, names) in (0..).map(Seat).zip(&mut self.names) {
            names.update(world.cycle(), &world.sightings(seat));
        }
    }

    /// Plays a cycle with these commands of the watcher before all that the script says.
    fn step(&mut self, scene: &Scene, told: &[Command], twin: &Twin) {
        let cycle = self.referee.cycle();
        let mut commands: Vec<(Seat, Command)> =
            told.iter().map(|command| (scene.watcher, command.clone())).collect();
        for line in scene.script.iter().filter(|line| line.at == cycle.0) {
            if line.world.is_some_and(|world| world != self.world) {
                continue;
            }
            let object = ObjectId(scene.numbers[self.world][line.role]);
            let seat = scene.actors[line.role].seat.expect("nobody's are told nothing");
            let Some(handle) = self.names[seat.index()].of(object) else {
                continue;
            };
            commands.push((seat, line.order.command(handle)));
            self.roles.insert(object, (line.role, line.order.goal()));
        }
        let mut secret = Secret {
            dice: &mut self.secret,
            cycle,
            watcher: scene.watcher,
            objects: self.referee.world().objects(),
            unit_types: &twin.unit_types,
            names: &self.names,
            roles: &self.roles,
        };
        commands.extend(secret.orders());
        for (seq, (seat, command)) in (0..).zip(commands) {
            self.referee.handle_commands(seat, cycle, vec![Sequenced { seq, command }]).unwrap();
        }
        self.referee.step();
        self.referee.take_records();
        self.delta = self.referee.take_delta(scene.watcher).unwrap();
        self.frame = self.outbound.encode(&ServerMessage::Delta(self.delta.clone())).unwrap();
        self.name();
    }

    /// Returns all that the watcher's connection could carry in this cycle, in every encoding.
    fn bytes(&self, watcher: Seat) -> Vec<Vec<u8>> {
        let keyframe = ServerMessage::Delta(self.referee.keyframe(watcher));
        let mut fresh = Outbound::for_deltas(Encoding::Binary, &self.referee.rules());
        let mut bytes = vec![self.frame.clone(), fresh.encode(&keyframe).unwrap()];
        for message in [ServerMessage::Delta(self.delta.clone()), keyframe] {
            for encoding in [Encoding::Json, Encoding::Binary] {
                bytes.push(encode_server(encoding, &message).unwrap());
            }
        }
        bytes
    }

    fn welcome(&self, watcher: Seat) -> Vec<u8> {
        let welcome = Welcome {
            match_id: Digest(1),
            seat: Some(watcher),
            delay: None,
            seats: u16::try_from(self.referee.seats()).unwrap(),
            cycle: self.referee.cycle(),
            rate: self.referee.rate(),
            clock: ClockMode::Lockstep,
            rules: self.referee.rules(),
            terrain: (**self.referee.terrain()).clone(),
        };
        encode_server(Encoding::Json, &ServerMessage::Welcome(welcome)).unwrap()
    }
}

impl Pair {
    fn new(seed: u64) -> Self {
        let scene = Scene::new(seed);
        let sides = [0, 1].map(|world| Side::new(&scene, world, seed));
        let twins = [0, 1].map(|world| twin(&scene, &sides[world]));
        let unit_types = twins[0].unit_types.clone();
        let [one, other] = scene.numbers.each_ref().map(|numbers| numbers.iter().copied().map(ObjectId));
        let roles = one.zip(other).collect();
        let watcher = Watcher { seat: scene.watcher, dice: Dice::new(seed, 50), unit_types };
        let (judge, gone, tally) = (Judge::new(twins, roles), Gone::default(), Tally::default());
        Self { seed, scene, sides, judge, watcher, gone, seen: Default::default(), tally }
    }

    fn play(mut self) -> Tally {
        let watcher = self.scene.watcher;
        assert!(
            self.sides[0].welcome(watcher) == self.sides[1].welcome(watcher),
            "seed {}: rules",
            self.seed
        );
        let mut before = self.look();
        let mut verdict = self.judge.begin(&before);
        loop {
            let cycle = before[0].cycle;
            match verdict {
                Verdict::Alike => self.compare_bytes(&before),
                Verdict::Differs(reason) => {
                    *self.tally.ends.entry(reason).or_default() += 1;
                    break;
                }
                Verdict::Leak(what) => panic!("seed {}, cycle {cycle}: {what}", self.seed),
            }
            if cycle == Cycle(CYCLES) {
                *self.tally.ends.entry("length").or_default() += 1;
                break;
            }
            let (commands, refused) = self.commands();
            for side in &mut self.sides {
                side.step(&self.scene, &commands, &self.judge.twins[side.world]);
            }
            self.check_answers(&refused);
            let now = self.look();
            verdict = self.judge.compare(&before, &now);
            if let Verdict::Alike = verdict {
                self.count(&before, &now);
            }
            before = now;
        }
        let hashes = [0, 1].map(|world| self.sides[world].referee.hash());
        self.tally.note("worlds differ", hashes[0] != hashes[1]);
        self.tally
    }

    fn look(&self) -> [Look; 2] {
        [0, 1].map(|world| Look::new(&self.judge.twins[world], self.sides[world].referee.world()))
    }

    /// Compares all bytes, and each view with what the twin says.
    fn compare_bytes(&mut self, now: &[Look; 2]) {
        let watcher = self.scene.watcher;
        let [one, other] = [0, 1].map(|world| self.sides[world].bytes(watcher));
        let cycle = self.sides[0].referee.cycle();
        if one != other {
            // The first that differs of those that a person can read, which are the delta and the keyframe in JSON.
            let differs = |&place: &usize| one[place] != other[place];
            let place = [2, 4].into_iter().find(differs).unwrap_or(2);
            let text = |bytes: &[Vec<u8>]| String::from_utf8_lossy(&bytes[place]).into_owned();
            panic!("seed {}, cycle {cycle}: bytes differ\n{}\n{}", self.seed, text(&one), text(&other));
        }
        self.tally.cycles += 1;
        self.tally.bytes += one.iter().map(|bytes| bytes.len() as u64).sum::<u64>();
        for (side, Look { seen, .. }) in self.sides.iter().zip(now) {
            let view = side.referee.view(watcher);
            assert_eq!(view.objects().count(), seen.objects.len(), "seed {}, cycle {cycle}", self.seed);
            for (y, row) in (0..).zip(&seen.tiles) {
                for (x, &is_seen) in (0..).zip(row) {
                    assert_eq!(view.is_visible(x, y), is_seen, "seed {}, cycle {cycle}: {x} {y}", self.seed);
                }
            }
        }
        let delta = &self.sides[0].delta;
        let fresh = self.gone.next;
        for (handle, appeared) in (fresh..).zip(&delta.appeared) {
            assert_eq!(appeared.object, Handle(handle), "seed {}, cycle {cycle}: no fresh handle", self.seed);
        }
        self.gone.next += u32::try_from(delta.appeared.len()).unwrap();
        self.gone.vanished.extend_from_slice(&delta.vanished);
        self.gone.died.extend_from_slice(&delta.died);
    }

    /// Returns what the watcher commands in a cycle, and which of the commands must be refused with which answer.
    fn commands(&mut self) -> (Vec<Command>, Vec<Aimed>) {
        let view = self.sides[0].referee.view(self.scene.watcher).clone();
        let (mut commands, mut aimed) = (Vec::new(), Vec::new());
        for (name, handle) in self.strangers(&view) {
            self.tally.note(name, true);
            aimed.push(Aimed { place: commands.len(), is_at_target: false });
            commands.push(self.watcher.foreign_command(handle));
        }
        let own: Vec<Handle> = view.objects_of(self.scene.watcher).map(|(handle, _)| handle).collect();
        if !own.is_empty() {
            let object = self.watcher.dice.one(&own);
            let gathers = self.watcher.dice.percent(50);
            let unseen =
                self.strangers(&view).into_iter().filter(|&(_, handle)| view.object(handle).is_none());
            for (_, target) in unseen {
                aimed.push(Aimed { place: commands.len(), is_at_target: true });
                commands.push(if gathers {
                    Command::Gather { object, patch: target }
                } else {
                    Command::Attack { object, target }
                });
            }
        }
        commands.extend(self.watcher.orders(&view));
        (commands, aimed)
    }

    /// Returns handles that are not those of own objects: of one in sight, one that vanished, one that died and one that never was.
    fn strangers(&mut self, view: &View) -> Vec<(&'static str, Handle)> {
        let foreign = |(handle, it): (Handle, &maniple_view::Seen)| {
            (it.owner != Some(self.scene.watcher)).then_some(handle)
        };
        let seen: Vec<Handle> = view.objects().filter_map(foreign).collect();
        let dice = &mut self.watcher.dice;
        let never = vec![Handle(self.gone.next + dice.below(3)), Handle(u32::MAX)];
        [
            ("command to somebody in sight", &seen),
            ("command to somebody who vanished", &self.gone.vanished),
            ("command to somebody who died", &self.gone.died),
            ("command to nobody", &never),
        ]
        .into_iter()
        .filter(|(_, handles)| !handles.is_empty())
        .map(|(name, handles)| (name, dice.one(handles)))
        .collect()
    }

    /// Checks that the watcher is answered the same in both worlds, and to what it cannot command always the same.
    fn check_answers(&self, aimed: &[Aimed]) {
        let [one, other] = [0, 1].map(|world| &self.sides[world].delta.results);
        assert_eq!(one, other, "seed {}, cycle {}", self.seed, self.sides[0].referee.cycle());
        let mut at_targets = Vec::new();
        for &Aimed { place, is_at_target } in aimed {
            let CommandResult { outcome, .. } = &one[place];
            let Outcome::Refused { reason } = outcome else { panic!("seed {}: {outcome:?}", self.seed) };
            if is_at_target {
                at_targets.push(reason);
            } else {
                assert_eq!(*reason, Refusal::UnknownHandle, "seed {}", self.seed);
            }
        }
        // Who switches its mode is busy, whatever it is told to attack.
        let is_one_answer = |answer: Refusal| at_targets.iter().all(|reason| **reason == answer);
        let is_expected = is_one_answer(Refusal::UnknownTarget) || is_one_answer(Refusal::Busy);
        assert!(is_expected, "seed {}: {at_targets:?}", self.seed);
    }

    /// Counts what happened in a cycle after which the worlds are still alike to the watcher.
    fn count(&mut self, before: &[Look; 2], now: &[Look; 2]) {
        let tally = &mut self.tally;
        for world in [0, 1] {
            let (was, is) = (&before[world], &now[world]);
            let is_hidden = |object: ObjectId| !was.sees(object) && !is.sees(object);
            let is_fight =
                |shot: &(ObjectId, Option<ObjectId>)| is_hidden(shot.0) && shot.1.is_none_or(is_hidden);
            tally.note("hidden fight", is.shots.iter().any(is_fight));
            tally.note("hidden death", is.dead.iter().any(|&object| is_hidden(object)));
            self.seen[world].extend(is.seen.objects.keys());
            let is_unseen = |object: &&ObjectId| is_hidden(**object) && self.seen[world].contains(object);
            tally.note("death of somebody who vanished", is.dead.iter().any(|object| is_unseen(&object)));
            let is_new = |object: &&ObjectId| !was.all.contains_key(object);
            tally.note("hidden production", is.all.keys().filter(is_new).any(|&object| is_hidden(object)));
        }
        let (was, is) = (&before[0], &now[0]);
        let came = is
            .seen
            .objects
            .keys()
            .filter(|&&object| !was.sees(object) && was.all.contains_key(&object))
            .count();
        let left = was.seen.objects.keys().any(|&object| !is.sees(object) && is.all.contains_key(&object));
        tally.note("crossing into sight", came > 0);
        tally.note("several came at once", came > 1);
        tally.note("crossing out of sight", left);
        tally.note("shot in sight", !self.sides[0].delta.shots.is_empty());
        tally.note("death in sight", !self.sides[0].delta.died.is_empty());
        let watcher = self.scene.watcher;
        let is_own = |it: &maniple_view::Appeared| it.owner == Some(watcher);
        tally.note("own production", self.sides[0].delta.appeared.iter().any(is_own));
    }
}

/// A command that is aimed at somebody who is not the watcher's, or not in sight.
struct Aimed {
    place: usize,
    is_at_target: bool,
}

/// Returns the twin of sight of a side.
fn twin(scene: &Scene, side: &Side) -> Twin {
    let rules = side.referee.rules();
    let map = &scene.loaded[side.world].map;
    let is_blocked = |x, y| !map.is_passable(x, y);
    Twin {
        blocked: (0..map.height()).map(|y| (0..map.width()).map(|x| is_blocked(x, y)).collect()).collect(),
        walls_block: rules.walls_block,
        is_single: scene.loaded[side.world].scenario.profile.scalar == Scalar::F32,
        unit_types: rules.unit_types,
        teams: rules.teams,
        watcher: scene.watcher,
    }
}
