//! What a sample tells of what it was drawn from.

use serde::Serialize;

/// The standard normal deviate beyond which lies 2.5 % on either side.
const Z_95: f64 = 1.959_963_984_540_054;

/// Returns the ends of the 95 % interval of a probability, both from 0 to 1, after `hits` in `trials`; all there is
/// without trials.
///
/// With `p = hits / n`, `n` the trials and `z` the deviate of the level, the score interval is
/// `(p + z²/2n ± z √(p(1-p)/n + z²/4n²)) / (1 + z²/n)`: unlike `p ± z √(p(1-p)/n)` it stays within 0 to 1, and has a
/// width at 0 and at 1 (E. B. Wilson, "Probable Inference, the Law of Succession, and Statistical Inference", Journal of
/// the American Statistical Association 22, 1927, pages 209-212).
pub(super) fn wilson(hits: u32, trials: u32) -> (f64, f64) {
    if trials == 0 {
        return (0.0, 1.0);
    }
    let n = f64::from(trials);
    let p = f64::from(hits) / n;
    let z2 = Z_95 * Z_95;
    let centre = p + z2 / (2.0 * n);
    let half = Z_95 * (p * (1.0 - p) / n + z2 / (4.0 * n * n)).sqrt();
    let scale = 1.0 + z2 / n;
    // The ends are 0 and 1 exactly where all or nothing hits; there rounding may not leave a rest.
    let low = if hits == 0 { 0.0 } else { (centre - half) / scale };
    let high = if hits == trials { 1.0 } else { (centre + half) / scale };
    (low, high)
}

/// Mean and standard deviation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Spread {
    /// `None` of an empty sample.
    pub(super) mean: Option<f64>,
    /// With `n - 1` in the denominator; `None` of fewer than two.
    pub(super) deviation: Option<f64>,
}

/// Numbers that come one after the other, by the recurrence of B. P. Welford ("Note on a Method for Calculating
/// Corrected Sums of Squares and Products", Technometrics 4, 1962), which subtracts no nearly equal sums of squares.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sample {
    count: u32,
    mean: f64,
    squares: f64,
}

impl Sample {
    pub(super) fn add(&mut self, number: f64) {
        self.count += 1;
        let off = number - self.mean;
        self.mean += off / f64::from(self.count);
        self.squares += off * (number - self.mean);
    }

    pub(super) fn spread(&self) -> Spread {
        let deviation = || (self.squares / f64::from(self.count - 1)).sqrt();
        Spread { mean: (self.count > 0).then_some(self.mean), deviation: (self.count > 1).then(deviation) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_is_that_of_published_examples() {
        let check = |(hits, trials), (low, high): (f64, f64)| {
            let found = wilson(hits, trials);
            assert!(
                (found.0 - low).abs() < 5e-5 && (found.1 - high).abs() < 5e-5,
                "{hits}/{trials}: {found:?}"
            );
        };
        // R. G. Newcombe, Statistics in Medicine 17, 1998, table I: the score method without correction.
        check((81, 263), (0.2553, 0.3662));
        check((15, 148), (0.0624, 0.1605));
        check((0, 20), (0.0, 0.1611));
        check((1, 29), (0.0061, 0.1718));
        check((20, 20), (0.8389, 1.0));
        check((0, 0), (0.0, 1.0));
    }

    #[test]
    fn mean_and_deviation_are_those_of_two_passes() {
        let numbers = [1e9 + 4.0, 1e9 + 7.0, 1e9 + 13.0, 1e9 + 16.0];
        let mut sample = Sample::default();
        assert_eq!(sample.spread(), Spread { mean: None, deviation: None });
        for number in numbers {
            sample.add(number);
        }
        assert_eq!(sample.spread(), Spread { mean: Some(1e9 + 10.0), deviation: Some(30.0_f64.sqrt()) });
        let mut one = Sample::default();
        one.add(3.0);
        assert_eq!(one.spread(), Spread { mean: Some(3.0), deviation: None });
    }
}
