//! Policies on held-out worlds: the rows that `eval` prints and reports show.

use crate::any_actor::AnyActor;
use crate::cli::PolicyArg;
use crate::float_actor::{FloatActor, FloatPolicy, argmax};
use crate::over_link::LinkRow;
use crate::settings::distribution_name;
use covey_env::baselines::{Centroid, Follower, Greedy, Hover, Planner, Random, RememberingPlanner};
use covey_env::oracles::{FlyToSites, evaluate_parked};
use covey_env::policy_seed;
use covey_env::{ActorPolicy, Evaluation, Policy, Scenario, ScenarioError, World, evaluate};
use firmware_core::action::Action;
use firmware_core::actor::{Actor, ActorInput, CellsActor, Mode, QuantisedActor, argmax as int8_argmax};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// A policy that can be measured.
pub enum Subject<'a> {
    /// The on-board actor.
    Int8(&'a Actor<'a>),
    /// The on-board actor that observes cells.
    Int8Cells(&'a CellsActor<'a>),
    /// The trained network in floats.
    Float(&'a FloatActor),
    /// A hand-written policy or an oracle.
    Written(PolicyArg),
}

/// Worlds and manner of a measurement.
#[derive(Clone, Debug)]
pub struct Trial {
    /// Sizes of the worlds.
    pub scenario: Scenario,
    /// Seed of the worlds, and of what the policies draw.
    pub seed: u64,
    /// How many.
    pub worlds: u32,
    /// How actions are taken from logits.
    pub mode: Mode,
}

/// Decisions that a board made.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct BoardFigures {
    /// The board, as `--actor` names it.
    pub actor: String,
    /// How many.
    pub decisions: u64,
    /// In how many this computer gets another feature, other logits or another action.
    pub differences: u64,
}

/// A metric's mean over worlds and the standard error of it.
macro_rules! row {
    ($($metric:ident $error:ident $doc:literal;)*) => {
        /// One row of `eval --json`.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        pub struct EvalRow {
            /// Whose figures.
            pub policy: String,
            /// PoiDistribution of the PoIs.
            pub scenario: String,
            /// UAVs.
            pub uavs: usize,
            /// Held-out worlds.
            pub worlds: u32,
            /// Their seed.
            pub seed: u64,
            /// "sample" or "argmax"; "rule" for policies without logits.
            pub decide: String,
            $(
                #[doc = $doc]
                pub $metric: f64,
                /// Standard error of the mean.
                pub $error: f64,
            )*
            /// What decided, when it was not this computer.
            #[serde(flatten)]
            pub board: Option<BoardFigures>,
            /// The link and what it did, when the UAVs flew over one.
            #[serde(flatten)]
            pub link: Option<LinkRow>,
        }

        impl EvalRow {
            /// The row of an evaluation; `policy` and `decide` go into it.
            #[must_use]
            pub fn new(policy: &str, trial: &Trial, decide: &str, evaluation: &Evaluation) -> Self {
                let (mean, se) = (evaluation.mean(), evaluation.standard_error());
                Self {
                    policy: policy.to_owned(),
                    scenario: distribution_name(trial.scenario.distribution).to_owned(),
                    uavs: trial.scenario.uavs,
                    worlds: trial.worlds,
                    seed: trial.seed,
                    decide: decide.to_owned(),
                    $($metric: mean.$metric, $error: se.$metric,)*
                    board: None,
                    link: None,
                }
            }

            /// Means and standard errors by name.
            #[must_use]
            pub fn metrics(&self) -> Vec<(&'static str, f64, f64)> {
                vec![$((stringify!($metric), self.$metric, self.$error),)*]
            }
        }
    };
}

row! {
    coverage coverage_se "Coverage index.";
    coverage_last coverage_last_se "Coverage after the last step.";
    energy energy_se "Energy index.";
    individual individual_se "PoIs that a UAV alone covers in its group.";
    group group_se "PoIs that its group covers.";
    reward reward_se "Episodic reward.";
    fairness fairness_se "Jain's index of the time each PoI was covered.";
}

/// Name of a mode in rows.
#[must_use]
pub const fn mode_name(mode: Mode) -> &'static str {
    match mode {
        Mode::Sample => "sample",
        Mode::Argmax => "argmax",
    }
}

impl PolicyArg {
    /// Its name in rows.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Random => "random",
            Self::Hover => "hover",
            Self::Greedy => "greedy",
            Self::Centroid => "centroid",
            Self::Follower => "follower",
            Self::Planner => "planner",
            Self::Remembering => "remembering",
            Self::Oracle => "oracle",
            Self::Parked => "parked",
        }
    }
}

impl<'a> Subject<'a> {
    /// The on-board actor of either form.
    #[must_use]
    pub const fn of(actor: &'a AnyActor<'a>) -> Self {
        match actor {
            AnyActor::Compact(actor) => Self::Int8(actor),
            AnyActor::Cells(actor) => Self::Int8Cells(actor),
        }
    }

