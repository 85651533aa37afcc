//! `maniple bench`: rows that can be read, and bits that do not depend on threads.

use serde_json::Value;

use crate::commands::{ROOT, fails, file, folder, json, run};

/// The fields of a row of `bench scale` without a map.
const FIELDS: [&str; 15] = [
    "objects",
    "density",
    "threads",
    "ns_per_object_cycle",
    "cycles_per_second",
    "pairs_tested",
    "components",
    "largest_component",
    "collisions",
    "overlaps_found",
    "bytes_per_object",
    "hash",
    "walls",
    "resting",
    "parts",
];

fn scale(arguments: &[&str]) -> Vec<Value> {
    let rows = json(&[&["bench", "scale", "--cycles", "5", "--json"], arguments].concat());
    rows.as_array().expect("an array of rows").clone()
}

#[test]
fn bench_scale_has_a_row_for_each_number_density_and_thread_count() {
    let rows = scale(&["--objects", "50,5000", "--density", "0.05,0.4", "--threads", "1,2"]);
    let key =
        |row: &Value| (row["density"].to_string(), row["objects"].to_string(), row["threads"].to_string());
    let keys: Vec<_> = rows.iter().map(key).collect();
    let expected = ["0.05", "0.4"].iter().flat_map(|density| {
        ["50", "5000"].iter().flat_map(move |objects| {
            ["1", "2"].iter().map(move |threads| [density, objects, threads].map(|text| (*text).to_owned()))
        })
    });
    assert_eq!(keys, expected.map(<(String, String, String)>::from).collect::<Vec<_>>());
    for row in &rows {
        let fields: Vec<&String> = row.as_object().expect("a row").keys().collect();
        assert_eq!(fields.len(), FIELDS.len(), "{fields:?}");
        assert!(FIELDS.iter().all(|field| row.get(field).is_some()), "{fields:?}");
        assert_eq!((&row["overlaps_found"], &row["walls"]), (&0.into(), &4.into()), "{row}");
        assert!(row["ns_per_object_cycle"].as_f64().is_some_and(|time| time > 0.0), "{row}");
        assert!(row["hash"].as_str().is_some_and(|hash| hash.len() == 16), "{row}");
    }
    for threads in rows.chunks(2) {
        for field in ["hash", "pairs_tested", "components", "largest_component", "collisions"] {
            assert_eq!(threads[0][field], threads[1][field], "{field} with other threads");
        }
    }
}

#[test]
fn a_seed_decides_the_march() {
    let hash = |seed: &str| {
        scale(&["--objects", "200", "--density", "0.25", "--threads", "1", "--seed", seed])[0]["hash"].clone()
    };
    assert_eq!(hash("3"), hash("3"));
    assert_ne!(hash("3"), hash("4"));
}

#[test]
fn on_a_map_as_many_march_as_fit_and_once_more_without_walls() {
    let map = "maps/diamond.tmx";
    let rows = scale(&["--map", map, "--objects", "100,5000,9000", "--density", "0.25", "--threads", "1"]);
    let info = json(&["map", "info", map, "--json"]);
    let passable = info["passable_tiles"].as_f64().expect("a number");
    let most = (passable * 0.25 / (std::f64::consts::PI * 0.4 * 0.4)).floor();
    let found: Vec<_> = rows.iter().map(|row| (row["objects"].as_f64(), row["walls"].as_u64())).collect();
    let (walls, most) = (info["segments"].as_u64(), Some(most));
    assert_eq!(found, [(Some(100.0), walls), (Some(100.0), Some(0)), (most, walls), (most, Some(0))]);
    assert!(rows.iter().all(|row| row["map"] == map && row["overlaps_found"] == 0));
}

#[test]
fn those_at_rest_change_nothing_about_what_a_cycle_has_to_do() {
    let work = |resting: &str| {
        let rows = scale(&["--objects", "300", "--density", "0.25", "--threads", "1", "--resting", resting]);
        assert_eq!(rows[0]["resting"].to_string(), resting);
        ["pairs_tested", "components", "collisions"].map(|field| rows[0][field].clone())
    };
    assert_eq!(work("0"), work("2000"));
}

