//! Speed against accuracy, as its users ask for it: played, recorded, verified, refused by name, explained.

use std::path::Path;

use maniple_protocol::{Encoding, Packer, ServerMessage, encode_server, read_replay};
use maniple_view::{Positions, Profile, Scalar, Seat, Solver};

use crate::commands::{ROOT, fails, file, folder, json, run};
use crate::matches::{Game, open, scouts};

/// Returns a scenario of two seats on the map of the shipped duel, with some tables of its own.
fn scenario(folder: &Path, tables: &str) -> String {
    let map = Path::new(ROOT).join("maps/choke.tmx").display().to_string();
    let seat = "{ bot = 'straight', groups = [{ unit = 'a', count = 8 }, { unit = 'b', count = 4 }] }";
    let text = format!(
        "name = 'traded'\nmap = '{map}'\nlength_seconds = 60\nseat = [{seat}, {seat}]\nobjective.kind = 'race'\n\
         unit.a = {{ radius = 0.3, speed = 3.1 }}\nunit.b = {{ radius = 0.45, speed = 2.3 }}\n{tables}\n"
    );
    file(folder, "traded.toml", &text)
}

fn text(bytes: Vec<u8>) -> String {
    String::from_utf8(bytes).expect("text")
}

#[test]
fn packed_deltas_take_fewer_bytes_and_on_a_grid_fewer_still() {
    let bytes = |tables: &str| {
        let mut game = Game::new(scouts(tables, &open(), &[8, 8]), &["random", "random"]);
        let (mut plain, mut sum, mut packer) = (0, 0, Packer::new(&game.referee.rules()));
        packer.pack(&game.referee.keyframe(Seat(0)));
        while game.step() {
            let delta = &game.players[0].delta;
            let length = |message| encode_server(Encoding::Binary, &message).expect("it is encoded").len();
            plain += length(ServerMessage::Delta(delta.clone()));
            sum += length(ServerMessage::Packed(packer.pack(delta)));
        }
        (plain, sum)
    };
    let (plain, exact) = bytes("");
    let grids = [8, 16].map(|bits| bytes(&format!("[view]\npositions = 'grid'\ngrid_bits = {bits}")).1);
    println!("bytes told to a seat: plain {plain}, packed {exact}, on a grid of 2^-8 and 2^-16 {grids:?}");
    assert!(2 * exact < plain && 10 * grids[0] < 9 * exact, "{plain} {exact} {grids:?}");
    assert!(grids[0] < grids[1] && grids[1] < exact, "{exact} {grids:?}");
}

#[test]
fn what_is_asked_for_is_played_recorded_and_verified() {
    let folder = folder("profile_recorded");
    let replay = folder.join("a.replay").display().to_string();
    let stepped = Solver::Stepped { substeps: 2 };
    let grid = Positions::Grid { bits: 6 };
    let exact = Profile::EXACT;
    let check = |flags: &str, rate: f64, profile: Profile| {
        let flags = flags.split(' ').filter(|flag| !flag.is_empty());
        let command = ["match", "--seed", "3", "--replay", &replay, "--json"];
        let arguments: Vec<&str> = command.into_iter().chain(flags).collect();
        let played = json(&arguments);
        let header = read_replay(&std::fs::read(&replay).expect("it is there")).expect("it is whole").header;
        assert_eq!((header.rate, header.profile), (rate, profile), "{arguments:?}");
        let verdict = json(&["replay", "verify", &replay, "--json"]);
        assert_eq!(verdict["verified"], true, "{arguments:?}");
        assert_eq!((&verdict["hash"], &verdict["cycles"]), (&played["hash"], &played["cycles"]));
        played["hash"].as_str().expect("a hash").to_owned()
    };
    let plain = check("", 8.0, exact);
    let mut others = vec![
        check("--scalar f32", 8.0, Profile { scalar: Scalar::F32, ..exact }),
        check("--solver stepped --substeps 2", 8.0, Profile { solver: stepped, ..exact }),
        check("--skin 0.01", 8.0, Profile { skin: Some(0.01), ..exact }),
        check("--rate 4", 4.0, exact),
        check(
            "--scalar f32 --solver stepped --substeps 2 --certify off --skin 0 --positions grid --grid-bits 6",
            8.0,
            Profile {
                scalar: Scalar::F32,
                solver: stepped,
                certify: false,
                skin: Some(0.0),
                positions: grid,
            },
        ),
        plain.clone(),
    ];
    others.sort();
    others.dedup();
    assert_eq!(others.len(), 6, "each is another match");
    assert_eq!(check("--scalar f64 --solver event --certify on --positions exact", 8.0, exact), plain);
}