    fn decide(&self, mode: Mode) -> &'static str {
        match self {
            Self::Written(_) => "rule",
            _ => mode_name(mode),
        }
    }

    /// Measures it; `name` goes into the row.
    ///
    /// # Errors
    /// When the scenario cannot be built.
    pub fn measure(&self, name: &str, trial: &Trial) -> Result<EvalRow, ScenarioError> {
        let evaluation = self.evaluate(trial)?;
        Ok(EvalRow::new(name, trial, self.decide(trial.mode), &evaluation))
    }

    fn evaluate(&self, trial: &Trial) -> Result<Evaluation, ScenarioError> {
        let (scenario, seed, worlds) = (&trial.scenario, trial.seed, u64::from(trial.worlds));
        match self {
            Self::Written(PolicyArg::Parked) => evaluate_parked(scenario, seed, worlds),
            Self::Float(actor) => {
                let net = actor.network();
                evaluate(scenario, seed, worlds, |i| FloatPolicy::new(actor, &net, policy_seed(seed, i), trial.mode))
            }
            _ => evaluate(scenario, seed, worlds, |i| self.policy(trial, i)),
        }
    }

    /// A policy object for held-out world `index`. Parked UAVs hover: their sites are set
    /// by the measurement.
    fn policy(&self, trial: &Trial, index: u64) -> Box<dyn Policy + '_> {
        match self {
            Self::Int8(actor) => Box::new(ActorPolicy::new(**actor, policy_seed(trial.seed, index), trial.mode)),
            Self::Int8Cells(actor) => Box::new(ActorPolicy::new(**actor, policy_seed(trial.seed, index), trial.mode)),
            Self::Written(PolicyArg::Random) => Box::new(Random::new(trial.seed, index)),
            Self::Written(PolicyArg::Greedy) => Box::new(Greedy::new()),
            Self::Written(PolicyArg::Centroid) => Box::new(Centroid::new(trial.seed, index)),
            Self::Written(PolicyArg::Follower) => Box::new(Follower::new(policy_seed(trial.seed, index))),
            Self::Written(PolicyArg::Planner) => Box::new(Planner::new()),
            Self::Written(PolicyArg::Remembering) => Box::new(RememberingPlanner::new()),
            Self::Written(PolicyArg::Oracle) => Box::new(FlyToSites::new()),
            Self::Written(PolicyArg::Hover | PolicyArg::Parked) | Self::Float(_) => Box::new(Hover),
        }
    }
}

/// Decisions in which the int8 actor's greatest logit is that of the float policy in the
/// very same situation, and all decisions: the int8 actor flies the trial's worlds.
///
/// # Errors
/// When the scenario cannot be built.
pub fn agreement<O: ActorInput>(
    int8: &QuantisedActor<'_, O>,
    float: &FloatActor,
    trial: &Trial,
) -> Result<(u64, u64), ScenarioError> {
    let fresh = World::new(&trial.scenario)?;
    let net = float.network();
    let flown = (0..u64::from(trial.worlds)).into_par_iter().map(|index| {
        let mut world = fresh.clone();
        world.reset(trial.seed, index);
        let seed = policy_seed(trial.seed, index);
        let mut own = ActorPolicy::new(*int8, seed, trial.mode);
        let mut other = FloatPolicy::new(float, &net, seed, trial.mode);
        let mut actions = vec![Action::COAST; trial.scenario.uavs];
        let mut agreeing = 0;
        while !world.done() {
            own.observe(&world);
            let logits = other.forward(&world).logits();
            for (i, action) in actions.iter_mut().enumerate() {
                let mine = own.logits(i);
                agreeing += u64::from(int8_argmax(&mine) == argmax(logits.row(i)));
                *action = own.choose(&mine, i, world.steps_done());
            }
            world.step(&actions);
        }
        (agreeing, u64::from(trial.scenario.steps) * trial.scenario.uavs as u64)
    });
    Ok(flown.reduce(|| (0, 0), |a, b| (a.0 + b.0, a.1 + b.1)))
}

/// A table of rows for people, with a column for links where there are any.
#[must_use]
pub fn table(rows: &[EvalRow]) -> String {
    let link = if rows.iter().any(|r| r.link.is_some()) { "  link" } else { "" };
    let mut out = format!(
        "{:<12} {:<10} {:>5}  {:<7} {:>14} {:>8} {:>7} {:>11} {:>7} {:>12}{link}\n",
        "policy", "scenario", "uavs", "decide", "coverage", "last", "energy", "individual", "group", "reward"
    );
    for r in rows {
        let link = r.link.as_ref().map_or(String::new(), |l| format!("  {}", l.link));
        out += &format!(
            "{:<12} {:<10} {:>5}  {:<7} {:>6.4} ±{:.4} {:>9.4} {:>7.3} {:>11.2} {:>7.2} {:>6.1} ±{:<4.1}{link}\n",
            r.policy,
            r.scenario,
            r.uavs,
            r.decide,
            r.coverage,
            r.coverage_se,
            r.coverage_last,
            r.energy,
            r.individual,
            r.group,
            r.reward,
            r.reward_se
        );
    }
    out
}