#[test]
fn what_nobody_meets_is_timed_beside_the_same_march_without_it() {
    let rows = json(&["bench", "absent", "--objects", "50", "--cycles", "3", "--json"]);
    let rows = rows.as_array().expect("an array of rows");
    let parts: Vec<&str> = rows.iter().map(|row| row["part"].as_str().expect("a name")).collect();
    assert_eq!(parts, ["nothing", "walls", "resting", "layers", "radius", "alarm"]);
    for row in rows {
        assert_eq!(row["objects"], 50);
        for field in ["ns_per_object_cycle", "ns_with", "ratio"] {
            assert!(row[field].as_f64().is_some_and(|figure| figure > 0.0), "{row}");
        }
    }
    let error = fails(&["bench", "absent", "--objects", "0"], 2);
    assert!(error.contains("--objects") && error.contains("1..=4000000"), "{error}");
    let error = fails(&["bench", "absent", "--density", "0.9"], 2);
    assert!(error.contains("0.01 to 0.4"), "{error}");
}

#[test]
fn bench_scale_prints_a_line_for_each_row_as_text() {
    let output = run(&["bench", "scale", "--objects", "20", "--density", "0.05", "--cycles", "3"]);
    let text = String::from_utf8(output.stdout).expect("text");
    assert!(output.status.success(), "{text}");
    assert_eq!(text.lines().count(), 2 + 2, "{text}");
    assert!(text.contains("ns/object"), "{text}");
}

#[test]
fn what_bench_scale_cannot_do_is_a_usage_error_that_names_argument_and_limit() {
    let check = |arguments: &[&str], named: &[&str]| {
        let error = fails(&[&["bench", "scale"], arguments].concat(), 2);
        assert!(named.iter().all(|name| error.contains(name)), "{error} does not name {named:?}");
    };
    check(&["--objects", "0"], &["--objects", "1..=4000000"]);
    check(&["--objects", "10,4000001"], &["--objects", "4000001", "1..=4000000"]);
    check(&["--density", "0.5"], &["--density", "0.5", "0.01 to 0.4"]);
    check(&["--density", "0.05,NaN"], &["--density", "NaN", "0.01 to 0.4"]);
    check(&["--threads", "257"], &["--threads", "1..=256"]);
    check(&["--resting", "4000001"], &["--resting", "0..=4000000"]);
    check(&["--objects", "2", "--density", "0.4"], &["--objects 2", "--density 0.4", "lower density"]);
    check(&["--cycles", "0"], &["--cycles", "1..=1000000"]);
    fails(&["bench", "scale", "--map", "no/such.map"], 3);
}

#[test]
fn sectors_find_the_pairs_of_all_spheres_with_far_fewer_tests() {
    let rows = json(&["bench", "broad", "--objects", "50,2000", "--json"]);
    let rows = rows.as_array().expect("an array of rows");
    let number = |row: &Value, field: &str| row[field].as_u64().unwrap_or_else(|| panic!("{field} of {row}"));
    let methods: Vec<_> = rows.iter().map(|row| (number(row, "objects"), row["method"].as_str())).collect();
    let expected = [50, 2000].into_iter().flat_map(|objects| {
        ["all_pairs", "boxes", "spheres", "sectors"].map(|method| (objects, Some(method)))
    });
    assert_eq!(methods, expected.collect::<Vec<_>>());
    for of_a_count in rows.chunks(4) {
        let objects = number(&of_a_count[0], "objects");
        for row in of_a_count {
            assert_eq!(row.as_object().map(serde_json::Map::len), Some(5), "{row}");
            assert!(row["ns_per_object"].as_f64().is_some_and(|time| time > 0.0), "{row}");
        }
        let [contacts, boxes, spheres, sectors] =
            [0, 1, 2, 3].map(|place| number(&of_a_count[place], "pairs_found"));
        assert!(0 < contacts && contacts <= boxes && contacts <= spheres, "{of_a_count:?}");
        // Spheres are rounded outwards before they get into sectors.
        assert!(spheres <= sectors && sectors <= spheres + spheres / 1000 + 1, "{of_a_count:?}");
        for row in &of_a_count[..3] {
            assert_eq!(number(row, "pairs_tested"), objects * (objects - 1) / 2, "{row}");
        }
    }
    let tested = |place: usize| number(&rows[place], "pairs_tested");
    assert!(tested(7) * 20 < tested(6), "{rows:?}");
}

