//! Which ways are planned, and how they are measured.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use maniple_pathfinding::in_step::AGENTS_MAX;

use crate::output::JsonFlag;

/// What the figures of `bench path` are.
pub(super) const PATH_HELP: &str = "\
Columns, the same in the table and as JSON; what a planner does not have is - or null:
  arrived              units that are exactly at their goals at the end; for single, paths that were walked without a collision
  makespan             cycles until the last of all that move arrives, at 0.2 tiles a cycle
  bound                what the makespan cannot be below: the longest way of one alone
  throughput           units a cycle that pass the gap, from the first to the last, as a share of the most that can: in the densest
                       packing of circles in rows; for groups at a gap alone
  collisions_per_unit  collisions in the kinematics, by the number of units
  plan_us_p50, plan_us_p99
                       planning in microseconds of processor time: single, for a path; pibt, for a step of all; others, for the whole plan
  plan_us_per_unit_cycle
                       planning by the number of units and the cycles of the plan; for pibt its steps alone, for the others with
                       the distances to goals
  length_ratio_mean, length_ratio_max
                       in step: the sum of costs over the sum of the shortest ways of each alone, and the largest of such
                       ratios of one unit; single: the length over a lower bound, the straight line or, if that is more, 0.9239
                       (the cosine of 22.5 degrees) of the shortest way of a point in eight directions on half tiles
  states               what the planner expanded: steps of all (pibt, lacam), windows of all (spacetime), places of all (joint), sets of
                       ways (conflict); for refined also places and times of one
Planners: single plans for each unit alone, in straight legs of any direction. The others plan for all together, in step, from
middle to middle of tiles: pibt makes one step of all after the other, lacam searches through such steps, refined makes what
lacam finds cheaper for --refine seconds, spacetime plans one after the other around reservations, joint and conflict find the
least sum of costs for a handful.
Groups that go anywhere have scenes of their own, or cross the map that --map names: release plans the departures of all on fixed
ways, and auto does so while it watches and mends what goes wrong; alone, follow and replan are what fails: each its own path, one
after the other, and each around all who rest. Their bound is of all groups: the longest way, how far a middle goes, and the time
that all need who pass a narrow place; for the four of them plan_us is per cycle, of all units.

Example: maniple bench path --map maps/rooms.map --planner pibt --units 50,100
         maniple bench path --scene gap-2,maze --planner auto --units 20,100";

/// Where groups go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum GroupScene {
    /// Across a field
    Open,
    /// Through a gap of one tile
    #[value(name = "gap-1")]
    Gap1,
    /// Through a gap of two tiles
    #[value(name = "gap-2")]
    Gap2,
    /// Through a gap of three tiles
    #[value(name = "gap-3")]
    Gap3,
    /// Two groups that meet in a gap of two tiles
    BothWays,
    /// Through a maze
    Maze,
    /// Four groups that change the corners of a field
    Corners,
}

#[derive(Debug, Args)]
pub(crate) struct BenchPath {
    /// Plan on this map: .tmx or .map; without it on the one that --scen names, or on maps/choke.tmx, which is in the program
    #[arg(long, value_name = "FILE")]
    pub(crate) map: Option<PathBuf>,
    /// Take starts and goals from this file of queries, the first ones of it; may be given again. Without it they are random
    #[arg(long, value_name = "FILE.scen")]
    pub(crate) scen: Vec<PathBuf>,
    /// The scenes of groups, for planners that lead groups; without it all
    #[arg(long = "scene", value_name = "LIST", value_delimiter = ',', conflicts_with = "map")]
    pub(crate) scenes: Vec<GroupScene>,
    /// The planners
    #[arg(long = "planner", value_name = "LIST", value_delimiter = ',', default_value = "single,pibt")]
    pub(crate) planners: Vec<String>,
    /// How many units, as many as there are starts at most; without it all queries for single, and 100 for the others
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        value_parser = clap::value_parser!(u32).range(1..=AGENTS_MAX as i64)
    )]
    pub(crate) units: Vec<u32>,
    /// The radius of the units, in tiles
    #[arg(long, value_name = "R", default_value_t = 0.35, value_parser = crate::arguments::positive)]
    pub(crate) radius: f64,
    /// The seed of random starts and goals, and of ties
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub(crate) seed: u64,
    /// How long a plan may take, in seconds of processor time; who has none by then has arrived nowhere
    #[arg(long, value_name = "S", default_value_t = 10.0, value_parser = crate::arguments::positive)]
    pub(crate) seconds: f64,
    /// How long refined makes a plan better, in seconds of processor time
    #[arg(long, value_name = "S", default_value_t = 6.0, value_parser = crate::arguments::positive)]
    pub(crate) refine: f64,
    #[command(flatten)]
    pub(crate) json: JsonFlag,
}