#[test]
fn a_scenario_in_single_precision_is_played_to_its_end_and_the_command_line_says_otherwise() {
    let folder = folder("profile_single");
    let tables =
        "kinematics = { scalar = 'f32', certify = false }\nview = { positions = 'grid', grid_bits = 10 }";
    let scenario = scenario(&folder, tables);
    let replay = folder.join("a.replay").display().to_string();
    let single = run(&["match", &scenario, "--replay", &replay]);
    assert!(single.status.success());
    let models = "models: no fog (perfect information); 2 radii; 1 layer; 50 segments; rules: race; \
                  kinematics: traded (event, f32, not certified); positions: grid of 2^-10\n";
    assert_eq!(text(single.stderr), models);
    assert_eq!(json(&["replay", "verify", &replay, "--json"])["verified"], true);
    let flags = ["--scalar", "f64", "--certify", "on", "--positions", "exact"];
    let exact = run(&[&["match", &scenario], &flags[..]].concat());
    assert!(text(exact.stderr).contains("kinematics: exact (event, f64, certified); positions: exact"));
}

#[test]
fn each_value_that_cannot_be_is_refused_by_its_name() {
    let check = |flags: &[&str], expected: &[&str]| {
        for command in ["match", "serve"] {
            let error = fails(&[&[command], flags].concat(), 2);
            for expected in expected {
                assert!(error.contains(expected), "{flags:?}: {error} lacks {expected}");
            }
        }
    };
    check(&["--scalar", "f16"], &["--scalar", "f64, f32"]);
    check(&["--solver", "stepper"], &["--solver", "event, stepped"]);
    check(&["--substeps", "4"], &["--solver"]);
    check(&["--solver", "stepped"], &["--solver stepped needs --substeps, at most 1000; add it"]);
    check(&["--solver", "event", "--substeps", "4"], &["--substeps means nothing without --solver stepped"]);
    check(&["--solver", "stepped", "--substeps", "0"], &["--substeps", "1..=1000"]);
    check(&["--certify", "maybe"], &["--certify", "on, off"]);
    check(&["--skin", "1.5"], &["--skin", "1.5 is not in 0 to 1"]);
    check(&["--skin=-1"], &["--skin", "-1 is not in 0 to 1"]);
    check(&["--skin", "NaN"], &["--skin", "NaN is not in 0 to 1"]);
    check(&["--rate", "0"], &["--rate", "0 is not in 0.0009765625 to 1000"]);
    check(&["--positions", "grid"], &["--positions grid needs --grid-bits"]);
    check(&["--positions", "grid", "--grid-bits", "21"], &["--grid-bits", "20"]);
    let folder = folder("profile_refused");
    let error = fails(&["match", &scenario(&folder, "kinematics = { solver = 'stepped' }")], 3);
    assert!(
        error.contains("traded.toml:8:25: solver = \"stepped\" needs substeps, from 1 to 1000"),
        "{error}"
    );
}

#[test]
fn what_is_not_modelled_costs_nothing_and_explain_says_so() {
    let folder = folder("profile_explain");
    for (tables, vision, is_free) in
        [("", "no fog (perfect information)", true), ("vision = {}", "fog (circles of sight", false)]
    {
        let scenario = scenario(&folder, tables);
        let output = run(&["match", &scenario, "--explain"]);
        assert!(text(output.stderr).contains(&format!("models: {vision}")));
        let table = text(output.stdout);
        let row = |name: &str| table.lines().find(|line| line.starts_with(name)).expect(name).to_owned();
        assert!(row("vision").contains(vision), "{table}");
        assert_eq!(row("vision").ends_with(" 0   0.0 %"), is_free, "{table}");
        for name in ["bots", "commands", "  graph", "  queue", "rules", "sightings", "views", "all"] {
            assert!(row(name).ends_with('%') && !row(name).ends_with(" 0   0.0 %"), "{table}");
        }
        assert!(row("kinematics").contains("exact (event, f64, certified)"), "{table}");
        assert!(row("  radii").ends_with("2 radii") && row("  walls").ends_with("50 segments"), "{table}");
    }
    fails(&["match", "--explain", "--json"], 2);
}