#[test]
fn methods_that_test_every_pair_are_left_out_above_their_limit_and_said_so() {
    let output = run(&["bench", "broad", "--objects", "100,10001", "--density", "0.05"]);
    let (text, said) =
        [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).expect("text")).into();
    assert!(output.status.success(), "{said}");
    assert_eq!(text.lines().count(), 2 + 4 + 1, "{text}");
    assert!(
        text.lines().last().is_some_and(|line| line.contains("sectors") && line.contains("10,001")),
        "{text}"
    );
    for named in ["all_pairs, boxes, spheres", "10,001", "10,000"] {
        assert!(said.contains(named), "{said} does not name {named}");
    }
}

#[test]
fn what_bench_broad_cannot_do_is_a_usage_error_that_names_argument_and_limit() {
    let check = |arguments: &[&str], named: &[&str]| {
        let error = fails(&[&["bench", "broad"], arguments].concat(), 2);
        assert!(named.iter().all(|name| error.contains(name)), "{error} does not name {named:?}");
    };
    check(&["--objects", "0"], &["--objects", "1..=4000000"]);
    check(&["--objects", "10,4000001"], &["--objects", "4000001", "1..=4000000"]);
    check(&["--objects", ""], &["--objects"]);
    check(&["--density", "0.5"], &["--density", "0.5", "0.01 to 0.4"]);
    check(&["--density", "NaN"], &["--density", "NaN", "0.01 to 0.4"]);
    check(&["--seed=-1"], &["--seed"]);
    check(&["--threads", "2"], &["--threads"]);
}

/// The columns of `bench tradeoff` that are promised, in their order.
const TRADEOFF_FIELDS: [&str; 17] = [
    "scene",
    "scalar",
    "solver",
    "substeps",
    "certify",
    "skin",
    "rate",
    "positions",
    "ns_per_object_cycle",
    "missed",
    "tunnelled",
    "deepest",
    "overlapping_share",
    "deviation_mean",
    "deviation_max",
    "bytes_per_cycle",
    "pareto",
];

/// What `bench tradeoff` says of a few objects.
fn tradeoff(arguments: &[&str]) -> Value {
    json(&[&["bench", "tradeoff", "--objects", "80", "--cycles", "8", "--json"], arguments].concat())
}

fn rows_of(value: &Value) -> &Vec<Value> {
    value["rows"].as_array().expect("an array of rows")
}

fn number(row: &Value, field: &str) -> f64 {
    row[field].as_f64().unwrap_or_else(|| panic!("{field} of {row}"))
}

