//! The fastest implementation that the target has.

use super::dense::Dense;
use super::finish::Finish;
#[cfg(not(smlad))]
use super::portable as fastest;
#[cfg(smlad)]
use super::smlad as fastest;

impl Dense<'_> {
    /// `out[r] = finish(Σ_c w[r][c]·x[c] + bias[r])` for each row.
    ///
    /// `x` has C int8 values, with a zero behind them if C is odd; `out` has R places. Whoever loads a layer checks
    /// that its parts are of these lengths. Should they not be, the rows that some part lacks are not computed.
    ///
    /// On Cortex-M4 and M7 this is assembly, elsewhere [`portable::apply`](super::portable::apply); both give the same numbers.
    #[inline]
    pub fn apply(&self, x: &[i16], out: &mut [i16], finish: Finish) {
        fastest::apply(self, x, out, finish);
    }
}
