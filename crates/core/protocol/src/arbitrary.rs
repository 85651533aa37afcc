//! Random values for the tests of this crate.

use glam::DVec2;
use maniple_geometry::Cycle;
use maniple_view::{
    Action, Alternate, Appeared, Base, Changed, ClockMode, Command, CommandResult, Delta, Digest, EndOfTask,
    EndReason, Ended, Falloff, Handle, Harvest, Identity, Layer, Making, MatchResult, Mode, Moved, Objective,
    Outcome, Own, Positions, Refusal, Rules, Score, Seat, Sequenced, Shape, Shot, Splash, Status, StopReason,
    Stopped, Stops, Tally, Task, Terrain, TerrainKnowledge, UnitType, UnitTypeId, Vantage, Weapon, Zone,
};

use crate::message::{
    ClientMessage, Create, Hello, Listed, ListedSeat, ListedSpectators, ServerMessage, Watch, Welcome,
};
use crate::packed::{PackedDelta, Rest};
use crate::refused::Refused;

/// A stream of numbers from a seed: SplitMix64 (Steele, Lea and Flood 2014).
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub(crate) fn number(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// Returns a number in `0..end`.
    pub(crate) fn below(&mut self, end: usize) -> usize {
        usize::try_from(self.number() % u64::try_from(end).unwrap()).unwrap()
    }

    pub(crate) fn coin(&mut self) -> bool {
        self.below(2) == 0
    }

    /// Returns a number of any size, small ones as often as large ones.
    pub(crate) fn sized(&mut self) -> u64 {
        let shift = self.below(64);
        self.number() >> shift
    }

    pub(crate) fn u32(&mut self) -> u32 {
        u32::try_from(self.sized() & 0xffff_ffff).unwrap()
    }

    pub(crate) fn u16(&mut self) -> u16 {
        u16::try_from(self.sized() & 0xffff).unwrap()
    }

    /// Returns any finite double: each bit pattern, with a taste for the extreme ones.
    pub(crate) fn double(&mut self) -> f64 {
        const EXTREME: [f64; 10] = [
            0.0,
            -0.0,
            f64::MAX,
            f64::MIN,
            f64::MIN_POSITIVE,
            f64::EPSILON,
            5e-324,
            0.1,
            9_007_199_254_740_993.0,
            -1e308,
        ];
        if self.below(4) == 0 {
            return EXTREME[self.below(EXTREME.len())];
        }
        let double = f64::from_bits(self.number());
        if double.is_finite() { double } else { 0.5 }
    }

    pub(crate) fn text(&mut self) -> String {
        const CHARACTERS: [char; 10] = ['a', 'Z', ' ', '"', '\\', '\n', '\0', 'é', '漢', '🌍'];
        (0..self.below(12)).map(|_| CHARACTERS[self.below(CHARACTERS.len())]).collect()
    }

    /// Returns fewer than `end` random bytes.
    pub(crate) fn bytes(&mut self, end: usize) -> Vec<u8> {
        (0..self.below(end)).map(|_| self.number().to_le_bytes()[0]).collect()
    }

    /// Returns the bytes in pieces of random length, some of them empty.
    pub(crate) fn split<'a>(&mut self, mut bytes: &'a [u8]) -> Vec<&'a [u8]> {
        let mut pieces = Vec::new();
        while !bytes.is_empty() {
            let (piece, rest) = bytes.split_at(self.below(bytes.len() + 1));
            pieces.push(piece);
            bytes = rest;
        }
        pieces
    }

    pub(crate) fn list<T>(&mut self, mut item: impl FnMut(&mut Self) -> T) -> Vec<T> {
        (0..self.below(4)).map(|_| item(self)).collect()
    }

    pub(crate) fn maybe<T>(&mut self, item: impl FnOnce(&mut Self) -> T) -> Option<T> {
        if self.coin() { Some(item(self)) } else { None }
    }

    pub(crate) fn client_message(&mut self) -> ClientMessage {
        match self.below(9) {
            6 => ClientMessage::List { protocol: self.u32() },
            7 => ClientMessage::Create(Create {
                protocol: self.u32(),
                scenario: self.text(),
                clock: self.clock(),
                open: self.coin(),
            }),
            8 => ClientMessage::Enter { match_id: Digest(self.number()), seat: self.maybe(Self::seat) },
            0 => ClientMessage::Hello(Hello {
                protocol: self.u32(),
                client: self.text(),
                player: self.text(),
                token: self.text(),
            }),
            1 => ClientMessage::Commands { seen_cycle: self.cycle(), list: self.list(Self::sequenced) },
            2 => ClientMessage::Done { cycle: self.cycle() },
            3 => ClientMessage::Pause { on: self.coin() },
            4 => {
                let (protocol, client) = (self.u32(), self.text());
                let view = self.maybe(Self::seat).map_or(Vantage::Everything, Vantage::Seat);
                ClientMessage::Watch(Watch { protocol, client, view })
            }
            _ => ClientMessage::Ping { id: self.u32() },
        }
    }

    pub(crate) fn server_message(&mut self) -> ServerMessage {
        match self.below(11) {
            7 => ServerMessage::Matches { scenarios: self.list(Self::text), list: self.list(Self::listed) },
            8 => ServerMessage::Created { match_id: Digest(self.number()), tokens: self.list(Self::text) },
            0 => ServerMessage::Welcome(self.welcome()),
            1 => ServerMessage::Refused { reason: self.refused() },
            2 => ServerMessage::Delta(self.delta()),
            3 => ServerMessage::Pong { id: self.u32(), cycle: self.cycle(), fraction: self.double() },
            4 => ServerMessage::Packed(self.packed_delta()),
            5 => ServerMessage::Paused { seats: self.list(Self::seat), on: self.coin() },
            9 => ServerMessage::Keyframe {},
            6 => ServerMessage::Warned { reason: self.refused(), left: self.u32() },
            _ => ServerMessage::Ended { result: self.result() },
        }
    }

    pub(crate) fn sequenced(&mut self) -> Sequenced {
        Sequenced { seq: self.u32(), command: self.command() }
    }

    pub(crate) fn result(&mut self) -> MatchResult {
        MatchResult {
            winners: self.list(Self::seat),
            reason: [EndReason::Objective, EndReason::Length, EndReason::Resigned][self.below(3)],
            cycles: self.cycle(),
            scores: self.list(Self::score),
            hash: Digest(self.sized()),
        }
    }

    pub(crate) fn seat(&mut self) -> Seat {
        Seat(self.u16())
    }

    pub(crate) fn cycle(&mut self) -> Cycle {
        Cycle(self.u32())
    }

    fn handle(&mut self) -> Handle {
        Handle(self.u32())
    }

    fn point(&mut self) -> DVec2 {
        DVec2::new(self.double(), self.double())
    }

    fn command(&mut self) -> Command {
        let start = |random: &mut Self| (random.cycle(), random.double());
        let object = self.handle();
        match self.below(14) {
            3 => Command::Attack { object, target: self.handle() },
            4 => Command::AttackAt { object, x: self.double(), y: self.double() },
            5 => Command::AttackMove { object, x: self.double(), y: self.double() },
            6 => Command::Hold { object },
            7 => Command::Gather { object, patch: self.handle() },
            8 => Command::ReturnLoad { object },
            9 => {
                Command::Build { object, unit_type: self.unit_type_id(), x: self.double(), y: self.double() }
            }
            10 => Command::Train { object, unit_type: self.unit_type_id() },
            11 => Command::Cancel { object },
            12 => Command::Switch { object },
            0 => Command::Move {
                object,
                x: self.double(),
                y: self.double(),
                s: self.maybe(Self::double),
                queue: self.coin(),
                start: self.maybe(start),
            },
            1 => Command::Path {
                object,
                points: self.list(|random| (random.double(), random.double(), random.maybe(Self::double))),
                start: self.maybe(start),
            },
            2 => Command::Stop { object },
            _ => Command::Resign,
        }
    }

    fn refused(&mut self) -> Refused {
        match self.below(27) {
            17 => Refused::Broken,
            18 => Refused::NoMatch,
            19 => Refused::NoScenario,
            20 => Refused::MatchesFull { limit: self.u32() },
            21 => Refused::AddressFull { limit: self.u32() },
            22 => Refused::Draining,
            23 => Refused::NotBegun { seconds: self.u32() },
            25 => Refused::Operator,
            24 => Refused::AsksTooMuch { limit: self.u32() },
            0 => Refused::Protocol { supported: self.u32() },
            1 => Refused::Handshake,
            2 => Refused::Timeout { seconds: self.u32() },
            3 => Refused::NameTooLong { limit: self.u32() },
            4 => Refused::Token,
            5 => Refused::Full,
            6 => Refused::Replaced,
            7 => Refused::Malformed { place: self.text(), problem: self.text() },
            8 => Refused::TooLarge { limit: self.u32() },
            9 => Refused::TooSlow,
            10 => Refused::NoSpectators,
            11 => Refused::SeatsOnly,
            12 => Refused::NoSuchSeat { seats: self.u16() },
            13 => Refused::SpectatorsFull { limit: self.u32() },
            14 => Refused::Spectator,
            15 => Refused::HeldTooMuch,
            26 => Refused::TooManyCommands { limit: self.u32() },
            _ => Refused::Shutdown,
        }
    }

    fn clock(&mut self) -> ClockMode {
        if self.coin() { ClockMode::Realtime } else { ClockMode::Lockstep }
    }

    fn listed(&mut self) -> Listed {
        let seat = |random: &mut Self| ListedSeat { open: random.coin(), taken: random.coin() };
        let spectators =
            |random: &mut Self| ListedSpectators { everything: random.coin(), delay: random.u32() };
        Listed {
            match_id: Digest(self.number()),
            scenario: self.text(),
            clock: self.clock(),
            rate: self.double(),
            has_begun: self.coin(),
            seats: self.list(seat),
            spectators: self.maybe(spectators),
        }
    }

    pub(crate) fn welcome(&mut self) -> Welcome {
        Welcome {
            match_id: Digest(self.number()),
            seat: self.maybe(Self::seat),
            delay: self.maybe(Self::u32),
            seats: self.u16(),
            cycle: self.cycle(),
            rate: self.double(),
            clock: self.clock(),
            rules: Rules {
                scenario: self.text(),
                cycles_max: self.u32(),
                players: self.list(Self::text),
                unit_types: self.list(Self::unit_type),
                stops: if self.coin() { Stops::Both } else { Stops::Approaching },
                skin: self.double(),
                waypoints_max: self.u32(),
                commands_a_cycle_max: self.u32(),
                objective: self.objective(),
                teams: self.list(Self::u16),
                friendly_fire: self.coin(),
                objects_max: self.u32(),
                training_max: self.u32(),
                fog: self.coin(),
                terrain: if self.coin() { TerrainKnowledge::Known } else { TerrainKnowledge::Explored },
                walls_block: self.coin(),
                identity: if self.coin() { Identity::Fresh } else { Identity::Persistent },
                positions: if self.coin() { Positions::Exact } else { Positions::Grid { bits: 9 } },
            },
            terrain: Terrain {
                width: self.u32(),
                height: self.u32(),
                tiles: self.list(Self::text),
                segments: self
                    .list(|random| (random.double(), random.double(), random.double(), random.double())),
            },
        }
    }

    fn objective(&mut self) -> Objective {
        match self.below(6) {
            0 => Objective::Race {
                zones: self.list(|random| Zone {
                    seat: random.seat(),
                    min: random.point(),
                    max: random.point(),
                }),
            },
            1 => Objective::Resources { goal: self.maybe(Self::u32) },
            2 => Objective::Kills,
            3 => Objective::Buildings,
            4 => Objective::LastStanding,
            _ => Objective::Survive { team: self.u16() },
        }
    }

    fn unit_type_id(&mut self) -> UnitTypeId {
        UnitTypeId(self.u16())
    }

    pub(crate) fn unit_type(&mut self) -> UnitType {
        UnitType {
            name: self.text(),
            shape: if self.coin() {
                Shape::Circle { radius: self.double() }
            } else {
                Shape::Rectangle { width: self.double(), height: self.double() }
            },
            layer: self.layer(),
            speed: self.double(),
            sight: self.double(),
            hit_points: self.maybe(Self::u32),
            armor: self.u32(),
            weapon: self.maybe(Self::weapon),
            alternate: self.maybe(|random| Alternate {
                name: random.text(),
                switch_cycles: random.u32(),
                speed: random.double(),
                armor: random.u32(),
                weapon: random.maybe(Self::weapon),
            }),
            harvest: self.maybe(|random| Harvest { load_max: random.u32(), cycles_each: random.u32() }),
            patch_places: self.maybe(Self::u32),
            takes_loads: self.coin(),
            making: Making { cost: self.u32(), cycles: self.u32(), requires: self.list(Self::unit_type_id) },
            trains: self.list(Self::unit_type_id),
            builds: self.list(Self::unit_type_id),
        }
    }

    fn layer(&mut self) -> Layer {
        if self.coin() { Layer::Ground } else { Layer::Air }
    }

    fn weapon(&mut self) -> Weapon {
        Weapon {
            range: self.double(),
            range_min: self.double(),
            cooldown: self.u32(),
            damage_min: self.u32(),
            damage_max: self.u32(),
            splash: self.maybe(|random| Splash {
                radius: random.double(),
                falloff: if random.coin() { Falloff::None } else { Falloff::Linear },
            }),
            targets: self.list(Self::layer),
        }
    }

    pub(crate) fn status(&mut self) -> Status {
        const MODES: [Mode; 5] =
            [Mode::Normal, Mode::Switching, Mode::Alternate, Mode::SwitchingBack, Mode::Site];
        Status {
            hit_points: self.maybe(Self::u32),
            amount: self.maybe(Self::u32),
            mode: MODES[self.below(MODES.len())],
            action: [Action::None, Action::Gather, Action::Build][self.below(3)],
        }
    }

    fn own(&mut self) -> Own {
        Own {
            queued: self.u32(),
            task: self.task(),
            load: self.u32(),
            ready: self.cycle(),
            training: self.maybe(Self::unit_type_id),
            waiting: self.u32(),
            due: self.maybe(Self::cycle),
        }
    }

    fn task(&mut self) -> Task {
        const TASKS: [Task; 8] = [
            Task::None,
            Task::Attack,
            Task::AttackAt,
            Task::AttackMove,
            Task::Hold,
            Task::Gather,
            Task::ReturnLoad,
            Task::Build,
        ];
        TASKS[self.below(TASKS.len())]
    }

    fn end_of_task(&mut self) -> EndOfTask {
        const ENDS: [EndOfTask; 8] = [
            EndOfTask::Done,
            EndOfTask::Blocked,
            EndOfTask::Lost,
            EndOfTask::Empty,
            EndOfTask::NoRoom,
            EndOfTask::NotAffordable,
            EndOfTask::Missing,
            EndOfTask::TooMany,
        ];
        ENDS[self.below(ENDS.len())]
    }

    fn shot(&mut self) -> Shot {
        Shot { object: self.handle(), target: self.maybe(Self::handle) }
    }

    fn ended(&mut self) -> Ended {
        Ended { object: self.handle(), task: self.task(), why: self.end_of_task() }
    }

    fn packed_delta(&mut self) -> PackedDelta {
        let rest = |random: &mut Self| {
            let appeared = |random: &mut Self| {
                (
                    random.handle(),
                    UnitTypeId(random.u16()),
                    random.maybe(Self::seat),
                    random.status(),
                    random.maybe(Self::own),
                )
            };
            let Delta { results, sight, revealed, walls, vanished, changed, stock, .. } = random.delta();
            let appeared = random.list(appeared);
            Box::new(Rest {
                results,
                sight,
                revealed,
                walls,
                appeared,
                vanished,
                changed,
                stock,
                ..Rest::default()
            })
        };
        PackedDelta {
            cycle: self.cycle(),
            rest: self.maybe(rest),
            motions: self.bytes(40),
            check: Digest(self.number()),
        }
    }

    pub(crate) fn delta(&mut self) -> Delta {
        Delta {
            cycle: self.cycle(),
            results: self.list(|random| CommandResult { seq: random.u32(), outcome: random.outcome() }),
            sight: self.list(|random| (random.u32(), random.u32())),
            revealed: self.list(|random| (random.u32(), random.u32(), random.text())),
            walls: self.list(|random| (random.double(), random.double(), random.double(), random.double())),
            appeared: self.list(|random| Appeared {
                object: random.handle(),
                unit_type: UnitTypeId(random.u16()),
                owner: random.maybe(Self::seat),
                base: random.base(),
                status: random.status(),
                own: random.maybe(Self::own),
            }),
            moved: self.list(|random| Moved { object: random.handle(), base: random.base() }),
            stopped: self.list(|random| Stopped {
                object: random.handle(),
                point: random.point(),
                cycle: random.cycle(),
                fraction: random.double(),
                reason: random.maybe(Self::stop_reason),
            }),
            vanished: self.list(Self::handle),
            died: self.list(Self::handle),
            changed: self.list(|random| Changed {
                object: random.handle(),
                status: random.maybe(Self::status),
                own: random.maybe(Self::own),
            }),
            shots: self.list(Self::shot),
            ended: self.list(Self::ended),
            stock: self.maybe(Self::u32),
            check: Digest(self.sized()),
        }
    }

    fn base(&mut self) -> Base {
        Base { point: self.point(), cycle: self.cycle(), fraction: self.double(), velocity: self.point() }
    }

    pub(crate) fn stop_reason(&mut self) -> StopReason {
        match self.below(5) {
            0 => StopReason::Arrived,
            1 => StopReason::Ordered,
            2 => StopReason::Object { other: self.maybe(Self::handle) },
            3 => StopReason::Segment,
            _ => StopReason::Edge,
        }
    }

    fn outcome(&mut self) -> Outcome {
        if self.coin() {
            return Outcome::Applied { cycle: self.cycle(), late: self.u32() };
        }
        let reason = match self.below(20) {
            10 => Refusal::UnknownTarget,
            11 => Refusal::BadTarget,
            12 => Refusal::Busy,
            13 => Refusal::NotAffordable { cost: self.u32(), stock: self.u32() },
            14 => Refusal::Missing { unit_type: self.unit_type_id() },
            15 => Refusal::TrainingFull { max: self.u32() },
            16 => Refusal::TooManyObjects { max: self.u32() },
            17 => Refusal::NothingToCancel,
            18 => Refusal::BadPlace,
            19 => Refusal::NothingToReturn,
            0 => Refusal::UnknownHandle,
            1 => Refusal::OutOfWorld { width: self.u32(), height: self.u32() },
            2 => Refusal::BadNumber { field: self.text(), problem: self.text() },
            3 => Refusal::TooFast { max: self.double() },
            4 => Refusal::UnknownAction,
            5 => Refusal::TooManyWaypoints { max: self.u32() },
            6 => Refusal::EmptyPath,
            7 => Refusal::TooManyCommands { max: self.u32() },
            8 => Refusal::StartInPast { now: self.cycle() },
            _ => Refusal::Out,
        };
        Outcome::Refused { reason }
    }

    fn score(&mut self) -> Score {
        Score {
            seat: self.seat(),
            name: self.text(),
            team: self.u16(),
            points: self.sized(),
            tally: Tally {
                units: self.u32(),
                arrived: self.u32(),
                arrival_sum: self.sized(),
                gathered: self.sized(),
                made: self.u32(),
                units_destroyed: self.u32(),
                buildings_destroyed: self.u32(),
                units_lost: self.u32(),
                buildings_lost: self.u32(),
                last_building: self.cycle(),
            },
            resigned: self.coin(),
        }
    }
}