#[test]
fn bench_tradeoff_has_a_row_for_each_setting_and_the_exact_ones_are_right() {
    let value = tradeoff(&["--scene", "crowd", "--scene", "choke", "--scene", "crowd"]);
    let rows = rows_of(&value);
    let scenes: Vec<&Value> = rows.iter().map(|row| &row["scene"]).collect();
    assert_eq!(scenes, [["crowd"; 20], ["choke"; 20]].concat());
    for row in rows {
        assert!(TRADEOFF_FIELDS.iter().all(|field| row.get(field).is_some()), "{row}");
        for field in ["missed", "tunnelled", "overlapping_share"] {
            assert!((0.0..=1.0).contains(&number(row, field)), "{field} of {row}");
        }
        assert!(number(row, "ns_per_object_cycle") > 0.0 && number(row, "bytes_per_cycle") > 0.0, "{row}");
        assert!(number(row, "judged_stops") > 10.0, "there is something to miss: {row}");
        let is_exact = row["scalar"] == "f64"
            && row["solver"] == "event"
            && row["certify"] == true
            && row["positions"] == "exact"
            && number(row, "skin") < 1e-9;
        if is_exact {
            for field in ["missed", "tunnelled", "overlapping_share", "deepest", "error"] {
                assert_eq!(row[field], 0.0, "{field} of {row}");
            }
        }
    }
    let find =
        |setting: &str| rows.iter().find(|row| row["setting"] == setting).expect("a row of this setting");
    assert!(number(find("k=1"), "missed") > 0.01, "{}", find("k=1"));
    assert!(number(find("k=1"), "error") > number(find("k=16"), "error"));
    assert_eq!(find("k=1 certified")["overlapping_share"], 0.0);
    assert!(number(find("grid 2^-8"), "bytes_per_cycle") < number(find("exact"), "bytes_per_cycle"));
    assert_eq!(number(find("exact"), "bytes_per_point"), 16.0);
    assert_eq!(number(find("exact"), "run_deviation"), 0.0);
    let advice: Vec<&str> =
        value["advice"].as_array().expect("advice").iter().filter_map(Value::as_str).collect();
    assert!(advice.iter().any(|line| line.starts_with("crowd: exact costs ")), "{advice:?}");
    assert!(advice.iter().any(|line| line.starts_with("all scenes: ")), "{advice:?}");
}

#[test]
fn a_row_is_on_the_front_if_no_other_of_its_scene_is_as_good_in_all_and_better_in_something() {
    let value = tradeoff(&["--scene", "crowd"]);
    let rows = rows_of(&value);
    let worths: Vec<[f64; 4]> = rows
        .iter()
        .map(|row| {
            let rate = -number(row, "rate");
            [number(row, "ns_per_object_cycle"), number(row, "bytes_per_point"), number(row, "error"), rate]
        })
        .collect();
    for (row, own) in rows.iter().zip(&worths) {
        let beats = |other: &[f64; 4]| other != own && (0..4).all(|place| other[place] <= own[place]);
        assert_eq!(row["pareto"], !worths.iter().any(beats), "{row}");
        assert!(row["error"] == row["deviation_mean"] || row["error"] == 0.0, "{row}");
    }
    assert!(rows.iter().any(|row| row["pareto"] == true));
}

#[test]
fn bench_tradeoff_judges_the_same_whenever_it_runs() {
    let figures = |seed: &str| {
        let value = tradeoff(&["--scene", "gathering", "--seed", seed]);
        let fields = ["missed", "deepest", "deviation_mean", "bytes_per_cycle", "run_deviation"];
        rows_of(&value).iter().flat_map(|row| fields.map(|field| row[field].clone())).collect::<Vec<_>>()
    };
    assert_eq!(figures("5"), figures("5"));
    assert_ne!(figures("5"), figures("6"));
}

