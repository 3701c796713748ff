//! Processor in the loop (PIL): a board decides for all UAVs of a world over the PIL protocol, and
//! every decision of it is compared with this computer's.
//!
//! One board plays all UAVs of a world in turn. It is told each UAV's identity, hears the
//! beacons of all UAVs in range, observes, encodes, hears their features and decides; the
//! world then moves by the board's actions. The features it hears are this computer's, and
//! every feature that it makes is compared with the one this computer made of the same UAV:
//! without a difference the features heard are the board's own, to the bit.

use super::config::EvalConfig;
use covey_env::policy_seed;
use covey_env::{ActorPolicy, EpisodeMetrics, World};
use covey_pil::{Client, Observed, PilError, UavStep};
use firmware_core::action::Action;
use firmware_core::actor::{Actor, Aggregation, Logits, Mode};
use firmware_core::geometry::{COMMUNICATION_RANGE_U, OBSERVATION_RANGE_U, State, Vec2};
use firmware_core::message::{Beacon, FeatureMessage, Header, MAX_LEN, Message};
use firmware_core::neighbour_table::{DEFAULT_STEP_MS, Moment};
use firmware_core::pil::{Decided, Setup};
use std::fmt;
use std::io::{Read, Write};

/// What is added to a range, u, so that rounding to ticks leaves nobody out; the board keeps
/// to the range itself.
const MARGIN_U: f32 = 0.01;

/// The part of a decision in which board and computer differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Degree, tie-breaker or feature message.
    Feature,
    /// Logits, or the number of features that counted.
    Logits,
    /// The action.
    Action,
}

/// The first decision in which board and computer differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Number of the world.
    pub world: u64,
    /// Step of the episode, from 0.
    pub step: u32,
    /// Id of the UAV.
    pub uav: u16,
    /// What differs first.
    pub part: Part,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let part = match self.part {
            Part::Feature => "the feature",
            Part::Logits => "the logits",
            Part::Action => "the action",
        };
        write!(f, "{part} of UAV {} in step {} of world {}", self.uav, self.step, self.world)
    }
}

/// An episode that a board flew.
#[derive(Clone, Debug, PartialEq)]
pub struct PilEpisode {
    /// Metrics of the episode.
    pub metrics: EpisodeMetrics,
    /// Decisions that the board made.
    pub decisions: u64,
    /// In how many of them this computer decides otherwise.
    pub differences: u64,
    /// The first of them.
    pub first: Option<Difference>,
}

/// Flies world `index` of the evaluation with a board that holds `actor` deciding, over a line that
/// holds back what the board has not read (see [`Client::fly_step`]).
///
/// # Errors
/// The board does not answer, or refuses.
pub fn fly_episode<S: Read + Write>(
    board: &mut Client<S>,
    actor: &Actor<'_>,
    config: &EvalConfig,
    world: &mut World,
    index: u64,
) -> Result<PilEpisode, PilError> {
    world.reset(config.seed, index);
    let seed = policy_seed(config.seed, index);
    let mut policy = ActorPolicy::new(*actor, seed, config.mode);
    let mut actions = vec![Action::COAST; config.scenario.uavs];
    let (mut decisions, mut differences, mut first) = (0, 0, None);
    while !world.done() {
        policy.observe(world);
        let broadcasts = Broadcasts::of(world, &policy, actor, seed);
        for (i, action) in actions.iter_mut().enumerate() {
            let (observed, decided) = broadcasts.turn(board, world, i, config.mode)?;
            let logits = policy.logits(i);
            let chosen = policy.choose(&logits, i, broadcasts.now.step);
            if let Some(part) = broadcasts.difference(i, &logits, chosen, &observed, &decided) {
                differences += 1;
                first.get_or_insert(Difference { world: index, step: broadcasts.now.step, uav: i as u16, part });
            }
            decisions += 1;
            *action = Action::new(decided.action).ok_or(PilError::Unexpected { request: "decide" })?;
        }
        world.step(&actions);
    }
    Ok(PilEpisode { metrics: world.metrics(), decisions, differences, first })
}

