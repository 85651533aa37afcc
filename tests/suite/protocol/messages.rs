//! One message of each kind, with every field in use.

use glam::DVec2;
use maniple_geometry::Cycle;
use maniple_protocol::{
    ClientMessage, Create, Hello, Listed, ListedSeat, ListedSpectators, PROTOCOL, PackedDelta, Record,
    Refused, ReplayHeader, Rest, ServerMessage, Watch, Welcome,
};
use maniple_view::{
    Action, Alternate, Appeared, Base, Changed, ClockMode, Command, CommandResult, Delta, Digest, EndOfTask,
    EndReason, Ended, Falloff, Handle, Harvest, Identity, Layer, Making, MatchResult, Mode, Moved, Objective,
    Outcome, Own, Positions, Profile, Refusal, Rules, Scalar, Score, Seat, Sequenced, Shape, Shot, Solver,
    Splash, Status, StopReason, Stopped, Stops, Tally, Task, Terrain, TerrainKnowledge, UnitType, UnitTypeId,
    Vantage, Weapon, Zone,
};

pub(super) fn client_messages() -> Vec<(&'static str, ClientMessage)> {
    let hello = Hello {
        protocol: PROTOCOL,
        client: "example 1.0".to_owned(),
        player: "Ada".to_owned(),
        token: "00112233445566778899aabbccddeeff".to_owned(),
    };
    let create =
        Create { protocol: PROTOCOL, scenario: "duel".to_owned(), clock: ClockMode::Lockstep, open: true };
    vec![
        ("hello", ClientMessage::Hello(hello)),
        ("commands", ClientMessage::Commands { seen_cycle: Cycle(300), list: commands() }),
        ("done", ClientMessage::Done { cycle: Cycle(70_000) }),
        ("ping", ClientMessage::Ping { id: u32::MAX }),
        ("pause", ClientMessage::Pause { on: true }),
        ("watch_everything", ClientMessage::Watch(watch(Vantage::Everything))),
        ("watch_seat", ClientMessage::Watch(watch(Vantage::Seat(Seat(300))))),
        ("list", ClientMessage::List { protocol: PROTOCOL }),
        ("create", ClientMessage::Create(create)),
        ("enter", ClientMessage::Enter { match_id: Digest(1 << 60), seat: None }),
        ("enter_seat", ClientMessage::Enter { match_id: Digest(7), seat: Some(Seat(300)) }),
    ]
}

fn watch(view: Vantage) -> Watch {
    Watch { protocol: PROTOCOL, client: "example 1.0".to_owned(), view }
}

fn commands() -> Vec<Sequenced> {
    let object = Handle(7);
    let list = [
        Command::Move { object, x: 10.5, y: 20.0, s: None, queue: false, start: None },
        Command::Move {
            object,
            x: -0.0,
            y: 1e-7,
            s: Some(0.25),
            queue: true,
            start: Some((Cycle(301), 0.5)),
        },
        Command::Path { object, points: vec![(1.0, 2.0, None), (3.0, 4.0, Some(0.1))], start: None },
        Command::Stop { object: Handle(251) },
        Command::Resign,
        Command::Attack { object, target: Handle(70_000) },
        Command::AttackAt { object, x: 0.5, y: 64.0 },
        Command::AttackMove { object, x: 1.0 / 3.0, y: 2.0 },
        Command::Hold { object },
        Command::Gather { object, patch: Handle(0) },
        Command::ReturnLoad { object },
        Command::Build { object, unit_type: UnitTypeId(300), x: 10.0, y: 12.5 },
        Command::Train { object, unit_type: UnitTypeId(1) },
        Command::Cancel { object },
        Command::Switch { object },
    ];
    (1..).zip(list).map(|(seq, command)| Sequenced { seq, command }).collect()
}

