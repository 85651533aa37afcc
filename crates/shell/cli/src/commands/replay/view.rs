//! `maniple replay view`: what a seat was told, or what there was to tell.

use anyhow::Context;
use maniple_geometry::Cycle;
use maniple_referee::{RecordedEvent, Stand};
use maniple_view::Vantage;

use super::{beginning, known_seat, read};
use crate::arguments::ReplayView;
use crate::failure::Failure;
use crate::output::{Format, Reader};
use crate::told::{print_cycle, print_end};

pub(super) fn run(arguments: &ReplayView) -> Result<(), Failure> {
    let (from, to) = (Cycle(arguments.from), Cycle(arguments.to.unwrap_or(u32::MAX)));
    if from > to {
        return Err(Failure::usage(format!("--from {from} --to {to}: the last cycle is before the first")));
    }
    let (replay, _) = read(&arguments.file)?;
    let mut referee = beginning(&replay, &arguments.file)?;
    let seat = arguments.seat.map(|seat| known_seat(seat, &referee)).transpose()?;
    let vantage = seat.map_or(Vantage::Everything, Vantage::Seat);
    referee.open_stand(vantage, 0);
    let format = if arguments.json { Format::Json } else { Format::Text };
    for event in maniple_server::events(&replay) {
        referee
            .handle_record(&event)
            .with_context(|| arguments.file.display().to_string())
            .map_err(Failure::Failed)?;
        match &event {
            RecordedEvent::Hash { cycle, .. } if *cycle > to => return Ok(()),
            RecordedEvent::Hash { cycle, .. } if *cycle >= from => {
                let stand = referee.stand(vantage).map_err(Failure::failed)?;
                if print_present(format, stand, *cycle == from)? == Reader::HasGone {
                    return Ok(());
                }
            }
            RecordedEvent::Ended { result } if referee.cycle() >= from => print_end(format, result)?,
            RecordedEvent::Hash { .. }
            | RecordedEvent::Ended { .. }
            | RecordedEvent::Joined { .. }
            | RecordedEvent::Commands { .. }
            | RecordedEvent::Forfeited { .. } => {}
        }
    }
    if referee.cycle() < from {
        let last = referee.cycle();
        return Err(Failure::usage(format!("--from {from}: the match has cycles 0 to {last}")));
    }
    Ok(())
}

/// Prints what is told of the present cycle; the first time the keyframe.
fn print_present(format: Format, stand: &Stand, is_first: bool) -> Result<Reader, Failure> {
    let keyframe = if is_first { stand.keyframe() } else { None };
    let told = keyframe.as_ref().or_else(|| stand.shown().first());
    told.map_or(Ok(Reader::Reads), |delta| print_cycle(format, stand.view(), delta))
}
