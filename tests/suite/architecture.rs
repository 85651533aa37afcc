//! The crates are those of `docs/ARCHITECTURE.md`, and the core is as pure as it says.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../..");

/// A crate: its folder, the crates and the outside packages that it depends on.
type Crates = BTreeMap<String, (String, BTreeSet<String>, BTreeSet<String>)>;

#[test]
fn the_table_of_crates_is_that_of_the_manifests() {
    assert_eq!(documented(), manifested());
}

#[test]
fn nothing_in_the_core_depends_on_the_shell() {
    for (name, (folder, crates, _)) in manifested() {
        let shell = ["server", "client", "cli"];
        if folder.starts_with("crates/core/") {
            assert!(shell.iter().all(|program| !crates.contains(*program)), "{name} depends on the shell");
        }
    }
}

#[test]
fn a_bot_cannot_reach_the_world() {
    let crates = manifested();
    let mut reached: BTreeSet<String> = BTreeSet::new();
    let mut next = vec!["bots".to_owned()];
    while let Some(name) = next.pop() {
        if reached.insert(name.clone()) {
            next.extend(crates[&name].1.iter().cloned());
        }
    }
    for secret in ["game", "referee", "kinematics"] {
        assert!(!reached.contains(secret), "bots depend on {secret}");
    }
}

#[test]
fn bincode_is_named_in_one_module_only() {
    let sources = sources(&Path::new(ROOT).join("crates"));
    let naming = sources.iter().filter(|path| {
        let text = std::fs::read_to_string(path).unwrap_or_default();
        text.lines().any(|line| !line.trim_start().starts_with("//") && line.contains("bincode::"))
    });
    let naming: Vec<&PathBuf> = naming.collect();
    assert_eq!(naming.len(), 1, "{naming:?}");
    assert!(naming[0].ends_with("core/protocol/src/codec.rs"), "{naming:?}");
}

#[test]
fn what_is_forbidden_in_the_core_is_forbidden_under_every_name() {
    let text = std::fs::read_to_string(Path::new(ROOT).join("crates/core/clippy.toml")).expect("the bans");
    let bans: toml::Table = text.parse().expect("TOML");
    let paths = |key: &str| -> BTreeSet<String> {
        let list = bans[key].as_array().expect("a list").iter();
        list.map(|ban| ban["path"].as_str().expect("a path").to_owned()).collect()
    };
    let banned: BTreeSet<String> =
        paths("disallowed-methods").union(&paths("disallowed-types")).cloned().collect();
    for path in &banned {
        for (of_double, of_single) in [("f64::", "f32::"), ("glam::DVec2::", "glam::Vec2::")] {
            for (one, other) in [(of_double, of_single), (of_single, of_double)] {
                let twin = path.strip_prefix(one).map(|name| format!("{other}{name}"));
                assert!(
                    twin.is_none_or(|twin| banned.contains(&twin)),
                    "{path} is forbidden, but not for {other}"
                );
            }
        }
    }
    for path in [
        "rand::rng",
        "std::env::var_os",
        "std::fs::OpenOptions",
        "std::fs::metadata",
        "std::fs::read_dir",
        "std::os::unix::net::UnixStream",
        "std::thread::Builder::spawn",
        "f64::exp_m1",
        "f64::tanh",
        "glam::DVec2::angle_to",
        "glam::DVec2::from_angle",
    ] {
        assert!(banned.contains(path), "{path} is not forbidden");
    }
}

#[test]
fn every_file_of_the_suite_is_in_the_suite() {
    let folder = Path::new(ROOT).join("tests/suite");
    for (parent, module) in [(folder.clone(), "main.rs"), (folder.join("kinematics"), "mod.rs")] {
        let text = std::fs::read_to_string(parent.join(module)).expect("the module is there");
        for entry in std::fs::read_dir(&parent).expect("the folder is there").flatten() {
            let path = entry.path();
            let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
            if path.file_name().is_some_and(|file| file != module) {
                assert!(text.contains(&format!("mod {name};")), "{} is not in {module}", path.display());
            }
        }
    }
}

/// The rows `| crate | folder | crates that it depends on | outside packages |` of the document.
fn documented() -> Crates {
    let text = std::fs::read_to_string(Path::new(ROOT).join("docs/ARCHITECTURE.md")).expect("the document");
    let list = |cell: &str| -> BTreeSet<String> {
        cell.split(',')
            .map(|name| name.trim().to_owned())
            .filter(|name| !name.is_empty() && name != "-")
            .collect()
    };
    let row = |line: &str| {
        let cells: Vec<&str> = line.strip_prefix("| `maniple-")?.split('|').map(str::trim).collect();
        let name = cells[0].trim_end_matches('`').to_owned();
        Some((name, (cells[1].trim_matches('`').to_owned(), list(cells[2]), list(cells[3]))))
    };
    text.lines().filter_map(row).collect()
}

fn manifested() -> Crates {
    let mut crates = Crates::new();
    for part in ["crates/core", "crates/shell"] {
        for entry in std::fs::read_dir(Path::new(ROOT).join(part)).expect("the folder is there").flatten() {
            let Ok(text) = std::fs::read_to_string(entry.path().join("Cargo.toml")) else { continue };
            let manifest: toml::Table = text.parse().expect("a manifest is TOML");
            let name = manifest["package"]["name"].as_str().expect("a name").to_owned();
            let names = manifest.get("dependencies").and_then(toml::Value::as_table).expect("dependencies");
            let (ours, outside): (Vec<&String>, Vec<&String>) =
                names.keys().partition(|name| name.starts_with("maniple-"));
            let short = |name: &String| name.trim_start_matches("maniple-").to_owned();
            let folder = format!("{part}/{}", entry.file_name().to_string_lossy());
            let edges = ours.into_iter().map(short).collect();
            crates.insert(short(&name), (folder, edges, outside.into_iter().cloned().collect()));
        }
    }
    crates
}

fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).expect("the folder is there").flatten() {
        let path = entry.path();
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            found.push(path);
        }
    }
    found
}