pub(super) fn server_messages() -> Vec<(&'static str, ServerMessage)> {
    let refused = |reason| ServerMessage::Refused { reason };
    let malformed =
        Refused::Malformed { place: "message 3, column 13".to_owned(), problem: "expected value".to_owned() };
    vec![
        ("welcome", ServerMessage::Welcome(welcome())),
        ("welcome_everything", ServerMessage::Welcome(Welcome { seat: None, delay: Some(240), ..welcome() })),
        ("delta", ServerMessage::Delta(delta())),
        ("packed", ServerMessage::Packed(packed_delta())),
        ("packed_empty", ServerMessage::Packed(PackedDelta { cycle: Cycle(1), ..PackedDelta::default() })),
        ("delta_empty", ServerMessage::Delta(Delta { cycle: Cycle(1), ..Delta::default() })),
        ("pong", ServerMessage::Pong { id: 9, cycle: Cycle(65_535), fraction: 0.1 }),
        ("ended", ServerMessage::Ended { result: result() }),
        ("paused", ServerMessage::Paused { seats: vec![Seat(0), Seat(300)], on: true }),
        ("keyframe", ServerMessage::Keyframe {}),
        ("warned", ServerMessage::Warned { reason: Refused::TooLarge { limit: 16_384 }, left: 2 }),
        ("refused_protocol", refused(Refused::Protocol { supported: 1 })),
        ("refused_handshake", refused(Refused::Handshake)),
        ("refused_timeout", refused(Refused::Timeout { seconds: 10 })),
        ("refused_name_too_long", refused(Refused::NameTooLong { limit: 64 })),
        ("refused_token", refused(Refused::Token)),
        ("refused_full", refused(Refused::Full)),
        ("refused_replaced", refused(Refused::Replaced)),
        ("refused_malformed", refused(malformed)),
        ("refused_too_large", refused(Refused::TooLarge { limit: 16_384 })),
        ("refused_too_slow", refused(Refused::TooSlow)),
        ("refused_shutdown", refused(Refused::Shutdown)),
        ("refused_no_spectators", refused(Refused::NoSpectators)),
        ("refused_seats_only", refused(Refused::SeatsOnly)),
        ("refused_no_such_seat", refused(Refused::NoSuchSeat { seats: 2 })),
        ("refused_spectators_full", refused(Refused::SpectatorsFull { limit: 64 })),
        ("refused_spectator", refused(Refused::Spectator)),
        ("refused_held_too_much", refused(Refused::HeldTooMuch)),
        ("refused_broken", refused(Refused::Broken)),
        ("refused_no_match", refused(Refused::NoMatch)),
        ("refused_no_scenario", refused(Refused::NoScenario)),
        ("refused_matches_full", refused(Refused::MatchesFull { limit: 1024 })),
        ("refused_address_full", refused(Refused::AddressFull { limit: 8 })),
        ("refused_draining", refused(Refused::Draining)),
        ("refused_not_begun", refused(Refused::NotBegun { seconds: 600 })),
        ("refused_asks_too_much", refused(Refused::AsksTooMuch { limit: 16 })),
        ("matches", matches()),
        ("created", ServerMessage::Created { match_id: Digest(7), tokens: vec!["0".repeat(32)] }),
        ("refused_operator", refused(Refused::Operator)),
        ("refused_too_many_commands", refused(Refused::TooManyCommands { limit: 32_768 })),
    ]
}

fn matches() -> ServerMessage {
    let listed = |spectators| Listed {
        match_id: Digest(0x0123_4567_89ab_cdef),
        scenario: "duel".to_owned(),
        clock: ClockMode::Lockstep,
        rate: 8.0,
        has_begun: true,
        seats: vec![ListedSeat { open: true, taken: false }, ListedSeat { open: false, taken: true }],
        spectators,
    };
    let spectators = Some(ListedSpectators { everything: true, delay: 300 });
    ServerMessage::Matches {
        scenarios: vec!["duel".to_owned()],
        list: vec![listed(None), listed(spectators)],
    }
}

fn welcome() -> Welcome {
    let zone = Zone { seat: Seat(0), min: DVec2::new(3.0, 0.0), max: DVec2::new(4.0, 2.0) };
    Welcome {
        match_id: Digest(0x0123_4567_89ab_cdef),
        seat: Some(Seat(0)),
        delay: None,
        seats: 1,
        cycle: Cycle(0),
        rate: 8.0,
        clock: ClockMode::Realtime,
        rules: Rules {
            scenario: "race".to_owned(),
            cycles_max: 1000,
            players: vec!["Ada".to_owned()],
            unit_types: vec![scout(), barracks()],
            stops: Stops::Both,
            skin: 1e-9,
            waypoints_max: 64,
            commands_a_cycle_max: 16_384,
            objective: Objective::Race { zones: vec![zone] },
            teams: vec![0],
            friendly_fire: true,
            objects_max: 4096,
            training_max: 5,
            fog: true,
            terrain: TerrainKnowledge::Explored,
            walls_block: true,
            identity: Identity::Persistent,
            positions: Positions::Exact,
        },
        terrain: Terrain {
            width: 4,
            height: 2,
            tiles: vec!["...?".to_owned(), ".1@.".to_owned()],
            segments: vec![(2.0, 1.0, 1.0, 2.0), (3.0, 1.0, 2.0, 1.0)],
        },
    }
}