#[test]
fn bench_tradeoff_writes_its_rows_as_csv_and_a_picture_with_a_mark_for_each() {
    let out = folder("tradeoff").join("new/figures");
    let map = "maps/choke.tmx";
    let value = tradeoff(&["--scene", "far", "--scene", map, "--out", &out.display().to_string()]);
    let rows = rows_of(&value);
    assert_eq!((rows.len(), &rows[39]["scene"]), (40, &map.into()));
    let csv = std::fs::read_to_string(out.join("tradeoff.csv")).expect("a table");
    let mut lines = csv.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let names = lines.next().expect("a line of names");
    assert_eq!(names[..17], TRADEOFF_FIELDS);
    assert_eq!(names.len(), rows[0].as_object().expect("a row").len());
    let lines: Vec<_> = lines.collect();
    assert_eq!(lines.len(), rows.len());
    for (line, row) in lines.iter().zip(rows) {
        assert_eq!(line.len(), names.len(), "{line:?}");
        for (name, text) in names.iter().zip(line) {
            match &row[*name] {
                Value::Number(number) => assert_eq!(text.parse().ok(), number.as_f64(), "{name}"),
                Value::String(word) => assert_eq!(text, word, "{name}"),
                Value::Null => assert_eq!(*text, "", "{name}"),
                other @ (Value::Bool(_) | Value::Array(_) | Value::Object(_)) => {
                    assert_eq!(*text, other.to_string(), "{name}");
                }
            }
        }
    }
    let svg = std::fs::read_to_string(out.join("tradeoff.svg")).expect("a picture");
    assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"), "{svg}");
    assert_eq!(svg.matches("<text").count(), svg.matches("</text>").count());
    assert_eq!(svg.matches("<circle").count(), 6 + rows.len(), "six in the legend");
    assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    for row in rows {
        assert!(svg.contains(&format!(">{}</text>", row["setting"].as_str().expect("a name"))), "{row}");
    }
}

#[test]
fn what_bench_tradeoff_cannot_do_is_an_error_that_names_it() {
    let check = |arguments: &[&str], code: i32, named: &[&str]| {
        let error = fails(&[&["bench", "tradeoff"], arguments].concat(), code);
        assert!(named.iter().all(|name| error.contains(name)), "{error} does not name {named:?}");
    };
    let names = ["--scene plain", "open", "crowd", "choke", "gathering", "fast", "far", "map"];
    check(&["--scene", "plain"], 2, &names);
    check(&["--scene", "README.md"], 2, &["--scene README.md", "gathering"]);
    check(&["--scene", "no/such.map"], 3, &["no/such.map"]);
    let folder = folder("tradeoff_refused");
    let (map, plain) = (file(&folder, "odd.map", "type none\n"), file(&folder, "plain", ""));
    check(&["--scene", &map], 3, &["odd.map"]);
    check(&["--scene", "open", "--out", &plain], 1, &[&plain, "no folder"]);
    check(&["--objects", "19"], 2, &["--objects", "20..=100000"]);
    check(&["--cycles", "0"], 2, &["--cycles", "1..=100000"]);
}

#[test]
fn bench_wire_counts_bytes_and_packed_deltas_keep_to_their_goals() {
    let rows = json(&["bench", "wire", "--cycles", "300", "--json"]);
    let rows = rows.as_array().expect("an array of rows");
    assert_eq!(rows.len(), 4 * 6);
    let bytes = |scene: &str, encoding: &str, positions: &str| {
        let is_it = |row: &&Value| {
            row["scene"] == scene && row["encoding"] == encoding && row["positions"] == positions
        };
        let row = rows.iter().find(is_it).expect("a row for each");
        assert_eq!((row.as_object().expect("a row").len(), &row["cycles"]), (8, &300.into()), "{row}");
        assert!(row["objects"].as_f64().is_some_and(|objects| objects > 170.0), "{row}");
        assert!(row["events_per_object_cycle"].as_f64().is_some_and(|events| events > 0.0), "{row}");
        row["bytes_per_object_cycle"].as_f64().expect("a number")
    };
    for scene in ["turning", "walks of 8", "walks of 40", "walks of 160"] {
        let [absolute, plain, packed, bound] =
            ["absolute", "bincode", "packed", "bound"].map(|encoding| bytes(scene, encoding, "exact"));
        let [packed_grid, bound_grid] = ["packed", "bound"].map(|encoding| bytes(scene, encoding, "grid"));
        println!("{scene}: {absolute} {plain} {packed} {bound}, {packed_grid} {bound_grid}");
        assert!(bound < packed && packed < absolute && packed < plain, "{scene}");
        assert!(bound_grid < packed_grid && packed_grid < packed, "{scene}");
    }
    let [absolute, packed] = ["absolute", "packed"].map(|encoding| bytes("walks of 40", encoding, "exact"));
    assert!(packed <= 0.9 && 10.0 * packed <= absolute, "{packed} {absolute}");
    assert!(bytes("walks of 40", "packed", "grid") <= 0.5);
}

