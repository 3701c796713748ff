//! The graph that the actor's graph layer aggregates over.

use firmware_core::observation::MAX_NEIGHBOURS;

/// The neighbours of one UAV that its graph layer aggregates over, without the UAV itself: at most [`MAX_NEIGHBOURS`],
/// the nearest ones where more are in communication range.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Neighbourhood {
    /// Number of neighbours.
    pub count: u8,
    /// Their ids, nearest first; zeros beyond `count`.
    pub ids: [u16; MAX_NEIGHBOURS],
}

impl Neighbourhood {
    /// Ids of the neighbours, nearest first.
    #[must_use]
    pub fn as_slice(&self) -> &[u16] {
        &self.ids[..usize::from(self.count)]
    }

    /// Number of neighbours with the UAV itself, 1 to [`MAX_NEIGHBOURS`] + 1: the degree that it sends with its
    /// feature.
    #[must_use]
    pub const fn degree(&self) -> u8 {
        self.count + 1
    }
}

/// From ids, nearest first; those beyond [`MAX_NEIGHBOURS`] are dropped.
impl FromIterator<u16> for Neighbourhood {
    fn from_iter<I: IntoIterator<Item = u16>>(ids: I) -> Self {
        let mut neighbourhood = Self::default();
        for (place, id) in neighbourhood.ids.iter_mut().zip(ids) {
            *place = id;
            neighbourhood.count += 1;
        }
        neighbourhood
    }
}

/// Panics when an observer was not given one observation and one neighbourhood for each UAV to write to.
pub(crate) fn assert_one_each<O>(observations: &[O], neighbourhoods: &[Neighbourhood], uavs: usize) {
    assert!(
        observations.len() == uavs && neighbourhoods.len() == uavs,
        "observe: {} observations and {} neighbourhoods for {uavs} UAVs",
        observations.len(),
        neighbourhoods.len()
    );
}
