//! Features of neighbours as the graph layer takes them.

use super::neighbourhood::Neighbourhood;
use firmware_core::actor::{Feature, NeighbourFeature};

/// The features that UAV `i` receives from its neighbours when every message arrives, nearest neighbour first.
/// `features` and `neighbourhoods` are those of all UAVs; of each feature the first `width` numbers are sent.
///
/// # Panics
/// When there is no UAV `i`, a neighbour has no feature, or features have fewer than `width` numbers.
pub fn neighbour_features<'f>(
    features: &'f [Feature],
    width: usize,
    neighbourhoods: &'f [Neighbourhood],
    i: usize,
) -> impl Iterator<Item = NeighbourFeature<'f>> {
    neighbourhoods[i].as_slice().iter().map(move |&j| {
        let (feature, neighbourhood) = (&features[usize::from(j)], &neighbourhoods[usize::from(j)]);
        NeighbourFeature {
            values: &feature.values[..width],
            degree: neighbourhood.degree(),
            attention_source: feature.attention_source,
        }
    })
}