#[test]
fn bench_wire_plays_a_scenario_and_names_what_it_cannot() {
    let scenario = format!("{ROOT}/config/scenarios/duel.toml");
    let rows = json(&["bench", "wire", "--scenario", &scenario, "--cycles", "50", "--json"]);
    let encodings: Vec<&Value> =
        rows.as_array().expect("an array of rows").iter().map(|row| &row["encoding"]).collect();
    assert_eq!(encodings, ["absolute", "bincode", "packed"]);
    assert_eq!(rows[0]["cycles"], 50);
    let error = fails(&["bench", "wire", "--scenario", "none.toml"], 3);
    assert!(error.contains("none.toml"), "{error}");
    fails(&["bench", "wire", "--objects", "0"], 2);
}

/// The fields of a row of `bench path`.
const PATH_FIELDS: [&str; 14] = [
    "map",
    "planner",
    "units",
    "arrived",
    "makespan",
    "bound",
    "throughput",
    "collisions_per_unit",
    "plan_us_p50",
    "plan_us_p99",
    "plan_us_per_unit_cycle",
    "length_ratio_mean",
    "length_ratio_max",
    "states",
];

#[test]
fn bench_path_walks_what_every_planner_plans() {
    let map = format!("{ROOT}/maps/rooms.map");
    let planners = ["single", "pibt", "lacam", "refined", "spacetime", "joint", "conflict"];
    let arguments = ["--planner", &planners.join(","), "--units", "3", "--refine", "0.05", "--json"];
    let rows = json(&[&["bench", "path", "--map", &map][..], &arguments].concat());
    let rows = rows.as_array().expect("an array of rows");
    let names: Vec<&Value> = rows.iter().map(|row| &row["planner"]).collect();
    assert_eq!(names, planners);
    for row in rows {
        let fields: Vec<&String> = row.as_object().expect("a row").keys().collect();
        assert_eq!(fields.len(), PATH_FIELDS.len(), "{fields:?}");
        assert!(PATH_FIELDS.iter().all(|field| row.get(field).is_some()), "{fields:?}");
        assert_eq!((&row["units"], &row["arrived"]), (&3.into(), &3.into()), "{row}");
        assert_eq!((&row["map"], &row["collisions_per_unit"]), (&"rooms".into(), &0.0.into()), "{row}");
        if row["planner"] == "single" {
            assert_eq!((&row["makespan"], &row["states"]), (&Value::Null, &Value::Null), "{row}");
        } else {
            assert!(row["makespan"].as_f64() >= row["bound"].as_f64(), "{row}");
            assert!(row["length_ratio_mean"].as_f64().is_some_and(|ratio| ratio >= 1.0), "{row}");
        }
    }
}

#[test]
fn bench_path_leads_groups_through_gaps_as_fast_as_they_may_go() {
    let rows = json(&[
        "bench",
        "path",
        "--planner",
        "release,alone",
        "--scene",
        "open,gap-1,gap-2,gap-3",
        "--units",
        "20",
        "--json",
    ]);
    let rows = rows.as_array().expect("an array of rows");
    let named = |planner: &str, map: &str| {
        let found = rows.iter().find(|row| row["planner"] == planner && row["map"] == map);
        found.unwrap_or_else(|| panic!("no {planner} of {map} in {rows:?}"))
    };
    for map in ["open", "gap-1", "gap-2", "gap-3"] {
        let row = named("release", map);
        assert_eq!((&row["arrived"], &row["collisions_per_unit"]), (&20.into(), &0.0.into()), "{row}");
        assert!(row["makespan"].as_f64() >= row["bound"].as_f64(), "{row}");
        match row["throughput"].as_f64() {
            Some(share) => assert!(map != "open" && (0.5..1.02).contains(&share), "{row}"),
            None => assert_eq!(map, "open", "{row}"),
        }
        let alone = named("alone", map);
        assert!(map == "open" || alone["arrived"].as_u64() < Some(20), "{alone}");
    }
}

