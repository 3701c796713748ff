//! UAVs that know each other by what their radio brings, and by nothing else.

use super::figures::RadioFigures;
use super::model::Radio;
use super::settings::{RadioError, RadioSettings};
use crate::world::World;
use firmware_core::actor::PolicyId;
use firmware_core::geometry::{COMMUNICATION_RANGE_U, OBSERVATION_RANGE_U, State, TICKS_PER_U, Vec2};
use firmware_core::message::{Beacon, FeatureMessage, Header, MAX_LEN, Message};
use firmware_core::neighbour_table::{DEFAULT_STEP_MS, Moment, NeighbourTable};
use firmware_core::observation::{BuildObservation, Neighbours, Scene};

/// When a UAV looks at its neighbours, encodes and sends its feature: ms after the step began,
/// when its beacon went out.
pub const ENCODE_MS: u64 = 400;
/// When it decides, ms after the step began.
pub const DECIDE_MS: u64 = 800;
const STEP_MS: u64 = DEFAULT_STEP_MS as u64;
/// What is added to a range, u, so that rounding to ticks leaves nobody out.
const MARGIN_U: f32 = 0.01;

/// The radio, and what each UAV has heard.
#[derive(Clone, Debug)]
pub(super) struct Swarm {
    pub(super) radio: Radio,
    pub(super) boards: Vec<Board>,
    policy: PolicyId,
    figures: RadioFigures,
}

/// What one UAV holds.
#[derive(Clone, Debug)]
pub(super) struct Board {
    id: u16,
    pub(super) table: NeighbourTable,
    /// Neighbours believed in range.
    pub(super) view: Neighbours,
    own: State,
    tie: i8,
}

/// What a UAV encodes.
pub(super) struct Seen<'o, O> {
    /// Which UAV.
    pub(super) index: usize,
    /// Of its feature message.
    pub(super) header: Header,
    /// Neighbours believed in range, and itself.
    pub(super) degree: u8,
    /// Its observation.
    pub(super) observation: &'o O,
}

impl Swarm {
    pub(super) fn new(link: &RadioSettings, uavs: usize, policy: PolicyId) -> Result<Self, RadioError> {
        let radio = Radio::new(link, uavs, 0)?;
        let board = |id| Board {
            id,
            table: NeighbourTable::new(id, policy, DEFAULT_STEP_MS),
            view: Neighbours::new(),
            own: State::default(),
            tie: 0,
        };
        // Radio::new bounds the number by MAX_NODES.
        let boards = (0..uavs as u16).map(board).collect();
        Ok(Self { radio, boards, policy, figures: RadioFigures::default() })
    }

    /// A new episode: nobody has heard anything. The link's draws come from `seed`.
    pub(super) fn begin(&mut self, seed: u64) {
        self.radio.reset(seed);
        let policy = self.policy;
        self.boards.iter_mut().for_each(|b| b.table.reset(b.id, policy, DEFAULT_STEP_MS));
        self.figures = RadioFigures::default();
    }

    /// A step on the air, in the present state of `world`: beacons, views, observations (one
    /// for each UAV goes to `out`), and the features that `encode` makes of them.
    pub(super) fn look<O: BuildObservation>(
        &mut self,
        world: &World,
        tie: impl Fn(u16, u32) -> i8,
        out: &mut [O],
        encode: impl FnMut(&Seen<'_, O>) -> Option<FeatureMessage>,
    ) {
        let uavs = world.scenario().uavs;
        assert!(uavs == self.boards.len(), "look: {uavs} UAVs, the swarm was made for {}", self.boards.len());
        let step = world.steps_done();
        let begin_ms = u64::from(step) * STEP_MS;
        let now = Moment { step, time_ms: begin_ms as u32 };
        self.send_beacons(world, now, begin_ms, tie);
        self.listen(now, begin_ms + ENCODE_MS);
        self.observe(world, now, begin_ms + ENCODE_MS, out, encode);
        self.listen(now, begin_ms + DECIDE_MS);
        self.count(world, step);
    }

    /// What the link has done in this episode.
    pub(super) fn figures(&self) -> RadioFigures {
        RadioFigures { counts: self.radio.counts(), ..self.figures }
    }

    fn send_beacons(&mut self, world: &World, now: Moment, now_ms: u64, tie: impl Fn(u16, u32) -> i8) {
        for i in 0..self.boards.len() {
            self.radio.place(i, world.position(i));
        }
        for (i, board) in self.boards.iter_mut().enumerate() {
            let ((x, y), (vx, vy)) = (world.position(i), world.velocity(i));
            board.own = State { position: Vec2::from_u(x, y), velocity: Vec2::from_u(vx, vy) };
            board.tie = tie(board.id, now.step);
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

    fn observe<O: BuildObservation>(
        &mut self,
        world: &World,
        now: Moment,
        now_ms: u64,
        out: &mut [O],
        mut encode: impl FnMut(&Seen<'_, O>) -> Option<FeatureMessage>,
    ) {
        let half_side = world.scenario().half_side_ticks();
        for (index, (board, observation)) in self.boards.iter_mut().zip(out).enumerate() {
            board.table.view(board.own.position, now, &mut board.view);
            let scene = Scene { id: board.id, own: board.own, tie: board.tie, half_side, neighbours: &board.view };
            let (x, y) = world.position(index);
            let in_cells = world.poi_cells.around(x, y, OBSERVATION_RANGE_U as f32);
            *observation = O::build(&scene, in_cells.flat_map(|run| &world.poi_ticks[run]).copied());
            let seen = Seen { index, header: board.header(now.step), degree: board.degree(), observation };
            if let Some(feature) = encode(&seen) {
                send(&mut self.radio, now_ms, index, &Message::Feature(feature));
            }
        }
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
}

impl Board {
    fn header(&self, step: u32) -> Header {
        // One beacon and one feature a step.
        Header { id: self.id, sequence: step as u16, step }
    }

    /// Neighbours believed in range, and itself.
    pub(super) fn degree(&self) -> u8 {
        self.view.as_slice().len() as u8 + 1 // at most MAX_NEIGHBOURS + 1
    }
}

fn send(radio: &mut Radio, now_ms: u64, from: usize, message: &Message) {
    radio.broadcast(now_ms, from, message.encode(&mut [0; MAX_LEN]));
}
