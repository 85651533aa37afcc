//! The bot that gathers.

use maniple_view::{Command, Delta, View};

use crate::economy::Miners;
use crate::player::{Play, Start};
use crate::post::Post;
use crate::seeing::Item;

/// Lets all its workers gather, each between a place beside a patch and one beside a building that are its own, and does nothing
/// else.
#[derive(Clone, Debug)]
pub(crate) struct Gather {
    post: Post,
    miners: Miners,
}

impl Gather {
    pub(crate) const NAME: &str = "gather";

    pub(crate) fn begin(start: &Start, _view: &View) -> Self {
        Self { post: Post::default(), miners: Miners::new(start.seed) }
    }
}

impl Play for Gather {
    fn play(&mut self, start: &Start, view: &View, _delta: &Delta) -> Vec<Command> {
        let scene = self.post.look(start, view);
        let workers: Vec<&Item<'_>> = scene.own.iter().filter(|item| item.kind.harvest.is_some()).collect();
        self.miners.work(&mut self.post, view.cycle(), &scene, &workers)
    }
}
