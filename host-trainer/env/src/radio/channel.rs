//! The channel model: datagrams between the nodes of a swarm.

use super::counts::DatagramCounts;
use super::datagram_random::{DatagramRandom, key};
use super::error::RadioError;
use super::impairments::{Direction, flip_bits, is_lost};
use super::in_transit::InTransit;
use super::parameters::MAX_NODES;
use super::settings::RadioSettings;
use crate::plane::squared_distance;
use std::collections::BinaryHeap;

/// Capacity that the buffer of a datagram starts with, bytes: the longest MAVLink frame has 280. Longer datagrams grow
/// it.
const BUFFER_BYTES: usize = 280;

/// A datagram that has arrived.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Datagram<'a> {
    /// The node that sent it.
    pub from: usize,
    /// When it arrived, ms on the clock of [`RadioChannel::send`].
    pub due_ms: u64,
    /// Its bytes as they arrived.
    pub bytes: &'a [u8],
}

/// A radio channel between the nodes 0, 1, 2 … of a swarm, which loses, delays, duplicates, reorders and corrupts
/// datagrams as [`RadioSettings`] say.
///
/// It has no clock and no socket: the caller passes the time, in ms of any clock that does not wrap. A node receives
/// datagrams in the order of their arrival; those of the same millisecond by sender, then as they were sent. After the
/// first episode nothing is allocated.
///
/// ```
/// use covey_env::radio::RadioChannel;
///
/// let settings = "loss=0.1,burst=3,delay_ms=40,jitter_ms=20".parse()?;
/// let mut channel = RadioChannel::new(&settings, 20, 7)?; // 20 nodes, seed 7
/// channel.broadcast(1_000, 3, b"from node 3 at 1,000 ms");
/// let received = (0..20).filter(|&node| channel.poll(1_060, node).is_some()).count() as u64;
/// assert_eq!(received + channel.counts().lost, 19);
/// # Ok::<(), covey_env::radio::RadioError>(())
/// ```
#[derive(Clone, Debug)]
pub struct RadioChannel {
    settings: RadioSettings,
    key: u64,
    nodes: usize,
    /// By sender, then receiver.
    directions: Vec<Direction>,
    positions: Vec<Option<(f32, f32)>>,
    /// By receiver: what is on its way there.
    queues: Vec<BinaryHeap<InTransit>>,
    /// Datagrams held back, of all directions.
    held: Vec<InTransit>,
    /// Buffers to be used again.
    spare: Vec<Vec<u8>>,
    /// The datagram that was polled last.
    delivered: Vec<u8>,
    in_flight: u64,
    counts: DatagramCounts,
}

impl RadioChannel {
    /// A channel between `nodes` nodes (1 to [`MAX_NODES`]), before its first datagram. All its random numbers follow
    /// from `seed`.
    ///
    /// # Errors
    /// [`RadioError`] when a parameter or the number of nodes is out of range.
    pub fn new(settings: &RadioSettings, nodes: usize, seed: u64) -> Result<Self, RadioError> {
        settings.validate()?;
        if !(1..=MAX_NODES).contains(&nodes) {
            return Err(RadioError::Nodes(nodes));
        }
        Ok(Self {
            settings: settings.clone(),
            key: key(seed),
            nodes,
            directions: vec![Direction::default(); nodes * nodes],
            positions: vec![None; nodes],
            queues: vec![BinaryHeap::new(); nodes],
            held: Vec::new(),
            spare: Vec::new(),
            delivered: Vec::with_capacity(BUFFER_BYTES),
            in_flight: 0,
            counts: DatagramCounts::default(),
        })
    }

    /// Returns to the state of [`Self::new`] with another seed, without allocating.
    pub fn reset(&mut self, seed: u64) {
        self.key = key(seed);
        self.directions.fill(Direction::default());
        self.positions.fill(None);
        let copies = self.queues.iter_mut().flat_map(BinaryHeap::drain).chain(self.held.drain(..));
        self.spare.extend(copies.map(|f| f.bytes));
        self.in_flight = 0;
        self.counts = DatagramCounts::default();
    }

    /// Changes the parameters for the datagrams sent from now on.
    ///
    /// # Errors
    /// [`RadioError`] when a parameter is out of range; the old ones then stay.
    pub fn set_settings(&mut self, settings: &RadioSettings) -> Result<(), RadioError> {
        settings.validate()?;
        self.settings.clone_from(settings);
        Ok(())
    }

    /// The present parameters.
    #[must_use]
    pub const fn settings(&self) -> &RadioSettings {
        &self.settings
    }

    /// Number of nodes.
    #[must_use]
    pub const fn nodes(&self) -> usize {
        self.nodes
    }

    /// What happened to the datagrams since the last reset.
    #[must_use]
    pub const fn counts(&self) -> DatagramCounts {
        self.counts
    }

    /// Number of copies between sender and receiver, those held back included.
    #[must_use]
    pub const fn in_flight(&self) -> u64 {
        self.in_flight
    }

