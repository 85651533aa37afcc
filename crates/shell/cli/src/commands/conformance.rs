//! `maniple conformance`: a fixed match against a client under test.

mod judge;
mod line;
mod mistake;
mod story;
mod verdict;

use std::net::TcpListener;
use std::time::{Duration, Instant};

use anyhow::Context;
use maniple_protocol::{Input, Refused, ServerMessage};
use serde::Serialize;

use crate::arguments::{ConformanceCommand, ConformanceServe};
use crate::failure::Failure;
use crate::output::{Format, print};
use judge::Judge;
use line::{Heard, Line};
use mistake::Mistake;

/// The token of the client's seat. The same in each run, because nothing is to be kept from anybody here.
const TOKEN: &str = "c0ffee00c0ffee00c0ffee00c0ffee00";

/// What a client has to know to be tested.
#[derive(Debug, Serialize)]
struct Opened {
    address: String,
    token: &'static str,
}

impl Opened {
    fn text(&self) -> String {
        format!("listening {}\nseat 0 token {}\n", self.address, self.token)
    }
}

/// Runs `maniple conformance`.
pub(crate) fn run(command: &ConformanceCommand) -> Result<(), Failure> {
    match command {
        ConformanceCommand::Serve(arguments) => serve(arguments),
    }
}

fn serve(arguments: &ConformanceServe) -> Result<(), Failure> {
    let format = Format::of(&arguments.json);
    let mut judge = Judge::new(arguments.reconnect)?;
    let listener = TcpListener::bind(arguments.listen)
        .with_context(|| format!("cannot listen on {}", arguments.listen))
        .map_err(Failure::Failed)?;
    let address = listener.local_addr().map_err(Failure::failed)?.to_string();
    print(format, &Opened { address, token: TOKEN }, Opened::text)?;
    let mut test = Test { listener, patience: Duration::from_secs(u64::from(arguments.patience)) };
    if let Err(mistake) = test.play(&mut judge)? {
        judge.note(mistake);
    }
    let verdict = judge.verdict();
    let is_passed = verdict.passed;
    print(format, &verdict, verdict::Verdict::text)?;
    if is_passed { Ok(()) } else { Err(Failure::Failed(anyhow::anyhow!("the client does not conform"))) }
}

/// The waiting for one client.
struct Test {
    listener: TcpListener,
    patience: Duration,
}

impl Test {
    /// Plays the match as far as the client goes; an inner error is the mistake after which it cannot go on.
    fn play(&mut self, judge: &mut Judge) -> Result<Result<(), Mistake>, Failure> {
        let Some(mut line) = self.accept(None)? else { return Ok(Err(Mistake::NoReturn)) };
        if let Err(mistake) = self.greet(&mut line, judge) {
            return Ok(Err(mistake));
        }
        loop {
            if let Err(mistake) = self.take_answer(&mut line, judge) {
                return Ok(Err(mistake));
            }
            line.say(&judge.step());
            if judge.has_ended() {
                line.finish(self.patience);
                return Ok(Ok(()));
            }
            if judge.wants_cut() {
                drop(line);
                let Some(next) = self.accept(Some(Instant::now() + self.patience))? else {
                    return Ok(Err(Mistake::NoReturn));
                };
                line = next;
                if let Err(mistake) = self.greet(&mut line, judge) {
                    return Ok(Err(mistake));
                }
            }
        }
    }

    /// Waits for a connection; `None` if none came in time.
    fn accept(&self, deadline: Option<Instant>) -> Result<Option<Line>, Failure> {
        let listener = &self.listener;
        listener.set_nonblocking(deadline.is_some()).map_err(Failure::failed)?;
        loop {
            match listener.accept() {
                Ok((stream, _)) => return Line::new(stream).map(Some).map_err(Failure::failed),
                Err(error) if error.kind() == std::io::ErrorKind::WouldBlock => {}
                Err(error) => return Err(Failure::failed(error)),
            }
            if deadline.is_some_and(|deadline| Instant::now() > deadline) {
                return Ok(None);
            }
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Takes the hello and answers with welcome and keyframe.
    fn greet(&self, line: &mut Line, judge: &mut Judge) -> Result<(), Mistake> {
        let hello = match self.hear(line, Instant::now() + self.patience)? {
            Input::Hello(hello) => hello,
            Input::Violation(reason) | Input::Dropped(reason) => {
                return Err(self.refuse(line, reason));
            }
            Input::Watch(_) => return Err(self.refuse(line, Refused::NoSpectators)),
            Input::List | Input::Create(_) | Input::Enter { .. } => {
                return Err(self.refuse(line, Refused::NoMatch));
            }
            Input::Commands { .. } | Input::Done { .. } | Input::Ping { .. } | Input::Pause { .. } => {
                return Err(self.refuse(line, Refused::Handshake));
            }
        };
        if !hello.token.eq_ignore_ascii_case(TOKEN) {
            self.refuse(line, Refused::Token);
            return Err(Mistake::Token);
        }
        match judge.welcome(&hello.player) {
            Ok(messages) => {
                line.say(&messages);
                Ok(())
            }
            Err(problem) => {
                let place = "the handshake".to_owned();
                Err(self.refuse(line, Refused::Malformed { place, problem }))
            }
        }
    }

    /// Takes what the client says until it is done with the cycle.
    fn take_answer(&self, line: &mut Line, judge: &mut Judge) -> Result<(), Mistake> {
        let deadline = Instant::now() + self.patience;
        while !judge.is_answered() {
            match self.hear(line, deadline)? {
                Input::Violation(reason) | Input::Dropped(reason) => {
                    return Err(self.refuse(line, reason));
                }
                Input::Hello(_) | Input::Watch(_) | Input::List | Input::Create(_) | Input::Enter { .. } => {
                    return Err(self.refuse(line, Refused::Handshake));
                }
                Input::Commands { seen_cycle, list } => judge.handle_commands(seen_cycle, list),
                Input::Done { cycle } => judge.handle_done(cycle),
                Input::Ping { id } => line.say(&[judge.handle_ping(id)]),
                Input::Pause { on } => line.say(&judge.handle_pause(on)),
            }
        }
        Ok(())
    }

    fn hear(&self, line: &mut Line, deadline: Instant) -> Result<Input, Mistake> {
        match line.hear(deadline) {
            Heard::Input(input) => Ok(input),
            Heard::Closed => Err(Mistake::Closed),
            Heard::Silence => Err(Mistake::Silent { seconds: self.patience.as_secs() }),
        }
    }

    /// Tells the client why it is refused, as the daemon does.
    fn refuse(&self, line: &mut Line, reason: Refused) -> Mistake {
        line.say(&[ServerMessage::Refused { reason: reason.clone() }]);
        line.finish(self.patience);
        Mistake::Violation(reason)
    }
}
