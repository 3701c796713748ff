//! The metrics that the paper's figures show.

/// The curves of figures 5 to 10, and the metrics of figures 11 to 14.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Metric {
    /// Episodic reward.
    Reward,
    /// Coverage index.
    Coverage,
    /// Energy index.
    Energy,
    /// Clipped surrogate, negated; not known of flights.
    PolicyLoss,
    /// PoIs a UAV alone covers in its group.
    Individual,
    /// PoIs its group covers.
    Group,
}

impl Metric {
    /// In sentences and tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Reward => "reward",
            Self::Coverage => "coverage",
            Self::Energy => "energy",
            Self::PolicyLoss => "policy loss",
            Self::Individual => "individual",
            Self::Group => "group",
        }
    }

    /// Title and label of the value axis.
    #[must_use]
    pub const fn labels(self) -> (&'static str, &'static str) {
        match self {
            Self::Reward => ("Episodic reward", "reward"),
            Self::Coverage => ("Coverage index", "share of PoIs"),
            Self::Energy => ("Energy index", "0.5 hovering, 1 full speed"),
            Self::PolicyLoss => ("Policy loss", "clipped surrogate"),
            Self::Individual => ("Individual covered PoIs", "PoIs a UAV"),
            Self::Group => ("Group covered PoIs", "PoIs a group"),
        }
    }

    /// Decimals in tables.
    #[must_use]
    pub const fn decimals(self) -> usize {
        match self {
            Self::Reward => 0,
            Self::Coverage | Self::Energy => 3,
            Self::PolicyLoss => 4,
            Self::Individual | Self::Group => 2,
        }
    }
}
