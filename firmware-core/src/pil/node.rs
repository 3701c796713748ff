//! The UAV on the board: its actor, its neighbours and the step it is in.
//!
//! Each request has a function of its own on the stack, so that a board needs room for the
//! deepest, not for their sum: hence `inline(never)`.

use super::error::{ActorError, RequestError};
use super::limits::{MAX_CASES, MAX_POIS, POI_BYTES};
use super::reply::{ActorInfo, Decided, Observed, Reply, Report};
use super::request::{Hear, Observe, Setup};
use super::status::{Counters, Status};
use crate::actor::{Actor, Fingerprint, Mode, PolicyId};
use crate::agent::{Agent, AgentSettings};
use crate::geometry::{State, Vec2};
use crate::message::{MAX_LEN, Message};
use crate::neighbour_table::{DEFAULT_STEP_MS, Moment};
use crate::observation::Observation;

/// The agent's settings until a host says whom the board flies for.
const NOBODY: AgentSettings = AgentSettings {
    id: 0,
    policy: PolicyId { hash: 0, width: 0 },
    tie_period: 0,
    policy_seed: 0,
    mode: Mode::Sample,
    step_ms: DEFAULT_STEP_MS,
    half_side: 0,
};

pub(super) struct Node<'a> {
    actor: Result<Actor<'a>, ActorError>,
    agent: Agent,
    /// Whether the agent was set up.
    started: bool,
    decisions: u32,
    fingerprint: Fingerprint,
    signed: u32,
    /// The own feature message.
    message: [u8; MAX_LEN],
}

impl<'a> Node<'a> {
    pub(super) const fn new() -> Self {
        Self {
            actor: Err(ActorError::NotLoaded),
            agent: Agent::new(NOBODY),
            started: false,
            decisions: 0,
            fingerprint: Fingerprint::new(),
            signed: 0,
            message: [0; MAX_LEN],
        }
    }

    pub(super) fn load(&mut self, file: &'a [u8]) {
        self.read(file);
        self.self_test();
    }

    #[inline(never)]
    fn read(&mut self, file: &'a [u8]) {
        self.started = false;
        self.agent.reset(NOBODY);
        self.actor = Actor::load(file).map_err(ActorError::from);
    }

    /// A self-test that fails takes the actor away for good.
    #[inline(never)]
    pub(super) fn self_test(&mut self) {
        if let Ok(actor) = &self.actor
            && let Err(e) = actor.self_test()
        {
            self.actor = Err(ActorError::SelfTest(e.vector as u8));
        }
    }

