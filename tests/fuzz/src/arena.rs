//! A small match with every rule, for the targets that need one.

use std::sync::{Arc, OnceLock};

use maniple_game::{Files, Loaded, LoadedFile, Overrides, load};
use maniple_geometry::Cycle;
use maniple_protocol::encode_snapshot;
use maniple_referee::{RecordedEvent, Referee};
use maniple_view::{ClockMode, Command, Handle, Rules, Seat, Sequenced, Start, UnitTypeId, Vantage, View};

/// Cycles that a match lasts here.
const CYCLES: u32 = 48;

/// Things that are done at most, so that no input takes long.
const ACTS: u32 = 600;

const SCENARIO: &str = r#"
name = "fuzz"
rate = 4
length_seconds = 60
seed = 5
units = ["orts.toml"]
[generate]
kind = "obstacles"
width = 32
height = 24
clusters = 1
patches = 2
amount = 6
[vision]
terrain = "explored"
walls_block = true
identity = "persistent"
[combat]
friendly_fire = true
[harvest]
patch = "mineral"
[production]
[modes]
[neutral]
groups = [{ unit = "sheep", count = 2 }]
[spectators]
views = "all"
delay_seconds = 1
[objective]
kind = "kills"
[[seat]]
stock = 900
groups = [{ unit = "control_center", count = 1 }, { unit = "worker", count = 2 }, { unit = "siege_tank", count = 1 }]
[[seat]]
stock = 900
groups = [{ unit = "control_center", count = 1 }, { unit = "worker", count = 2 }, { unit = "marine", count = 2 }]
"#;

/// Returns what the match is made of.
pub(crate) fn loaded() -> Arc<Loaded> {
    static LOADED: OnceLock<Arc<Loaded>> = OnceLock::new();
    let made = || {
        let file =
            |path: &str, text: &str| LoadedFile { path: path.to_owned(), bytes: text.as_bytes().to_vec() };
        let units = include_str!("../../../config/units/orts.toml");
        let files = Files(vec![file("fuzz.toml", SCENARIO), file("orts.toml", units)]);
        Arc::new(load(&files, "fuzz.toml", &Overrides::default()).unwrap_or_else(|error| panic!("{error}")))
    };
    Arc::clone(LOADED.get_or_init(made))
}

/// Returns the view of a seat in the middle of the match, and its rules.
pub(crate) fn view() -> &'static (View, Rules) {
    static VIEW: OnceLock<(View, Rules)> = OnceLock::new();
    VIEW.get_or_init(|| {
        let mut play = Play::new();
        let (input, _) = story();
        let mut bytes = Bytes::new(&input);
        while play.referee.cycle() < Cycle(12) && play.act(&mut bytes).is_some() {}
        (play.views[0].clone(), play.referee.rules())
    })
}

/// Returns an input that lets the match go on for a while, and the bodies of the snapshots on its way.
pub(crate) fn story() -> (Vec<u8>, Vec<Vec<u8>>) {
    let mut state = 7u32;
    let mut byte = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        state.to_be_bytes()[0]
    };
    let input: Vec<u8> = (0..2500).map(|_| byte()).collect();
    let (mut play, mut bytes, mut bodies) = (Play::new(), Bytes::new(&input), Vec::new());
    let mut last = Cycle(0);
    while play.goes_on() && play.act(&mut bytes).is_some() {
        let cycle = play.referee.cycle();
        if cycle != last && [1, 9, 20, 40].contains(&cycle.0) {
            let whole = encode_snapshot(&play.referee.snapshot()).unwrap();
            bodies.push(whole[6..whole.len() - 8].to_vec());
        }
        last = cycle;
    }
    (input, bodies)
}

