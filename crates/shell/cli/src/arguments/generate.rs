//! What a generated map shall be like.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use maniple_tilemap::{Kind, Request};

use crate::output::JsonFlag;

#[derive(Debug, Args)]
pub(crate) struct MapGenerate {
    /// What kind of ground it has
    #[arg(value_name = "KIND", value_parser = kinds())]
    pub(crate) kind: Kind,
    /// The seed: the same one gives the same map
    #[arg(long, value_name = "S")]
    pub(crate) seed: u64,
    /// The map to write: .tmx; or .map, which holds no spawns, patches or half-blocked tiles
    #[arg(long, value_name = "FILE")]
    pub(crate) out: PathBuf,
    /// Width and height in tiles, 16 to 512 each
    #[arg(long, value_name = "WxH", default_value = "64x64", value_parser = size)]
    pub(crate) size: (u32, u32),
    /// How many players have spawns, 0 to 8; with an even number the map is the same after half a turn
    #[arg(long, value_name = "N", default_value_t = 2)]
    pub(crate) players: u32,
    /// Spawns of each player, 1 to 8
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) spawns: u32,
    /// Clusters of patches in all, 0 to 64; the first ones lie beside a spawn of each player
    #[arg(long, value_name = "N", default_value_t = 4)]
    pub(crate) clusters: u32,
    /// Patches of each cluster, 1 to 12
    #[arg(long, value_name = "N", default_value_t = 6)]
    pub(crate) patches: u32,
    /// How much there is of each patch
    #[arg(long, value_name = "N", default_value_t = 1_000)]
    pub(crate) amount: u32,
    /// The radius of the largest unit, in tiles, up to 4: it gets everywhere
    #[arg(long, value_name = "R", default_value_t = 0.5, allow_negative_numbers = true)]
    pub(crate) radius: f64,
    #[command(flatten)]
    pub(crate) json: JsonFlag,
}

impl MapGenerate {
    pub(crate) fn request(&self) -> Request {
        Request {
            kind: self.kind,
            width: self.size.0,
            height: self.size.1,
            players: self.players,
            spawns: self.spawns,
            clusters: self.clusters,
            patches: self.patches,
            amount: self.amount,
            radius: self.radius,
        }
    }
}

fn kinds() -> impl TypedValueParser<Value = Kind> {
    PossibleValuesParser::new(Kind::NAMES).try_map(|name| name.parse::<Kind>())
}

fn size(text: &str) -> Result<(u32, u32), String> {
    let parts = text.split_once('x');
    let numbers = parts.and_then(|(width, height)| width.parse().ok().zip(height.parse().ok()));
    numbers.ok_or_else(|| "a size is width and height in tiles, as in 64x48".to_owned())
}
