//! What every bot that looks before it acts keeps from cycle to cycle.

use maniple_view::{Rules, Seat, Shape, View};

use crate::moving::Roads;
use crate::orders::Orders;
use crate::seeing::{Block, Item, Memory, Scene};

/// The command post of a seat: the roads, what is remembered, and what everybody was told.
#[derive(Clone, Debug, Default)]
pub(crate) struct Post {
    pub(crate) roads: Roads,
    pub(crate) memory: Memory,
    pub(crate) orders: Orders,
}

impl Post {
    /// Takes in the view of a cycle, and returns it sorted.
    pub(crate) fn look<'a>(&mut self, view: &'a View, rules: &'a Rules, seat: Seat) -> Scene<'a> {
        let scene = Scene::of(view, rules, seat);
        self.memory.refresh(&scene);
        self.orders.refresh(&scene);
        let is_house = |item: &&Item<'_>| matches!(item.kind.shape, Shape::Rectangle { .. });
        let mut blocks: Vec<Block> = scene.all().filter(is_house).map(Item::block).collect();
        blocks.extend(self.memory.blocks().copied());
        blocks.sort_by(|one, other| {
            (one.center.y.total_cmp(&other.center.y)).then(one.center.x.total_cmp(&other.center.x))
        });
        blocks.dedup();
        self.roads.refresh(view.terrain(), blocks);
        scene
    }
}
