//! A crowd large enough for several threads has the same bits with any number of them.

use super::march::{Field, March};
use super::scene::Random;

/// Enough for each of seven threads to get a share.
const OBJECTS: u32 = 20_000;

/// Long enough for the memory to be tidied twice.
const CYCLES: u32 = 40;

#[test]
fn a_march_of_thousands_has_the_same_bits_for_any_threads_and_order_of_insertion() {
    let seed = 17;
    println!("seed {seed}");
    let field = Field::boxed(230.0, 300, seed);
    let mut places = field.places(OBJECTS, seed, |_| true);
    let digests = |places: &[_], threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| {
            let mut march = March::new(&field, places, seed);
            let cycle = |_| {
                march.order();
                march.step();
                march.world.digest()
            };
            let digests: Vec<u64> = (0..CYCLES).map(cycle).collect();
            assert_eq!(march.world.overlaps(), []);
            digests
        })
    };
    let expected = digests(&places, 1);
    for threads in [2, 3, 7] {
        assert_eq!(digests(&places, threads), expected, "{threads} threads");
    }
    let mut random = Random(seed);
    for threads in [1, 3] {
        for place in (1..places.len()).rev() {
            places.swap(place, random.below(u32::try_from(place).expect("few objects") + 1) as usize);
        }
        assert_eq!(digests(&places, threads), expected, "shuffled, {threads} threads");
    }
}