/// Bytes that are taken one after the other.
pub(crate) struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        Self(bytes)
    }

    fn byte(&mut self) -> Option<u8> {
        let (&first, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(first)
    }

    /// A number: mostly a place on the map, now and then one that no world accepts, or any.
    fn number(&mut self) -> Option<f64> {
        const ODD: [f64; 8] = [0.0, -0.0, f64::NAN, f64::INFINITY, -1.0, 1e-300, 1e300, 5e-324];
        let byte = self.byte()?;
        Some(match byte {
            0..=239 => f64::from(byte) / 7.5,
            240..=247 => ODD[usize::from(byte - 240)],
            248..=255 => {
                let (head, rest) = self.0.split_first_chunk::<8>()?;
                self.0 = rest;
                f64::from_le_bytes(*head)
            }
        })
    }

    fn handle(&mut self) -> Option<Handle> {
        let byte = u32::from(self.byte()?);
        Some(Handle(if byte < 224 { byte % 16 } else { byte * 0x0101_0101 }))
    }

    fn start(&mut self) -> Option<Option<Start>> {
        Some(match self.byte()? {
            byte @ 0..16 => Some((Cycle(u32::from(byte) * 3), self.number()?)),
            16.. => None,
        })
    }

    fn unit_type(&mut self) -> Option<UnitTypeId> {
        Some(UnitTypeId(u16::from(self.byte()? % 12)))
    }

    fn command(&mut self) -> Option<Command> {
        let kind = self.byte()? % 32;
        let object = self.handle()?;
        Some(match kind {
            0..6 => {
                let (x, y) = (self.number()?, self.number()?);
                let s = if kind == 0 { Some(self.number()?) } else { None };
                Command::Move { object, x, y, s, queue: kind > 3, start: self.start()? }
            }
            6..9 => {
                let mut points = Vec::new();
                for _ in 0..self.byte()? % 70 {
                    points.push((self.number()?, self.number()?, None));
                }
                Command::Path { object, points, start: self.start()? }
            }
            9 => Command::Stop { object },
            10..13 => Command::Attack { object, target: self.handle()? },
            13 => Command::AttackAt { object, x: self.number()?, y: self.number()? },
            14..16 => Command::AttackMove { object, x: self.number()?, y: self.number()? },
            16 => Command::Hold { object },
            17..20 => Command::Gather { object, patch: self.handle()? },
            20 => Command::ReturnLoad { object },
            21..24 => {
                let unit_type = self.unit_type()?;
                Command::Build { object, unit_type, x: self.number()?, y: self.number()? }
            }
            24..27 => Command::Train { object, unit_type: self.unit_type()? },
            27 => Command::Cancel { object },
            28..31 => Command::Switch { object },
            31.. => match self.byte()? {
                0 => Command::Resign,
                1.. => Command::Stop { object },
            },
        })
    }
}

/// A match that goes by bytes, and all that it must keep to.
pub(crate) struct Play {
    referee: Referee,
    views: Vec<View>,
    records: Vec<RecordedEvent>,
    acts: u32,
}

impl Play {
    pub(crate) fn new() -> Self {
        let mut referee = Referee::new(loaded(), ClockMode::Realtime).unwrap();
        referee.open_stands();
        let view = View::new(&referee.rules(), Arc::clone(referee.terrain()));
        for seat in (0..).map(Seat).take(referee.seats()) {
            referee.handle_join(seat, "fuzz").unwrap();
        }
        let views = vec![view; referee.seats()];
        let mut play = Self { referee, views, records: Vec::new(), acts: 0 };
        play.take();
        play
    }

    pub(crate) fn goes_on(&self) -> bool {
        self.acts < ACTS && self.referee.result().is_none() && self.referee.cycle() < Cycle(CYCLES)
    }

    /// Does what the next bytes say; `None` where there are no more.
    pub(crate) fn act(&mut self, bytes: &mut Bytes<'_>) -> Option<()> {
        self.acts += 1;
        let what = bytes.byte()?;
        if what % 8 == 0 {
            self.referee.step();
            self.take();
            return Some(());
        }
        let command = bytes.command()?;
        let seen = Cycle(self.referee.cycle().0.saturating_sub(u32::from(what / 64)));
        let list = vec![Sequenced { seq: self.acts, command }];
        self.referee.handle_commands(Seat(u16::from(what % 2)), seen, list).unwrap();
        Some(())
    }

    /// Takes what a step made; each client has the view of the server.
    fn take(&mut self) {
        self.records.append(&mut self.referee.take_records());
        for (seat, view) in (0..).map(Seat).zip(&mut self.views) {
            let delta = self.referee.take_delta(seat).unwrap();
            assert_eq!(view.apply(&delta), Ok(()));
            assert_eq!(view, self.referee.view(seat));
        }
        assert!(self.referee.stand(Vantage::Everything).is_ok());
    }

    /// Plays it again from its records, and goes on from a snapshot.
    pub(crate) fn check(mut self) {
        let mut again = Referee::new(loaded(), ClockMode::Realtime).unwrap();
        for record in &self.records {
            assert_eq!(again.handle_record(record), Ok(()));
        }
        // Commands that wait are not in a snapshot.
        if self.referee.result().is_none() {
            self.referee.step();
            self.take();
        }
        let snapshot = self.referee.snapshot();
        let mut resumed = Referee::resume(loaded(), ClockMode::Realtime, &snapshot).unwrap();
        assert_eq!(resumed.snapshot(), snapshot);
        if self.referee.result().is_none() {
            self.referee.step();
            resumed.step();
            self.take();
            assert_eq!(resumed.hash(), self.referee.hash());
            for seat in (0..).map(Seat).take(resumed.seats()) {
                assert_eq!(resumed.view(seat), self.referee.view(seat));
            }
        }
    }
}
