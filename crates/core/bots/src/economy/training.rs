//! What buildings that have nothing to do train.

use maniple_view::{Command, UnitTypeId};

use crate::player::Start;
use crate::seeing::{Item, Scene};

/// What there is when a building is to train.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Means {
    /// Resources.
    pub(crate) stock: u32,
    /// Workers, with those that are trained already.
    pub(crate) workers: usize,
}

/// Returns the commands to all buildings that train nothing; `choose` says what each shall train, and is asked about nothing that has to be
/// built first. What does not fit into the stock is not trained.
pub(crate) fn train(
    start: &Start,
    scene: &Scene<'_>,
    stock: u32,
    choose: impl Fn(&[UnitTypeId], Means) -> Option<UnitTypeId>,
) -> Vec<Command> {
    let gathers = |unit_type: UnitTypeId| start.kind(unit_type).harvest.is_some();
    let trained = |item: &Item<'_>| item.seen.own.and_then(|own| own.training);
    let counts = |item: &&Item<'_>| gathers(item.seen.unit_type) || trained(item).is_some_and(gathers);
    let mut means = Means { stock, workers: scene.own.iter().filter(counts).count() };
    let mut commands = Vec::new();
    for item in scene.own.iter().filter(|item| item.is_finished()) {
        if item.seen.own.is_none_or(|own| own.training.is_some()) {
            continue;
        }
        let can_be_had = |unit_type: &UnitTypeId| scene.meets_requirements(start.kind(*unit_type));
        let trains: Vec<UnitTypeId> = item.kind.trains.iter().copied().filter(can_be_had).collect();
        let choice = choose(&trains, means);
        let Some(unit_type) = choice.filter(|&unit_type| start.kind(unit_type).making.cost <= means.stock)
        else {
            continue;
        };
        means.stock -= start.kind(unit_type).making.cost;
        means.workers += usize::from(gathers(unit_type));
        commands.push(Command::Train { object: item.object, unit_type });
    }
    commands
}