/// A unit type with everything that one can have.
fn scout() -> UnitType {
    let weapon = Weapon {
        range: 4.0,
        range_min: 1.0,
        cooldown: 8,
        damage_min: 5,
        damage_max: 7,
        splash: Some(Splash { radius: 0.9375, falloff: Falloff::Linear }),
        targets: vec![Layer::Ground, Layer::Air],
    };
    UnitType {
        name: "scout".to_owned(),
        shape: Shape::Circle { radius: 0.4 },
        layer: Layer::Ground,
        speed: 0.25,
        sight: 6.0,
        hit_points: Some(60),
        armor: 1,
        weapon: Some(weapon.clone()),
        alternate: Some(Alternate {
            name: "siege".to_owned(),
            switch_cycles: 16,
            speed: 0.0,
            armor: 2,
            weapon: Some(weapon),
        }),
        harvest: Some(Harvest { load_max: 10, cycles_each: 4 }),
        patch_places: None,
        takes_loads: false,
        making: Making { cost: 50, cycles: 80, requires: vec![UnitTypeId(1)] },
        trains: vec![],
        builds: vec![UnitTypeId(1)],
    }
}

/// A building: a unit type with as little as one can have.
fn barracks() -> UnitType {
    UnitType {
        name: "barracks".to_owned(),
        shape: Shape::Rectangle { width: 4.0, height: 3.0 },
        layer: Layer::Air,
        speed: 0.0,
        sight: 8.0,
        hit_points: None,
        armor: 0,
        weapon: None,
        alternate: None,
        harvest: None,
        patch_places: Some(4),
        takes_loads: true,
        making: Making::default(),
        trains: vec![UnitTypeId(0)],
        builds: vec![],
    }
}

fn status() -> Status {
    Status { hit_points: Some(60), amount: Some(1000), mode: Mode::Switching, action: Action::Gather }
}

fn own() -> Own {
    Own {
        queued: 64,
        task: Task::Gather,
        load: 9,
        ready: Cycle(300),
        training: Some(UnitTypeId(1)),
        waiting: 2,
        due: Some(Cycle(380)),
    }
}

/// A packed delta with every field that can be in one; its motions are not to be read.
fn packed_delta() -> PackedDelta {
    let Delta {
        cycle,
        results,
        sight,
        revealed,
        walls,
        vanished,
        died,
        changed,
        shots,
        ended,
        stock,
        check,
        ..
    } = delta();
    let appeared = vec![
        (Handle(7), UnitTypeId(1), Some(Seat(1)), Status::default(), None),
        (Handle(8), UnitTypeId(0), None, status(), Some(own())),
    ];
    let rest =
        Rest { results, sight, revealed, walls, appeared, vanished, died, changed, shots, ended, stock };
    PackedDelta { cycle, rest: Some(Box::new(rest)), motions: vec![0, 127, 128, 255], check }
}

/// A delta with every shape that can be in one.
fn delta() -> Delta {
    let handles = |numbers: std::ops::Range<u32>| numbers.map(Handle);
    let base = Base {
        point: DVec2::new(1.5, -2.25),
        cycle: Cycle(299),
        fraction: 0.75,
        velocity: DVec2::new(0.1, -0.0),
    };
    let appeared = |object: u32, owner, own| Appeared {
        object: Handle(object),
        unit_type: UnitTypeId(0),
        owner,
        base,
        status: status(),
        own,
    };
    let reasons = [
        None,
        Some(StopReason::Arrived),
        Some(StopReason::Ordered),
        Some(StopReason::Object { other: Some(Handle(300)) }),
        Some(StopReason::Object { other: None }),
        Some(StopReason::Segment),
        Some(StopReason::Edge),
    ];
    let stopped = |(object, reason)| Stopped {
        object,
        point: DVec2::new(5e-324, 1.797_693_134_862_315_7e308),
        cycle: Cycle(300),
        fraction: 1.0 / 3.0,
        reason,
    };
    let ends = [
        EndOfTask::Done,
        EndOfTask::Blocked,
        EndOfTask::Lost,
        EndOfTask::Empty,
        EndOfTask::NoRoom,
        EndOfTask::NotAffordable,
        EndOfTask::Missing,
        EndOfTask::TooMany,
    ];
    Delta {
        cycle: Cycle(300),
        results: (1..).zip(outcomes()).map(|(seq, outcome)| CommandResult { seq, outcome }).collect(),
        sight: vec![(0, 1), (300, 70_000)],
        revealed: vec![(0, 0, ".".to_owned()), (255, 1, "@.1234".to_owned())],
        walls: vec![(1.0, 0.0, 0.0, 0.0), (0.5, 0.1, -0.0, 1.0 / 3.0)],
        appeared: vec![appeared(70_000, None, None), appeared(70_001, Some(Seat(1)), Some(own()))],
        moved: vec![Moved { object: Handle(3), base }],
        stopped: handles(10..17).zip(reasons).map(stopped).collect(),
        vanished: handles(20..23).collect(),
        died: handles(250..253).collect(),
        changed: vec![
            Changed { object: Handle(12), status: Some(Status::default()), own: None },
            Changed { object: Handle(13), status: None, own: Some(Own::default()) },
        ],
        shots: vec![
            Shot { object: Handle(12), target: Some(Handle(300)) },
            Shot { object: Handle(14), target: None },
        ],
        ended: ends.into_iter().map(|why| Ended { object: Handle(12), task: Task::Build, why }).collect(),
        stock: Some(600),
        check: Digest(u64::MAX - 1),
    }
}

