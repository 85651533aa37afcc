//! What is said of a client in the end.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::mem::discriminant;

use serde::Serialize;

use super::mistake::Mistake;

/// A kind of mistake, as it was made first.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Finding {
    pub(crate) cycle: u32,
    /// In how many cycles or messages it was made.
    pub(crate) times: u32,
    pub(crate) mistake: &'static str,
    pub(crate) what: String,
    pub(crate) expected: String,
    pub(crate) remedy: &'static str,
}

/// The mistakes of a client; of each kind the first, and how many came after it.
#[derive(Debug, Default)]
pub(crate) struct Findings(Vec<(Mistake, Finding)>);

impl Findings {
    /// Takes down a mistake.
    pub(crate) fn note(&mut self, cycle: u32, mistake: Mistake) {
        let same = self.0.iter_mut().find(|(known, _)| discriminant(known) == discriminant(&mistake));
        if let Some((_, finding)) = same {
            finding.times += 1;
            return;
        }
        let finding = Finding {
            cycle,
            times: 1,
            mistake: mistake.name(),
            what: mistake.what(),
            expected: mistake.expected(cycle),
            remedy: mistake.remedy(),
        };
        self.0.push((mistake, finding));
    }

    pub(crate) fn into_list(self) -> Vec<Finding> {
        self.0.into_iter().map(|(_, finding)| finding).collect()
    }
}

/// The verdict.
#[derive(Debug, Serialize)]
pub(crate) struct Verdict {
    pub(crate) passed: bool,
    /// Cycles that were played.
    pub(crate) cycles: u32,
    /// Deltas after which the client proved that its view is the server's.
    pub(crate) proved: u32,
    /// Deltas that were to be answered: all but the last.
    pub(crate) deltas: u32,
    /// Commands of the client.
    pub(crate) commands: u32,
    /// What the client was told, and how often.
    pub(crate) told: BTreeMap<&'static str, u32>,
    pub(crate) findings: Vec<Finding>,
}

impl Verdict {
    /// Returns it for people.
    pub(crate) fn text(&self) -> String {
        let mut text = String::new();
        for finding in &self.findings {
            let times = if finding.times > 1 { format!(", {} times", finding.times) } else { String::new() };
            let _ = writeln!(text, "cycle {}{times}: {}", finding.cycle, finding.what);
            let _ = writeln!(text, "  expected: {}\n  remedy:   {}", finding.expected, finding.remedy);
        }
        if self.proved == 0 {
            text += "the client did not prove its view, so nothing is said of what it understands: see section 11 of \
                     docs/PROTOCOL.md\n";
        }
        let verdict = if self.passed { "passed".to_owned() } else { mistakes(self.findings.len()) };
        let Self { cycles, deltas, proved, commands, .. } = self;
        let _ = writeln!(
            text,
            "{verdict}: {cycles} cycles, {commands} commands, view proved after {proved} of {deltas} deltas"
        );
        text
    }
}

fn mistakes(count: usize) -> String {
    if count == 1 {
        "failed, 1 kind of mistake".to_owned()
    } else {
        format!("failed, {count} kinds of mistakes")
    }
}