    pub(super) fn report(&self) -> Report<'static> {
        let actor = self.actor.as_ref().map_err(|&error| error).map(|actor| ActorInfo {
            content_hash: actor.content_hash(),
            observation: crate::observation::ID,
            aggregation: actor.aggregation(),
            width: actor.policy_id().width,
            tie_period: actor.tie_period(),
        });
        Report { software: env!("CARGO_PKG_VERSION"), actor }
    }

    /// Everything of a [`Status`] but the counters of the line.
    pub(super) fn status(&self) -> Status {
        Status {
            started: self.started,
            observed: self.agent.observed_step(),
            kept: self.agent.known() as u8,
            decisions: self.decisions,
            counters: Counters::default(),
        }
    }

    #[inline(never)]
    pub(super) fn hello(&mut self, setup: Setup) {
        if let Ok(actor) = &self.actor {
            self.agent.reset(AgentSettings {
                mode: if setup.argmax { Mode::Argmax } else { Mode::Sample },
                step_ms: setup.step_ms,
                half_side: setup.half_side,
                ..AgentSettings::new(actor, setup.id, setup.seed)
            });
            self.started = true;
        }
    }

    #[inline(never)]
    pub(super) fn hear(&mut self, heard: &Hear<'_>) -> Result<Reply<'static>, RequestError> {
        ready(&self.actor, self.started)?;
        let message = Message::decode(heard.message).map_err(|_| RequestError::Message)?;
        let [x, y] = heard.position;
        let outcome = self.agent.hear(&message, Vec2::from_ticks(x, y), heard.now);
        Ok(Reply::Heard { outcome, kept: self.agent.known() as u8 })
    }

    #[inline(never)]
    pub(super) fn observe(&mut self, request: &Observe<'_>) -> Result<Reply<'_>, RequestError> {
        let actor = ready(&self.actor, self.started)?;
        if !request.pois.len().is_multiple_of(POI_BYTES) || request.pois.len() > MAX_POIS * POI_BYTES {
            return Err(RequestError::Pois);
        }
        let Moment { step, .. } = request.now;
        let observation = observe(&mut self.agent, request.now, request.own(), request.pois);
        // An answer that got lost is asked for again: the number belongs to the step.
        let sequence = step as u16;
        let message = encode(&mut self.agent, actor, &observation, sequence, &mut self.message);
        Ok(Reply::Observed(Observed { step, degree: self.agent.degree(), tie: self.agent.tie_breaker(step), message }))
    }

    #[inline(never)]
    pub(super) fn decide(&mut self, step: u32) -> Result<Reply<'static>, RequestError> {
        let actor = ready(&self.actor, self.started)?;
        if self.agent.observed_step() != Some(step) {
            return Err(RequestError::NotObserved);
        }
        let decision = self.agent.decide(actor).map_err(|_| RequestError::NotObserved)?;
        self.decisions = self.decisions.wrapping_add(1);
        let (action, features, logits) = (decision.action.index(), decision.features, decision.logits);
        Ok(Reply::Decided(Decided { step, action, features, logits }))
    }

    #[inline(never)]
    pub(super) fn sign(&mut self, from: u32, cases: u16) -> Result<Reply<'static>, RequestError> {
        let actor = self.actor.as_ref().map_err(|&error| RequestError::Actor(error))?;
        if from == 0 {
            (self.fingerprint, self.signed) = (Fingerprint::new(), 0);
        }
        if from == self.signed {
            for _ in 0..cases.min(MAX_CASES) {
                self.fingerprint.add_case(actor);
                self.signed = self.signed.wrapping_add(1);
            }
        }
        Ok(Reply::Signature { cases: self.signed, value: self.fingerprint.value() })
    }
}

/// The agent's observation; what it takes to build is off the stack before it is encoded.
#[inline(never)]
fn observe(agent: &mut Agent, now: Moment, own: State, pois: &[u8]) -> Observation {
    agent.observe(now, own, pois.chunks_exact(POI_BYTES).map(|p| own.position + offset(p)))
}

/// Encodes what the agent observed last, and writes the feature message, if there is one. The
/// features are off the stack while the observation is built.
#[inline(never)]
fn encode<'m>(
    agent: &mut Agent,
    actor: &Actor<'_>,
    observation: &Observation,
    sequence: u16,
    message: &'m mut [u8; MAX_LEN],
) -> &'m [u8] {
    // The agent was set up for this actor and has observed, so this does not fail.
    match agent.encode(actor, observation, sequence).unwrap_or(None) {
        Some(feature) => Message::Feature(feature).encode(message),
        None => &[],
    }
}

/// By reference: an actor is a few hundred bytes, much for a board's stack.
fn ready<'n, 'a>(actor: &'n Result<Actor<'a>, ActorError>, started: bool) -> Result<&'n Actor<'a>, RequestError> {
    let actor = actor.as_ref().map_err(|&error| RequestError::Actor(error))?;
    if started { Ok(actor) } else { Err(RequestError::NotStarted) }
}

fn offset(poi: &[u8]) -> Vec2 {
    match *poi {
        [x0, x1, y0, y1] => {
            Vec2 { x: i32::from(i16::from_le_bytes([x0, x1])), y: i32::from(i16::from_le_bytes([y0, y1])) }
        }
        _ => Vec2::default(),
    }
}
