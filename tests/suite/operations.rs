//! What the operator's documents say is what there is.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use maniple_server::metrics::Metrics;
use maniple_server::settings::{KEYS, Key};
use serde_json::Value;

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../..");

#[test]
fn the_table_of_keys_is_that_of_the_program() {
    let row = |key: &Key| {
        let default = if key.default.is_empty() { "-".to_owned() } else { format!("`{}`", key.default) };
        format!("| `{}` | `{}` | {default} | {} | {} |", key.path(), key.variable(), key.kind, key.meaning)
    };
    let expected: Vec<String> = KEYS.iter().map(row).collect();
    assert_eq!(rows("docs/OPERATIONS.md", "## Every key"), expected);
}

#[test]
fn the_table_of_metrics_is_that_of_the_program() {
    let metrics = Metrics::default();
    let expected: Vec<String> = metrics
        .described()
        .iter()
        .map(|figure| {
            let label = figure.label().map_or_else(|| "-".to_owned(), |label| format!("`{label}`"));
            format!("| `{}` | {} | {label} | {} |", figure.full_name(), figure.kind(), figure.meaning)
        })
        .collect();
    assert_eq!(rows("docs/OPERATIONS.md", "## Every metric"), expected);
}

#[test]
fn the_dashboard_asks_for_all_metrics_and_no_others() {
    let metrics = Metrics::default();
    let names = metrics.described().map(|figure| match figure.kind() {
        "histogram" => figure.full_name() + "_bucket",
        _ => figure.full_name(),
    });
    let mut asked = BTreeSet::new();
    collect(&serde_json::from_str(&text("docs/operations/dashboard.json")).unwrap(), &mut asked);
    assert_eq!(asked, names.into_iter().collect());
}

#[test]
fn every_test_that_the_threat_model_names_is_there() {
    let model = text("docs/SECURITY.md");
    let mut code = String::new();
    for folder in ["crates", "tests"] {
        read_sources(&Path::new(ROOT).join(folder), &mut code);
    }
    let mut threats = 0;
    let is_row = |line: &&str| line.starts_with("| ") && !line.starts_with("| ---");
    for row in model.lines().filter(is_row).skip(1) {
        let tests = row.trim_end_matches(" |").rsplit(" | ").next().unwrap();
        let tests: Vec<&str> = tests.split('`').skip(1).step_by(2).collect();
        assert!(!tests.is_empty(), "no test: {row}");
        for test in tests {
            assert!(code.contains(&format!("fn {test}(")), "there is no test {test}");
        }
        threats += 1;
    }
    assert!(threats >= 10, "{threats}");
}

/// Returns the rows of the table below a heading, without its own heading.
fn rows(path: &str, heading: &str) -> Vec<String> {
    let text = text(path);
    let (_, below) =
        text.split_once(&format!("\n{heading}\n")).unwrap_or_else(|| panic!("no {heading} in {path}"));
    let section = below.split("\n## ").next().unwrap();
    section.lines().filter(|line| line.starts_with("| ")).skip(2).map(str::to_owned).collect()
}

/// Collects the names of all metrics in the queries of a dashboard.
fn collect(value: &Value, names: &mut BTreeSet<String>) {
    match value {
        Value::Object(fields) => {
            for (name, value) in fields {
                if name == "expr" {
                    let query = value.as_str().unwrap();
                    let words = query.split(|letter: char| !letter.is_ascii_alphanumeric() && letter != '_');
                    names.extend(words.filter(|word| word.starts_with("maniple_")).map(str::to_owned));
                }
                collect(value, names);
            }
        }
        Value::Array(values) => values.iter().for_each(|value| collect(value, names)),
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {}
    }
}

fn read_sources(folder: &Path, code: &mut String) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            read_sources(&path, code);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            code.push_str(&fs::read_to_string(path).unwrap());
        }
    }
}

fn text(path: &str) -> String {
    fs::read_to_string(Path::new(ROOT).join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}