/// What all UAVs of a world broadcast at a step, as this computer computes it.
struct Broadcasts {
    now: Moment,
    seed: u64,
    half_side: i32,
    states: Vec<State>,
    ties: Vec<i8>,
    degrees: Vec<u8>,
    /// Neighbours whose features count, one number a UAV.
    counting: Vec<u8>,
    /// None when the policy broadcasts none.
    features: Vec<Option<FeatureMessage>>,
}

impl Broadcasts {
    fn of(world: &World, policy: &ActorPolicy<'_>, actor: &Actor<'_>, seed: u64) -> Self {
        let step = world.steps_done();
        let ids = 0..world.scenario().uavs;
        let neighbourhoods = policy.neighbourhoods();
        let graph = actor.aggregation() != Aggregation::None;
        let feature = |i: usize| {
            FeatureMessage::from_actor(header(i, step), neighbourhoods[i].count + 1, actor, &policy.features()[i])
        };
        Self {
            now: Moment { step, time_ms: step.wrapping_mul(u32::from(DEFAULT_STEP_MS)) },
            seed,
            half_side: world.scenario().half_side_ticks(),
            states: ids.clone().map(|i| state(world, i)).collect(),
            ties: ids.clone().map(|i| actor.tie_breaker(seed, i as u16, step)).collect(),
            degrees: neighbourhoods.iter().map(|n| n.count + 1).collect(),
            counting: neighbourhoods.iter().map(|n| if graph { n.count } else { 0 }).collect(),
            features: ids.map(feature).collect(),
        }
    }

    /// The board as UAV `i`.
    fn turn<S: Read + Write>(
        &self,
        board: &mut Client<S>,
        world: &World,
        i: usize,
        mode: Mode,
    ) -> Result<(Observed, Decided), PilError> {
        let (x, y) = world.position(i);
        let near = world.uavs_within(x, y, COMMUNICATION_RANGE_U as f32 + MARGIN_U).filter(|&j| j != i);
        let (beacons, features): (Vec<_>, Vec<_>) =
            near.map(|j| (self.beacon(j), self.features[j].clone().map(Message::Feature))).unzip();
        let features: Vec<_> = features.into_iter().flatten().collect();
        let in_sight = world.pois_within(x, y, OBSERVATION_RANGE_U as f32 + MARGIN_U);
        let pois: Vec<_> = in_sight.map(|p| Vec2::from_u(world.poi_x()[p], world.poi_y()[p])).collect();
        let setup = Setup {
            id: i as u16,
            seed: self.seed,
            argmax: mode == Mode::Argmax,
            step_ms: DEFAULT_STEP_MS,
            half_side: self.half_side,
        };
        let (now, own) = (self.now, self.states[i]);
        board.fly_step(&UavStep { setup, now, own, beacons: &beacons, pois: &pois, features: &features })
    }

    fn beacon(&self, i: usize) -> Message {
        Message::Beacon(Beacon::new(header(i, self.now.step), self.now.time_ms, self.states[i], self.ties[i]))
    }

    /// Where the board's decision as UAV `i` first departs from this computer's.
    fn difference(
        &self,
        i: usize,
        logits: &Logits,
        action: Action,
        observed: &Observed,
        decided: &Decided,
    ) -> Option<Part> {
        let message = self.features[i].clone().map(Message::Feature);
        let message = message.map_or_else(Vec::new, |m| m.encode(&mut [0; MAX_LEN]).to_vec());
        if (observed.degree, observed.tie) != (self.degrees[i], self.ties[i]) || observed.message != message {
            return Some(Part::Feature);
        }
        if decided.logits != *logits || decided.features != self.counting[i] {
            return Some(Part::Logits);
        }
        (decided.action != action.index()).then_some(Part::Action)
    }
}

const fn header(i: usize, step: u32) -> Header {
    Header { id: i as u16, sequence: step as u16, step }
}

fn state(world: &World, i: usize) -> State {
    let ((x, y), (vx, vy)) = (world.position(i), world.velocity(i));
    State { position: Vec2::from_u(x, y), velocity: Vec2::from_u(vx, vy) }
}
