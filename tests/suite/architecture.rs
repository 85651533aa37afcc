//! The crates are those of `docs/ARCHITECTURE.md`, and the core is as pure as it says.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../..");

/// The edges of the layout that was planned; those of the command, which may use everything, left out.
const EDGES_PLANNED: [(&str, &[&str]); 10] = [
    ("tilemap", &["geometry"]),
    ("kinematics", &["geometry"]),
    ("pathfinding", &["geometry", "tilemap"]),
    ("view", &["geometry", "tilemap"]),
    ("game", &["kinematics", "tilemap", "view"]),
    ("referee", &["game", "view"]),
    ("protocol", &["view"]),
    ("bots", &["view"]),
    ("server", &["referee", "protocol"]),
    ("client", &["protocol"]),
];

/// The outside packages that were chosen at the start.
const PACKAGES_PLANNED: [&str; 14] = [
    "bincode",
    "bytes",
    "clap",
    "glam",
    "indicatif",
    "rayon",
    "serde",
    "serde_json",
    "thiserror",
    "tiled",
    "tokio",
    "tokio-util",
    "toml",
    "tracing",
];

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
fn the_oracle_shares_nothing_with_what_it_judges() {
    let judged = |folder: &str| folder.starts_with("crates/core/");
    for (folder, manifest) in manifests() {
        let (name, tables) = (name_of(&manifest), ["dependencies", "dev-dependencies"]);
        for package in tables.iter().flat_map(|table| names(&manifest, table)) {
            assert!(!judged(&folder) || package != "maniple-oracle", "{name} depends on the oracle");
            assert!(name != "oracle" || !package.starts_with("maniple-"), "the oracle depends on {package}");
        }
    }
    assert!(manifested().contains_key("oracle"));
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
fn no_message_names_an_object_of_the_world() {
    let wire = [
        "protocol/src",
        "view/src/delta.rs",
        "view/src/command.rs",
        "view/src/outcome.rs",
        "view/src/view.rs",
    ];
    for part in wire {
        let path = Path::new(ROOT).join("crates/core").join(part);
        let files = if path.is_dir() { sources(&path) } else { vec![path] };
        for file in files {
            let text = std::fs::read_to_string(&file).expect("a source is text");
            assert!(!text.contains("ObjectId"), "{} names an object of the world", file.display());
        }
    }
}

#[test]
fn every_edge_and_package_beyond_the_plan_has_a_decision() {
    let decisions: String = entries("docs/decisions")
        .iter()
        .map(|page| std::fs::read_to_string(page).expect("a page is text"))
        .collect();
    for (name, (_, edges, packages)) in manifested() {
        let planned = EDGES_PLANNED.iter().find(|(from, _)| *from == name).map_or(&[][..], |(_, to)| to);
        for edge in edges.iter().filter(|edge| name != "cli" && !planned.contains(&edge.as_str())) {
            assert!(decisions.contains(&format!("`{name} -> {edge}`")), "no decision on {name} -> {edge}");
        }
        for package in packages.union(&packages_of_tests(&name)) {
            let is_planned = PACKAGES_PLANNED.contains(&package.as_str());
            assert!(is_planned || decisions.contains(&format!("`{package}`")), "no decision on {package}");
        }
    }
}

#[test]
fn every_other_name_in_the_glossary_is_an_alias_in_the_code() {
    let code: String = sources(&Path::new(ROOT).join("crates"))
        .iter()
        .map(|path| std::fs::read_to_string(path).expect("a source is text"))
        .collect();
    let glossary = std::fs::read_to_string(Path::new(ROOT).join("docs/GLOSSARY.md")).expect("the glossary");
    let mut others = 0;
    for line in glossary.lines().filter(|line| line.starts_with("| ")) {
        let word = line.split('|').nth(1).expect("a row has cells");
        let Some((_, names)) = word.trim().trim_end_matches(')').split_once(" (") else { continue };
        for name in names.split(", ") {
            others += 1;
            assert!(code.contains(&format!("#[doc(alias = \"{name}\")]")), "{name} is no alias");
        }
    }
    assert!(others > 10, "{others}");
}

#[test]
fn the_bans_of_the_core_close_every_door_and_reach_floats_of_both_widths() {
    let text = std::fs::read_to_string(Path::new(ROOT).join("crates/core/clippy.toml")).expect("the bans");
    let bans: toml::Table = text.parse().expect("they are TOML");
    let paths: BTreeSet<String> = ["disallowed-types", "disallowed-methods"]
        .iter()
        .flat_map(|list| bans[*list].as_array().expect("a list"))
        .map(|ban| ban["path"].as_str().expect("a path").to_owned())
        .collect();
    let doors = [
        (
            "std::fs::",
            "File OpenOptions DirBuilder read read_to_string read_dir write copy rename remove_file",
        ),
        ("std::os::unix::net::", "UnixStream UnixListener UnixDatagram"),
        ("std::net::", "TcpStream TcpListener UdpSocket"),
        ("std::thread::", "spawn scope sleep Builder Builder::spawn Builder::spawn_scoped"),
        ("std::time::", "Instant SystemTime"),
        ("std::env::", "var var_os vars args current_dir"),
        ("std::collections::", "HashMap HashSet"),
        ("std::hash::", "RandomState DefaultHasher"),
        ("rand::", "rng random thread_rng"),
        ("f64::", "sin cos tan sin_cos asin acos atan atan2 sinh cosh tanh asinh acosh atanh"),
        ("f64::", "exp exp2 exp_m1 ln ln_1p log log2 log10 powf powi cbrt hypot mul_add min max clamp"),
        (
            "glam::DVec2::",
            "from_angle to_angle angle_to rotate_towards exp exp2 ln log2 powf mul_add min max clamp",
        ),
        ("glam::DMat2::", "from_angle"),
        ("glam::DAffine2::", "from_angle"),
    ];
    for (module, names) in doors {
        for name in names.split(' ') {
            assert!(paths.contains(&format!("{module}{name}")), "{module}{name} is not banned");
        }
    }
    let narrow = |path: &str| path.replace("f64::", "f32::").replace("glam::D", "glam::");
    for path in &paths {
        assert!(paths.contains(&narrow(path)), "{path} is banned, {} is not", narrow(path));
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
    for (folder, manifest) in manifests() {
        let (ours, outside): (BTreeSet<String>, BTreeSet<String>) =
            names(&manifest, "dependencies").into_iter().partition(|name| name.starts_with("maniple-"));
        let edges = ours.iter().map(|name| short(name)).collect();
        crates.insert(name_of(&manifest), (folder, edges, outside));
    }
    crates
}

/// Returns the outside packages that only the tests of a crate depend on.
fn packages_of_tests(name: &str) -> BTreeSet<String> {
    let manifests = manifests();
    let (_, manifest) = manifests.iter().find(|(_, manifest)| name_of(manifest) == name).expect("a crate");
    names(manifest, "dev-dependencies").into_iter().filter(|name| !name.starts_with("maniple-")).collect()
}

/// Returns the folder and the manifest of each crate.
fn manifests() -> Vec<(String, toml::Table)> {
    let mut found = Vec::new();
    let crates = ["crates/core", "crates/shell"].into_iter().flat_map(|part| {
        let name = |folder: &PathBuf| folder.file_name().expect("a name").to_string_lossy().into_owned();
        entries(part).into_iter().map(move |folder| format!("{part}/{}", name(&folder)))
    });
    // Other folders of the tests are workspaces of their own.
    for folder in crates.chain(["tests/oracle".to_owned()]) {
        let manifest = Path::new(ROOT).join(&folder).join("Cargo.toml");
        let Ok(text) = std::fs::read_to_string(manifest) else { continue };
        found.push((folder, text.parse().expect("a manifest is TOML")));
    }
    found
}

fn name_of(manifest: &toml::Table) -> String {
    short(manifest["package"]["name"].as_str().expect("a name"))
}

fn short(name: &str) -> String {
    name.trim_start_matches("maniple-").to_owned()
}

/// Returns the keys of a table of a manifest; none where there is no such table.
fn names(manifest: &toml::Table, table: &str) -> BTreeSet<String> {
    let of_all = manifest.get(table).and_then(toml::Value::as_table);
    // What only some platforms need.
    let targets =
        manifest.get("target").and_then(toml::Value::as_table).into_iter().flat_map(toml::Table::values);
    let of_some = targets.filter_map(|target| target.get(table).and_then(toml::Value::as_table));
    of_all.into_iter().chain(of_some).flat_map(|table| table.keys().cloned()).collect()
}

/// Returns what is in a folder of the repository.
fn entries(folder: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(Path::new(ROOT).join(folder)).expect("the folder is there");
    entries.flatten().map(|entry| entry.path()).collect()
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
