//! What every bot that looks before it acts keeps from cycle to cycle.

use maniple_view::{Shape, View};

use crate::moving::Roads;
use crate::orders::Orders;
use crate::player::Start;
use crate::seeing::{Item, Memory, Scene};

/// The command post of a seat: the roads, what is remembered, and what everybody was told.
#[derive(Clone, Debug, Default)]
pub(crate) struct Post {
    pub(crate) roads: Roads,
    pub(crate) memory: Memory,
    pub(crate) orders: Orders,
}

impl Post {
    /// Takes in the view of a cycle, and returns it sorted.
    pub(crate) fn look<'a>(&mut self, start: &'a Start, view: &'a View) -> Scene<'a> {
        let scene = start.scene(view);
        self.memory.refresh(&scene);
        self.orders.refresh(&scene);
        let is_house = |item: &&Item<'_>| matches!(item.kind.shape, Shape::Rectangle { .. });
        self.roads.refresh(view.terrain(), self.memory.with(scene.all().filter(is_house)));
        scene
    }
}