#[test]
fn bench_path_takes_queries_from_a_file_and_as_many_units_as_it_has() {
    let folder = folder("bench_path");
    std::fs::copy(format!("{ROOT}/maps/rooms.map"), folder.join("rooms.map")).expect("a copy");
    let rooms = std::fs::read_to_string(folder.join("rooms.map")).expect("a map");
    let size = |line: usize| rooms.lines().nth(line).and_then(|line| line.split(' ').nth(1)).expect("a size");
    let (height, width) = (size(1), size(2));
    let open: Vec<(usize, usize)> = (0..)
        .zip(rooms.lines().skip(4))
        .flat_map(|(y, row)| {
            row.bytes().enumerate().filter(|&(_, tile)| tile == b'.').map(move |(x, _)| (x, y))
        })
        .collect();
    let [(x, y), (to_x, to_y)] = [open[0], open[1]];
    let query = format!("0\trooms.map\t{width}\t{height}\t{x}\t{y}\t{to_x}\t{to_y}\t1\n");
    let scene = folder.join("one.scen");
    std::fs::write(&scene, format!("version 1\n{query}")).expect("a file");
    let scene = scene.to_str().expect("a name");
    let rows =
        json(&["bench", "path", "--scen", scene, "--planner", "single,pibt", "--units", "1,50", "--json"]);
    let units: Vec<&Value> = rows.as_array().expect("rows").iter().map(|row| &row["units"]).collect();
    assert_eq!(units, [1, 1], "{rows}");
    assert_eq!(rows[0]["length_ratio_mean"], 1.0);
    let other = format!("{ROOT}/maps/choke.tmx");
    let error = fails(&["bench", "path", "--scen", scene, "--map", &other], 3);
    assert!(error.contains("one.scen") && error.contains("--map"), "{error}");
}

#[test]
fn what_bench_path_cannot_do_is_an_error_that_names_it() {
    let check = |arguments: &[&str], code: i32, named: &[&str]| {
        let error = fails(&[&["bench", "path"], arguments].concat(), code);
        assert!(named.iter().all(|name| error.contains(name)), "{error}");
    };
    check(&["--planner", "lakam"], 2, &["lakam", "single, pibt, lacam, spacetime, joint, conflict, refined"]);
    check(&["--planner", "joint", "--units", "9"], 2, &["9 agents", "8 at most"]);
    check(&["--planner", "pibt", "--radius", "0.4"], 3, &["0.4", "0.35355"]);
    check(&["--units", "0"], 2, &["--units"]);
    check(&["--scen", "no/such.scen"], 3, &["no/such.scen"]);
    check(&["--map", "no/such.map"], 3, &["no/such.map"]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_load_that_cannot_be_is_a_usage_error_and_a_small_one_is_measured() {
    for wrong in [["--matches", "0"], ["--clients", "20001"], ["--seconds", "0"], ["--rate", "NaN"]] {
        let error = fails(&["bench", "load", wrong[0], wrong[1]], 2);
        assert!(error.contains(wrong[0]) && error.contains("is needed"), "{error}");
    }
    let load =
        ["bench", "load", "--clients", "9", "--matches", "2", "--hostile", "5", "--seconds", "0.5", "--json"];
    let row = json(&load);
    assert_eq!(
        (&row["clients"], &row["matches"], &row["disconnected"]),
        (&9.into(), &2.into(), &serde_json::json!({}))
    );
    for figure in ["lateness_ms_p50", "rss_mib", "bytes_per_client_second"] {
        assert!(row[figure].as_f64().is_some_and(|figure| figure > 0.0), "{figure}: {row}");
    }
}