    /// Sets the position of a node, (east, north) in u, from which the range is measured. A node without a position is
    /// in range of every other.
    ///
    /// # Panics
    /// When there is no such node.
    pub fn set_position(&mut self, node: usize, at: (f32, f32)) {
        self.positions[node] = Some(at);
    }

    /// Sends a datagram to every other node.
    ///
    /// # Panics
    /// When there is no node `from`.
    pub fn broadcast(&mut self, now_ms: u64, from: usize, bytes: &[u8]) {
        for to in (0..self.nodes).filter(|&to| to != from) {
            self.send(now_ms, from, to, bytes);
        }
    }

    /// Sends a datagram from one node to another.
    ///
    /// # Panics
    /// When there is no such node.
    pub fn send(&mut self, now_ms: u64, from: usize, to: usize, bytes: &[u8]) {
        assert!(from < self.nodes && to < self.nodes, "send: from {from} to {to}, there are {} nodes", self.nodes);
        self.counts.sent += 1;
        if !self.in_range(from, to) {
            self.counts.out_of_range += 1;
            return;
        }
        let (from16, to16) = (from as u16, to as u16); // below MAX_NODES
        let direction = &mut self.directions[from * self.nodes + to];
        let sequence = direction.sequence;
        direction.sequence = sequence.wrapping_add(1);
        let mut random = DatagramRandom::new(self.key, from16, to16, sequence);
        if is_lost(&self.settings, direction, sequence, &mut random) {
            self.counts.lost += 1;
            return;
        }
        let twice = random.happens(self.settings.duplicate);
        let wants_hold = random.happens(self.settings.reorder);
        let (hold, release) = (wants_hold && !direction.holds, direction.holds);
        direction.holds = hold;
        let mut first = InTransit { from: from16, to: to16, sequence, ..InTransit::default() };
        self.fill(&mut first, now_ms, bytes, &mut random);
        if twice {
            let mut second = InTransit { rank: 1, bytes: Vec::new(), ..first };
            self.fill(&mut second, now_ms, bytes, &mut random);
            self.counts.duplicated += 1;
            self.queues[to].push(second);
        }
        if release {
            self.release(&first);
        }
        if hold {
            self.counts.held += 1;
            self.held.push(first);
        } else {
            self.queues[to].push(first);
        }
    }

    /// The next datagram that has arrived at `to` by `now_ms`, if there is one.
    ///
    /// # Panics
    /// When there is no such node.
    pub fn poll(&mut self, now_ms: u64, to: usize) -> Option<Datagram<'_>> {
        if self.next_due_ms(to)? > now_ms {
            return None;
        }
        let copy = self.queues[to].pop()?;
        self.spare.push(std::mem::replace(&mut self.delivered, copy.bytes));
        self.in_flight -= 1;
        self.counts.delivered += 1;
        Some(Datagram { from: usize::from(copy.from), due_ms: copy.due_ms, bytes: &self.delivered })
    }

    /// When the next datagram for `to` arrives, ms; `None` when none is on its way or the only one is held back.
    ///
    /// # Panics
    /// When there is no such node.
    #[must_use]
    pub fn next_due_ms(&self, to: usize) -> Option<u64> {
        self.queues[to].peek().map(|f| f.due_ms)
    }

    fn in_range(&self, from: usize, to: usize) -> bool {
        let (Some(range), Some(a), Some(b)) = (self.settings.range_u, self.positions[from], self.positions[to]) else {
            return true;
        };
        squared_distance(a, b) <= range * range
    }

    /// Gives a copy its time of arrival and its bytes, some perhaps flipped.
    fn fill(&mut self, copy: &mut InTransit, now_ms: u64, bytes: &[u8], random: &mut DatagramRandom) {
        let RadioSettings { delay_ms, jitter_ms, corrupt, .. } = self.settings;
        let late_ms = random.below(jitter_ms + 1);
        copy.due_ms = now_ms.saturating_add(u64::from(delay_ms)).saturating_add(u64::from(late_ms));
        let mut buffer = self.spare.pop().unwrap_or_else(|| Vec::with_capacity(BUFFER_BYTES));
        buffer.clear();
        buffer.extend_from_slice(bytes);
        if random.happens(corrupt) && !buffer.is_empty() {
            self.counts.corrupted += 1;
            flip_bits(&mut buffer, random);
        }
        copy.bytes = buffer;
        self.in_flight += 1;
    }

    /// Releases the datagram held back until `next`: it arrives right behind it.
    fn release(&mut self, next: &InTransit) {
        let Some(at) = self.held.iter().position(|f| (f.from, f.to) == (next.from, next.to)) else { return };
        let held = self.held.swap_remove(at);
        // Not earlier than it would have come by itself.
        let due_ms = held.due_ms.max(next.due_ms);
        self.queues[usize::from(next.to)].push(InTransit { due_ms, sequence: next.sequence, rank: 2, ..held });
    }
}
