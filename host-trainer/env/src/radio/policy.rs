//! A swarm that flies by what its radio brings.

use super::figures::LinkFigures;
use super::model::Radio;
use super::settings::{LinkError, LinkSettings};
use crate::policy::Policy;
use crate::world::World;
use firmware_core::action::Action;
use firmware_core::actor::{Actor, Feature, Logits, Mode};
use firmware_core::geometry::{COMMUNICATION_RANGE_U, OBSERVATION_RANGE_U, State, TICKS_PER_U, Vec2};
use firmware_core::message::{self, Beacon, Header, MAX_LEN, Message};
use firmware_core::neighbour_table::{DEFAULT_STEP_MS, Moment, NeighbourTable, Policy as TablePolicy};
use firmware_core::observation::{LEN, Neighbours, Observation, Scene, observe};

/// When a UAV looks at its neighbours, encodes and sends its feature: ms after the step began,
/// when its beacon went out.
pub const ENCODE_MS: u64 = 400;
/// When it decides, ms after the step began.
pub const DECIDE_MS: u64 = 800;
const STEP_MS: u64 = DEFAULT_STEP_MS as u64;
/// What is added to a range, u, so that rounding to ticks leaves nobody out.
const MARGIN_U: f32 = 0.01;

/// Flies all UAVs of a world with one actor, over a link.
///
/// Each UAV has a neighbour table of its own and knows the others only by the bytes that the
/// link brings it, in the order of a step on the air: beacons go out as the step begins; what
/// has arrived [`ENCODE_MS`] later makes the observation, and features go out; what has arrived
/// by [`DECIDE_MS`] makes the decision. What comes later is there in the next step. Ages are
/// measured from the beginning of the step, where the state in the beacon is from.
///
/// Over a perfect link that reaches 34 u or farther it is [`crate::ActorPolicy`], to the bit.
#[derive(Clone, Debug)]
pub struct RadioPolicy<'a> {
    actor: Actor<'a>,
    seed: u64,
    mode: Mode,
    radio: Radio,
    boards: Vec<Board>,
    observations: Vec<Observation>,
    figures: LinkFigures,
}

/// What one UAV holds besides the actor.
#[derive(Clone, Debug)]
struct Board {
    id: u16,
    table: NeighbourTable,
    view: Neighbours,
    own: State,
    tie: i8,
    feature: Feature,
}

impl<'a> RadioPolicy<'a> {
    /// `seed` is the policy seed that all UAVs share; the link's draws come from it too.
    ///
    /// # Errors
    /// Settings that cannot be, or more UAVs than a link has nodes.
    pub fn new(actor: Actor<'a>, seed: u64, mode: Mode, link: &LinkSettings, uavs: usize) -> Result<Self, LinkError> {
        let radio = Radio::new(link, uavs, seed)?;
        let policy = TablePolicy::of(&actor);
        let board = |id| Board {
            id,
            table: NeighbourTable::new(id, policy, DEFAULT_STEP_MS),
            view: Neighbours::new(),
            own: State::default(),
            tie: 0,
            feature: actor.encode(&[0; LEN]),
        };
        // Radio::new bounds the number by MAX_NODES.
        let boards = (0..uavs as u16).map(board).collect();
        let observations = vec![[0; LEN]; uavs];
        Ok(Self { actor, seed, mode, radio, boards, observations, figures: LinkFigures::default() })
    }

    /// Takes another policy seed for the next episode, from its [`Policy::begin`] on.
    pub const fn reseed(&mut self, seed: u64) {
        self.seed = seed;
    }

    /// The UAVs look, tell each other what they see and hear it, in the present state of
    /// `world`. Call it once a step.
    ///
    /// # Panics
    /// When `world` has not as many UAVs as [`Self::new`] was told.
    pub fn look(&mut self, world: &World) {
        let uavs = world.scenario().uavs;
        assert!(uavs == self.boards.len(), "look: {uavs} UAVs, the policy was made for {}", self.boards.len());
        let step = world.steps_done();
        let begin_ms = u64::from(step) * STEP_MS;
        let now = Moment { step, time_ms: begin_ms as u32 };
        self.send_beacons(world, now, begin_ms);
        self.listen(now, begin_ms + ENCODE_MS);
        self.encode(world, now, begin_ms + ENCODE_MS);
        self.listen(now, begin_ms + DECIDE_MS);
        self.count(world, step);
    }

    /// Compares what every UAV believes with what is so.
    fn count(&mut self, world: &World, step: u32) {
        let boards = &self.boards;
        for (i, board) in boards.iter().enumerate() {
            // Damage makes ids that nobody has.
            let in_range = |j: usize| {
                let offset = boards.get(j).map(|other| other.own.position - board.own.position);
                offset.is_some_and(|o| o.within(COMMUNICATION_RANGE_U * TICKS_PER_U).is_some())
            };
            let (x, y) = world.position(i);
            let near = world.uavs_within(x, y, COMMUNICATION_RANGE_U as f32 + MARGIN_U);
            let neighbours = near.filter(|&j| j != i && in_range(j)).count();
            let believed = board.view.as_slice().iter().map(|n| in_range(usize::from(n.id)));
            let features = board.table.features(&board.view, step).count();
            self.figures.add_view(neighbours, believed, features);
        }
    }

