//! Ways to combine the neighbours' features.

/// How neighbours' features are combined.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
pub enum Aggregation {
    /// Not at all: plain PPO.
    None,
    /// Graph convolution, equation (5).
    Gcn,
    /// Graph attention, equations (6) and (7).
    Gat,
}

impl Aggregation {
    /// Every form.
    pub const ALL: [Self; 3] = [Self::None, Self::Gcn, Self::Gat];

    /// Its name in files and on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Gcn => "gcn",
            Self::Gat => "gat",
        }
    }
}
