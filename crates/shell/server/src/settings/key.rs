//! The keys of the configuration: the one place that lists them.

/// A key: where it stands, what it may hold, and what it means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key {
    /// The section, as in `[limits]`.
    pub section: &'static str,
    /// The name within the section.
    pub name: &'static str,
    /// What it may hold.
    pub kind: Kind,
    /// What holds where nobody says anything, as it is written in the environment.
    pub default: &'static str,
    /// What it means, in a sentence.
    pub meaning: &'static str,
}

/// What a key may hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// An IP address and a port.
    Address,
    /// The same, or nothing.
    OptionalAddress,
    /// The path of a file, of a folder or of a socket, or nothing.
    OptionalPath,
    /// A whole number.
    Count {
        /// The smallest.
        least: u32,
        /// The largest.
        most: u32,
    },
    /// One of these words.
    Choice(&'static [&'static str]),
    /// Any text.
    Text,
    /// Names, and a file for each.
    Files,
}

/// Where players and spectators connect.
pub const ADDRESS: Key = Key {
    section: "listen",
    name: "address",
    kind: Kind::Address,
    default: "127.0.0.1:7171",
    meaning: "Where players and spectators connect; port 0 takes any that is free.",
};

/// The certificate of the server.
pub const TLS_CERTIFICATE: Key = Key {
    section: "listen",
    name: "tls_certificate",
    kind: Kind::OptionalPath,
    default: "",
    meaning: "PEM file with the certificate of the server, and those that vouch for it behind. With it, and with the key, players \
              and spectators connect by TLS and in no other way; without it nothing is encrypted.",
};

/// The private key of the certificate.
pub const TLS_KEY: Key = Key {
    section: "listen",
    name: "tls_key",
    kind: Kind::OptionalPath,
    default: "",
    meaning: "PEM file with the private key of the certificate.",
};

/// The socket of the administration.
pub const ADMIN_SOCKET: Key = Key {
    section: "listen",
    name: "admin_socket",
    kind: Kind::OptionalPath,
    default: "",
    meaning: "Unix socket for `maniple admin`; without it there is no administration.",
};

/// The token of the administration.
pub const ADMIN_TOKEN_FILE: Key = Key {
    section: "listen",
    name: "admin_token_file",
    kind: Kind::OptionalPath,
    default: "",
    meaning: "File with the token of the administration, 32 hex digits. If it does not exist, it is made with a random token and \
              is for the owner alone. Without this key it is `admin_socket` with `.token` behind.",
};

/// Where health, metrics and matches are asked for.
pub const HTTP: Key = Key {
    section: "listen",
    name: "http",
    kind: Kind::OptionalAddress,
    default: "",
    meaning: "Where `/healthz`, `/readyz`, `/metrics` and `/matches` are asked for; without it nowhere. Whoever reaches it can ask, \
              so it should not be reached from everywhere.",
};

/// Who may create matches.
pub const CREATE: Key = Key {
    section: "lobby",
    name: "create",
    kind: Kind::Choice(&["anyone", "admin"]),
    default: "anyone",
    meaning: "Who may create matches of the scenarios: whoever connects, or the administration alone.",
};

/// The scenarios of which matches can be created.
pub const SCENARIOS: Key = Key {
    section: "lobby",
    name: "scenarios",
    kind: Kind::Files,
    default: "",
    meaning: "The scenarios of which matches can be created: a name, and its file, which is read at the start. With any the daemon has \
              a lobby, and without one it plays one match after the other.",
};

/// Connections at the same time.
pub const CONNECTIONS: Key = Key {
    section: "limits",
    name: "connections",
    kind: Kind::Count { least: 1, most: 65_536 },
    default: "8192",
    meaning: "Connections at the same time, in all; more wait in the backlog of the socket.",
};

/// Connections at the same time from one address.
pub const CONNECTIONS_PER_ADDRESS: Key = Key {
    section: "limits",
    name: "connections_per_address",
    kind: Kind::Count { least: 1, most: 65_536 },
    default: "8192",
    meaning: "Connections at the same time from one IP address.",
};

/// Matches at the same time.
pub const MATCHES: Key = Key {
    section: "limits",
    name: "matches",
    kind: Kind::Count { least: 1, most: 65_536 },
    default: "1024",
    meaning: "Matches at the same time, in all.",
};

/// Matches at the same time that one address has created.
pub const MATCHES_PER_ADDRESS: Key = Key {
    section: "limits",
    name: "matches_per_address",
    kind: Kind::Count { least: 1, most: 65_536 },
    default: "1024",
    meaning: "Matches at the same time that clients of one IP address have created.",
};

/// Time for the players of a match in the lobby to come.
pub const BEGIN_SECONDS: Key = Key {
    section: "limits",
    name: "begin_seconds",
    kind: Kind::Count { least: 1, most: 86_400 },
    default: "600",
    meaning: "Seconds for the players of a match that a client has created to come; after that it is given up.",
};

/// Where the journals are.
pub const DIRECTORY: Key = Key {
    section: "journal",
    name: "directory",
    kind: Kind::OptionalPath,
    default: "",
    meaning: "Folder with the journals of the matches, which go on when the daemon starts again; without it a match ends with the daemon.",
};

/// Milliseconds within which a journal is on the disk.
pub const SYNC_MILLISECONDS: Key = Key {
    section: "journal",
    name: "sync_milliseconds",
    kind: Kind::Count { least: 1, most: 10_000 },
    default: "100",
    meaning: "Milliseconds after which at most a journal is on the disk: what a power cut can lose.",
};

/// What is logged.
pub const FILTER: Key = Key {
    section: "log",
    name: "filter",
    kind: Kind::Text,
    default: "warn",
    meaning: "What to log to standard error, as in `debug` or `maniple_server=trace,warn`.",
};

/// How it is logged.
pub const FORMAT: Key = Key {
    section: "log",
    name: "format",
    kind: Kind::Choice(&["text", "json"]),
    default: "text",
    meaning: "How to log: lines for people, or a JSON object a line.",
};

/// All keys, in the order in which they are printed.
pub const KEYS: [Key; 17] = [
    ADDRESS,
    TLS_CERTIFICATE,
    TLS_KEY,
    ADMIN_SOCKET,
    ADMIN_TOKEN_FILE,
    HTTP,
    CREATE,
    SCENARIOS,
    CONNECTIONS,
    CONNECTIONS_PER_ADDRESS,
    MATCHES,
    MATCHES_PER_ADDRESS,
    BEGIN_SECONDS,
    DIRECTORY,
    SYNC_MILLISECONDS,
    FILTER,
    FORMAT,
];

impl Key {
    /// Returns section and name, as in `limits.connections`.
    #[must_use]
    pub fn path(&self) -> String {
        format!("{}.{}", self.section, self.name)
    }

    /// Returns the variable of the environment, as in `MANIPLE_LIMITS_CONNECTIONS`.
    #[must_use]
    pub fn variable(&self) -> String {
        format!("{}{}_{}", VARIABLE_PREFIX, self.section, self.name).to_ascii_uppercase()
    }

    /// Returns the names of the sections, in order.
    pub(super) fn sections() -> Vec<&'static str> {
        let mut sections: Vec<&str> = KEYS.iter().map(|key| key.section).collect();
        sections.dedup();
        sections
    }
}

/// What the variables of the environment begin with.
pub(super) const VARIABLE_PREFIX: &str = "MANIPLE_";
