//! The UAV on the board: its actor, its neighbours and the step it is in.
//!
//! Each request has a function of its own on the stack, so that a board needs room for the
//! deepest, not for their sum: hence `inline(never)`.

use super::record::{ActorInfo, Decided, Fault, Hear, Observe, Observed, Refusal, Reply, Report, Setup};
use super::{MAX_CASES, MAX_POIS, POI_BYTES};
use crate::actor::{Actor, Feature, Fingerprint, MAX_FEATURE, Mode};
use crate::geometry::Vec2;
use crate::message::{self, Header, MAX_LEN, Message};
use crate::neighbour_table::{DEFAULT_STEP_MS, Moment, NeighbourTable, PolicyId};
use crate::observation::{Neighbours, Observation, Scene, observe};

pub(super) struct Node<'a> {
    actor: Result<Actor<'a>, Fault>,
    setup: Option<Setup>,
    table: NeighbourTable,
    /// The neighbours in view and the own feature of the step observed last.
    view: Neighbours,
    own: Feature,
    observed: Option<u32>,
    decisions: u32,
    fingerprint: Fingerprint,
    signed: u32,
    /// The own feature message.
    message: [u8; MAX_LEN],
}

impl<'a> Node<'a> {
    pub(super) const fn new() -> Self {
        Self {
            actor: Err(Fault::NotLoaded),
            setup: None,
            table: NeighbourTable::new(0, PolicyId { hash: 0, width: 0 }, DEFAULT_STEP_MS),
            view: Neighbours::new(),
            own: Feature { values: [0; MAX_FEATURE], attention_destination: 0, attention_source: 0 },
            observed: None,
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
        self.setup = None;
        self.observed = None;
        self.actor = Actor::load(file).map_err(Fault::from);
    }

    /// A self-test that fails takes the actor away for good.
    #[inline(never)]
    pub(super) fn self_test(&mut self) {
        if let Ok(actor) = &self.actor
            && let Err(e) = actor.self_test()
        {
            self.actor = Err(Fault::SelfTest(e.vector as u8));
        }
    }

    pub(super) fn report(&self) -> Report<'static> {
        let actor = self.actor.as_ref().map_err(|&fault| fault).map(|actor| ActorInfo {
            content_hash: actor.content_hash(),
            observation: crate::observation::ID,
            aggregation: actor.aggregation(),
            width: PolicyId::of(actor).width,
            tie_period: actor.tie_period(),
        });
        Report { software: env!("CARGO_PKG_VERSION"), actor }
    }

    /// Everything of a [`super::Status`] but the counters of the line.
    pub(super) fn status(&self) -> super::Status {
        super::Status {
            started: self.setup.is_some(),
            observed: self.observed,
            kept: self.table.len() as u8,
            decisions: self.decisions,
            counters: super::Counters::default(),
        }
    }

    pub(super) fn hello(&mut self, setup: Setup) {
        if let Ok(actor) = &self.actor {
            self.table.reset(setup.id, PolicyId::of(actor), setup.step_ms);
            self.observed = None;
            self.setup = Some(setup);
        }
    }

    #[inline(never)]
    pub(super) fn hear(&mut self, heard: &Hear<'_>) -> Result<Reply<'static>, Refusal> {
        ready(&self.actor, &self.setup)?;
        let message = Message::decode(heard.message).map_err(|_| Refusal::Message)?;
        let [x, y] = heard.position;
        let answer = self.table.hear(&message, Vec2::from_ticks(x, y), heard.now);
        Ok(Reply::Heard { answer, kept: self.table.len() as u8 })
    }

    #[inline(never)]
    pub(super) fn observe(&mut self, request: &Observe<'_>) -> Result<Reply<'_>, Refusal> {
        let (actor, setup) = ready(&self.actor, &self.setup)?;
        if !request.pois.len().is_multiple_of(POI_BYTES) || request.pois.len() > MAX_POIS * POI_BYTES {
            return Err(Refusal::Pois);
        }
        let (own, Moment { step, .. }) = (request.own(), request.now);
        self.table.view(own.position, request.now, &mut self.view);
        let tie = actor.tie_breaker(setup.seed, setup.id, step);
        let scene = Scene { id: setup.id, own, tie, half_side: setup.half_side, neighbours: &self.view };
        self.own = actor.encode(&look(&scene, request.pois));
        self.observed = Some(step);
        let degree = self.degree();
        let header = Header { id: setup.id, sequence: step as u16, step };
        let message: &[u8] = match message::Feature::of(header, degree, actor, &self.own) {
            Some(feature) => Message::Feature(feature).encode(&mut self.message),
            None => &[],
        };
        Ok(Reply::Observed(Observed { step, degree, tie, message }))
    }

    #[inline(never)]
    pub(super) fn decide(&mut self, step: u32) -> Result<Reply<'static>, Refusal> {
        let (actor, setup) = ready(&self.actor, &self.setup)?;
        if self.observed != Some(step) {
            return Err(Refusal::NotObserved);
        }
        let features = self.table.features(&self.view, step).map(|(_, feature)| feature);
        let count = features.clone().count() as u8;
        let logits = actor.logits(&self.own, self.degree(), features);
        let mode = if setup.argmax { Mode::Argmax } else { Mode::Sample };
        let action = actor.choose(&logits, mode, setup.seed, setup.id, step).index();
        self.decisions = self.decisions.wrapping_add(1);
        Ok(Reply::Decided(Decided { step, action, features: count, logits }))
    }

    #[inline(never)]
    pub(super) fn sign(&mut self, from: u32, cases: u16) -> Result<Reply<'static>, Refusal> {
        let actor = self.actor.as_ref().map_err(|&fault| Refusal::Fault(fault))?;
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

    /// Neighbours in view and the UAV itself.
    fn degree(&self) -> u8 {
        self.view.as_slice().len() as u8 + 1
    }
}

/// The observation of a scene; what it takes to build is off the stack before it is encoded.
#[inline(never)]
fn look(scene: &Scene<'_>, pois: &[u8]) -> Observation {
    observe(scene, pois.chunks_exact(POI_BYTES).map(|p| scene.own.position + offset(p)))
}

/// By reference: an actor is a few hundred bytes, much for a board's stack.
fn ready<'n, 'a>(
    actor: &'n Result<Actor<'a>, Fault>,
    setup: &'n Option<Setup>,
) -> Result<(&'n Actor<'a>, &'n Setup), Refusal> {
    let actor = actor.as_ref().map_err(|&fault| Refusal::Fault(fault))?;
    Ok((actor, setup.as_ref().ok_or(Refusal::NotStarted)?))
}

fn offset(poi: &[u8]) -> Vec2 {
    match *poi {
        [x0, x1, y0, y1] => {
            Vec2 { x: i32::from(i16::from_le_bytes([x0, x1])), y: i32::from(i16::from_le_bytes([y0, y1])) }
        }
        _ => Vec2::default(),
    }
}