fn outcomes() -> Vec<Outcome> {
    let refusals = [
        Refusal::UnknownHandle,
        Refusal::OutOfWorld { width: 64, height: 4096 },
        Refusal::BadNumber { field: "x".to_owned(), problem: "is not finite".to_owned() },
        Refusal::TooFast { max: 0.25 },
        Refusal::UnknownAction,
        Refusal::TooManyWaypoints { max: 64 },
        Refusal::EmptyPath,
        Refusal::TooManyCommands { max: 16_384 },
        Refusal::StartInPast { now: Cycle(299) },
        Refusal::Out,
        Refusal::UnknownTarget,
        Refusal::BadTarget,
        Refusal::Busy,
        Refusal::NotAffordable { cost: 600, stock: 599 },
        Refusal::Missing { unit_type: UnitTypeId(1) },
        Refusal::TrainingFull { max: 5 },
        Refusal::TooManyObjects { max: 4096 },
        Refusal::NothingToCancel,
        Refusal::BadPlace,
        Refusal::NothingToReturn,
    ];
    let applied = Outcome::Applied { cycle: Cycle(299), late: 2 };
    let refused = refusals.into_iter().map(|reason| Outcome::Refused { reason });
    std::iter::once(applied).chain(refused).collect()
}

pub(super) fn result() -> MatchResult {
    let score = |seat: u16, name: &str| Score {
        seat: Seat(seat),
        name: name.to_owned(),
        team: seat,
        points: 3,
        tally: Tally {
            units: 4,
            arrived: 3,
            arrival_sum: 1 << 33,
            gathered: 251,
            made: 5,
            units_destroyed: 6,
            buildings_destroyed: 7,
            units_lost: 8,
            buildings_lost: 9,
            last_building: Cycle(999),
        },
        resigned: seat == 1,
    };
    MatchResult {
        winners: vec![Seat(0)],
        reason: EndReason::Resigned,
        cycles: Cycle(1000),
        scores: vec![score(0, "Ada"), score(1, "Émile 漢")],
        hash: Digest(0xfedc_ba98_7654_3210),
    }
}

pub(super) fn replay() -> (ReplayHeader, Vec<Record>) {
    let header = ReplayHeader {
        protocol: PROTOCOL,
        build: "maniple 0.1.0".to_owned(),
        scenario_name: "race".to_owned(),
        files: vec![
            ("race.toml".to_owned(), b"map = \"a.map\"\n".to_vec()),
            ("a.map".to_owned(), b"..\n".to_vec()),
        ],
        scenario: "race.toml".to_owned(),
        map_override: None,
        seed: 42,
        cycles_max: 2400,
        rate: 8.0,
        profile: Profile {
            scalar: Scalar::F32,
            solver: Solver::Stepped { substeps: 4 },
            certify: false,
            skin: Some(0.01),
            positions: Positions::Grid { bits: 10 },
        },
        map_hash: Digest(0x0123_4567_89ab_cdef),
        seats: 2,
    };
    let (cycle, seat) = (Cycle(0), Seat(0));
    let records = vec![
        Record::Joined { cycle, seat, name: "Ada".to_owned() },
        Record::Cycle { cycle, hash: Digest(1) },
        Record::Commands { cycle, seat, seen_cycle: cycle, list: commands() },
        Record::Absent { cycle, seat: Seat(1) },
        Record::Cycle { cycle: Cycle(1), hash: Digest(u64::MAX) },
        Record::Ended { result: result() },
    ];
    (header, records)
}