    fn send_beacons(&mut self, world: &World, now: Moment, now_ms: u64) {
        for i in 0..self.boards.len() {
            self.radio.place(i, world.position(i));
        }
        for (i, board) in self.boards.iter_mut().enumerate() {
            let ((x, y), (vx, vy)) = (world.position(i), world.velocity(i));
            board.own = State { position: Vec2::from_u(x, y), velocity: Vec2::from_u(vx, vy) };
            board.tie = self.actor.tie_breaker(self.seed, board.id, now.step);
            let beacon = Beacon::new(board.header(now.step), now.time_ms, board.own, board.tie);
            send(&mut self.radio, now_ms, i, &Message::Beacon(beacon));
        }
    }

    /// Every UAV hears what has arrived by `now_ms`.
    fn listen(&mut self, now: Moment, now_ms: u64) {
        for (i, board) in self.boards.iter_mut().enumerate() {
            while let Some(datagram) = self.radio.poll(now_ms, i) {
                match Message::decode(datagram.bytes) {
                    Ok(message) => self.figures.add_answer(board.table.hear(&message, board.own.position, now)),
                    Err(_) => self.figures.malformed += 1,
                }
            }
        }
    }

    fn encode(&mut self, world: &World, now: Moment, now_ms: u64) {
        let half_side = world.scenario().half_side_ticks();
        for (i, (board, observation)) in self.boards.iter_mut().zip(&mut self.observations).enumerate() {
            board.table.view(board.own.position, now, &mut board.view);
            let scene = Scene { id: board.id, own: board.own, tie: board.tie, half_side, neighbours: &board.view };
            let (x, y) = world.position(i);
            let in_cells = world.poi_cells.around(x, y, OBSERVATION_RANGE_U as f32);
            *observation = observe(&scene, in_cells.flat_map(|run| &world.poi_ticks[run]).copied());
            board.feature = self.actor.encode(observation);
            let feature = message::Feature::of(board.header(now.step), board.degree(), &self.actor, &board.feature);
            if let Some(feature) = feature {
                send(&mut self.radio, now_ms, i, &Message::Feature(feature));
            }
        }
    }

    /// Observations of all UAVs at the last [`Self::look`].
    #[must_use]
    pub fn observations(&self) -> &[Observation] {
        &self.observations
    }

    /// The neighbours that UAV `i` believed in range at the last [`Self::look`].
    ///
    /// # Panics
    /// When there is no UAV `i`.
    #[must_use]
    pub fn neighbours(&self, i: usize) -> &Neighbours {
        &self.boards[i].view
    }

    /// Logits of UAV `i` for what it saw and heard at the last [`Self::look`], at `step`.
    ///
    /// # Panics
    /// When there is no UAV `i`.
    #[must_use]
    pub fn logits(&self, i: usize, step: u32) -> Logits {
        let board = &self.boards[i];
        let heard = board.table.features(&board.view, step).map(|(_, feature)| feature);
        self.actor.logits(&board.feature, board.degree(), heard)
    }

    /// The action of these logits for UAV `i` at `step`.
    #[must_use]
    pub fn choose(&self, logits: &Logits, i: usize, step: u32) -> Action {
        self.actor.choose(logits, self.mode, self.seed, i as u16, step)
    }

    /// The link.
    #[must_use]
    pub const fn radio(&self) -> &Radio {
        &self.radio
    }

    /// What the link has done to the swarm in this episode.
    #[must_use]
    pub fn figures(&self) -> LinkFigures {
        LinkFigures { counts: self.radio.counts(), ..self.figures }
    }
}

impl Policy for RadioPolicy<'_> {
    fn begin(&mut self, _: &World) {
        self.radio.reset(self.seed);
        let policy = TablePolicy::of(&self.actor);
        self.boards.iter_mut().for_each(|b| b.table.reset(b.id, policy, DEFAULT_STEP_MS));
        self.figures = LinkFigures::default();
    }

    fn act(&mut self, world: &World, actions: &mut [Action]) {
        self.look(world);
        let step = world.steps_done();
        for (i, action) in actions.iter_mut().enumerate() {
            *action = self.choose(&self.logits(i, step), i, step);
        }
    }
}

impl Board {
    fn header(&self, step: u32) -> Header {
        // One beacon and one feature a step.
        Header { id: self.id, sequence: step as u16, step }
    }

    fn degree(&self) -> u8 {
        self.view.as_slice().len() as u8 + 1 // at most MAX_NEIGHBOURS + 1
    }
}

fn send(radio: &mut Radio, now_ms: u64, from: usize, message: &Message) {
    radio.broadcast(now_ms, from, message.encode(&mut [0; MAX_LEN]));
}
