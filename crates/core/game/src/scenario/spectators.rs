//! Who may watch a match, and how far behind.

use super::check::{Found, number_or};
use super::file::{self, Views};
use super::units::cycles;
use super::{DELAY_CYCLES_MAX, DELAY_SECONDS_DEFAULT, DELAY_SECONDS_MAX};

/// Who may watch a match.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Spectators {
    /// What they may watch.
    pub views: Views,
    /// Cycles by which they are behind; 0: they see what players see as soon as those do.
    pub delay: u32,
}

/// Returns the rule; where no delay is written that of [`DELAY_SECONDS_DEFAULT`], or as much as can be kept at a high rate.
pub(super) fn spectators(rule: &file::Spectators, rate: f64) -> Found<Spectators> {
    let longest = f64::from(DELAY_CYCLES_MAX) / rate;
    let longest = if longest < DELAY_SECONDS_MAX { longest } else { DELAY_SECONDS_MAX };
    let default = if longest < DELAY_SECONDS_DEFAULT { longest } else { DELAY_SECONDS_DEFAULT };
    let seconds = number_or(rule.delay_seconds.as_ref(), default, "delay_seconds", 0.0, longest)?;
    Ok(Spectators { views: rule.views, delay: if seconds > 0.0 { cycles(seconds, rate) } else { 0 } })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scenario;

    #[test]
    fn nobody_may_watch_unless_the_scenario_says_so() {
        assert_eq!(read("", 8.0), Ok(None));
        let rule = |views, delay| Ok(Some(Spectators { views, delay }));
        assert_eq!(read("[spectators]\nviews = 'seats'", 8.0), rule(Views::Seats, 240));
        assert_eq!(read("[spectators]\nviews = 'all'", 1000.0), rule(Views::All, DELAY_CYCLES_MAX));
        assert_eq!(read("[spectators]\nviews = 'all'\ndelay_seconds = 0", 8.0), rule(Views::All, 0));
        assert_eq!(read("[spectators]\nviews = 'all'\ndelay_seconds = 0.01", 8.0), rule(Views::All, 1));
        assert_eq!(read("[spectators]\nviews = 'seats'\ndelay_seconds = 2.5", 4.0), rule(Views::Seats, 10));
    }

    #[test]
    fn a_mistake_in_the_rule_is_told() {
        let check = |rule: &str, rate: f64, expected: &str| {
            let error = read(&format!("[spectators]\n{rule}"), rate).unwrap_err();
            assert!(error.contains(expected), "{error}\n  lacks {expected}");
        };
        check("", 8.0, "missing field `views`");
        check("views = 'seat'", 8.0, "did you mean `seats`?");
        check("views = 'all'\ndelay = 3", 8.0, "unknown field `delay`");
        check("views = 'all'\ndelay_seconds = -1", 8.0, "delay_seconds is -1; it must be from 0 to 600");
        check("views = 'all'\ndelay_seconds = 601", 8.0, "delay_seconds is 601; it must be from 0 to 600");
        check("views = 'all'\ndelay_seconds = 9", 1000.0, "delay_seconds is 9; it must be from 0 to 8.192");
    }

    fn read(rule: &str, rate: f64) -> Result<Option<Spectators>, String> {
        let text = format!(
            "name = 'x'\nmap = 'x.map'\nrate = {rate:?}\nlength_seconds = 60\nobjective = {{ kind = 'race' }}\n\
             unit.a = {{ radius = 1, speed = 1 }}\nseat = [{{ groups = [{{ unit = 'a', count = 1 }}] }}]\n{rule}\n"
        );
        let scenario = Scenario::read("x.toml", &text).map_err(|error| error.to_string())?;
        Ok(scenario.spectators)
    }
}
