//! Ways to combine the neighbours' features.

/// How neighbours' features are combined.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
pub enum Aggregation {
    /// Not at all: plain PPO.
    None,
    /// Graph convolution, equation (5).
    Gcn,
    /// Graph attention, equations (6) and (7), whose score splits into a half of the receiver
    /// and one of the sender (Veličković et al. 2018).
    Gat,
    /// Graph attention whose score the receiver takes of both features together, the form of
    /// Brody et al. 2022: `aᵀ LeakyReLU(W_l h_i + W_r h_j)`.
    GatV2,
    /// The mean of the neighbours' features, without the UAV's own (`GraphSAGE`, Hamilton et al.
    /// 2017).
    Sage,
}

impl Aggregation {
    /// Every form.
    pub const ALL: [Self; 5] = [Self::None, Self::Gcn, Self::Gat, Self::GatV2, Self::Sage];

    /// Its name in files and on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Gcn => "gcn",
            Self::Gat => "gat",
            Self::GatV2 => "gatv2",
            Self::Sage => "sage",
        }
    }
}
