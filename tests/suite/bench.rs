//! `maniple bench`: rows that can be read, and bits that do not depend on threads.

use serde_json::Value;

use crate::commands::{fails, json, run};

/// The fields of a row of `bench scale` without a map.
const FIELDS: [&str; 14] = [
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
