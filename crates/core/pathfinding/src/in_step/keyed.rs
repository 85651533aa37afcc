//! Ties, decided by a number that depends on nothing but what it is for.

/// Returns 64 bits that follow from a seed and two numbers: the finishing steps of splitmix64 (Steele, Lea and Flood, *Fast
/// Splittable Pseudorandom Number Generators*, 2014), once for each of them.
pub(crate) fn keyed(seed: u64, first: u64, second: u64) -> u64 {
    mixed(mixed(seed ^ first.wrapping_mul(0x9e37_79b9_7f4a_7c15)) ^ second)
}

fn mixed(bits: u64) -> u64 {
    let bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    bits ^ (bits >> 31)
}
