//! Datagrams between the nodes of a swarm.

use super::draws::{Draws, key};
use super::settings::{RadioError, RadioSettings};
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Most nodes of a link: the state of every direction is kept, 8 bytes each.
pub const MAX_NODES: usize = 2048;
/// Room made for a datagram, bytes: the longest MAVLink frame has 280. Longer ones find theirs.
const ROOM: usize = 280;
/// Most bits that damage flips.
const MOST_FLIPS: u32 = 4;

/// What became of the datagrams so far. Always
/// `sent + duplicated == out_of_range + lost + delivered + `[`Radio::in_flight`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counts {
    /// Handed to [`Radio::send`]; one that is broadcast counts once a receiver.
    pub sent: u64,
    /// Lost because the receiver was too far away.
    pub out_of_range: u64,
    /// Lost on the way.
    pub lost: u64,
    /// Second copies made.
    pub duplicated: u64,
    /// Held back behind the next one.
    pub held: u64,
    /// Copies damaged, each counted when it was sent.
    pub corrupted: u64,
    /// Handed out by [`Radio::poll`].
    pub delivered: u64,
}

/// A datagram that has arrived.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Datagram<'a> {
    /// The node that sent it.
    pub from: usize,
    /// When it arrived, ms on the clock of [`Radio::send`].
    pub due_ms: u64,
    /// What arrived.
    pub bytes: &'a [u8],
}

/// One sender and one receiver.
#[derive(Clone, Copy, Debug, Default)]
struct Direction {
    /// Datagrams sent in range.
    sequence: u32,
    /// Whether the last one fell into a burst of losses.
    gone: bool,
    /// Whether one is held back.
    holds: bool,
}

/// A copy on its way.
#[derive(Clone, Debug, Default)]
struct Flight {
    due_ms: u64,
    from: u16,
    to: u16,
    sequence: u32,
    /// Among those of one sequence number: the first copy, the second, the one held until then.
    rank: u8,
    bytes: Vec<u8>,
}

impl Flight {
    const fn key(&self) -> (u64, u16, u32, u8) {
        (self.due_ms, self.from, self.sequence, self.rank)
    }
}

impl PartialEq for Flight {
    fn eq(&self, other: &Self) -> bool {
        self.key() == other.key()
    }
}

impl Eq for Flight {}

impl PartialOrd for Flight {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// The earliest is the greatest, as [`BinaryHeap`] hands out the greatest.
impl Ord for Flight {
    fn cmp(&self, other: &Self) -> Ordering {
        other.key().cmp(&self.key())
    }
}

/// A link between the nodes 0, 1, 2 … of a swarm.
///
/// It has no clock and no socket: whoever uses it says what time it is, in ms of any clock that
/// does not wrap. A node hears in the order in which datagrams arrive; those that arrive in the
/// same millisecond by their sender, then as they were sent. Once warm, nothing is allocated.
///
/// ```
/// use covey_env::radio::Radio;
///
/// let link = "loss=0.1,burst=3,delay_ms=40,jitter_ms=20".parse()?;
/// let mut radio = Radio::new(&link, 20, 7)?; // 20 nodes, seed 7
/// radio.broadcast(1_000, 3, b"from node 3 at 1,000 ms");
/// let heard = (0..20).filter(|&node| radio.poll(1_060, node).is_some()).count() as u64;
/// assert_eq!(heard + radio.counts().lost, 19);
/// # Ok::<(), covey_env::radio::RadioError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Radio {
    settings: RadioSettings,
    key: u64,
    nodes: usize,
    /// By sender, then receiver.
    directions: Vec<Direction>,
    places: Vec<Option<(f32, f32)>>,
    inboxes: Vec<BinaryHeap<Flight>>,
    held: Vec<Flight>,
    spare: Vec<Vec<u8>>,
    handed: Vec<u8>,
    in_flight: u64,
    counts: Counts,
}

impl Radio {
    /// A link between `nodes` nodes (1 to [`MAX_NODES`]), before its first datagram.
    ///
    /// # Errors
    /// Settings or a number of nodes that cannot be.
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
            places: vec![None; nodes],
            inboxes: vec![BinaryHeap::new(); nodes],
            held: Vec::new(),
            spare: Vec::new(),
            handed: Vec::with_capacity(ROOM),
            in_flight: 0,
            counts: Counts::default(),
        })
    }

    /// Becomes [`Self::new`] with another seed, in place.
    pub fn reset(&mut self, seed: u64) {
        self.key = key(seed);
        self.directions.fill(Direction::default());
        self.places.fill(None);
        let flights = self.inboxes.iter_mut().flat_map(BinaryHeap::drain).chain(self.held.drain(..));
        self.spare.extend(flights.map(|f| f.bytes));
        self.in_flight = 0;
        self.counts = Counts::default();
    }

    /// Takes other settings for what is sent from now on.
    ///
    /// # Errors
    /// Settings that cannot be; the old ones stay.
    pub fn retune(&mut self, settings: &RadioSettings) -> Result<(), RadioError> {
        settings.validate()?;
        self.settings.clone_from(settings);
        Ok(())
    }

    /// The settings.
    #[must_use]
    pub const fn settings(&self) -> &RadioSettings {
        &self.settings
    }

    /// How many nodes there are.
    #[must_use]
    pub const fn nodes(&self) -> usize {
        self.nodes
    }

    /// What became of the datagrams so far.
    #[must_use]
    pub const fn counts(&self) -> Counts {
        self.counts
    }

    /// Copies on their way, those held back among them.
    #[must_use]
    pub const fn in_flight(&self) -> u64 {
        self.in_flight
    }

    /// Where a node is, u; this is what the range is measured by. A node that was never placed
    /// is in range of everyone.
    ///
    /// # Panics
    /// When there is no such node.
    pub fn place(&mut self, node: usize, at: (f32, f32)) {
        self.places[node] = Some(at);
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
        let mut draws = Draws::new(self.key, from16, to16, sequence);
        if loses(&self.settings, direction, sequence, &mut draws) {
            self.counts.lost += 1;
            return;
        }
        let twice = draws.happens(self.settings.duplicate);
        let wants_hold = draws.happens(self.settings.reorder);
        let (hold, release) = (wants_hold && !direction.holds, direction.holds);
        direction.holds = hold;
        let mut first = Flight { from: from16, to: to16, sequence, ..Flight::default() };
        self.fill(&mut first, now_ms, bytes, &mut draws);
        if twice {
            let mut second = Flight { rank: 1, bytes: Vec::new(), ..first };
            self.fill(&mut second, now_ms, bytes, &mut draws);
            self.counts.duplicated += 1;
            self.inboxes[to].push(second);
        }
        if release {
            self.release(&first);
        }
        if hold {
            self.counts.held += 1;
            self.held.push(first);
        } else {
            self.inboxes[to].push(first);
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
        let flight = self.inboxes[to].pop()?;
        self.spare.push(std::mem::replace(&mut self.handed, flight.bytes));
        self.in_flight -= 1;
        self.counts.delivered += 1;
        Some(Datagram { from: usize::from(flight.from), due_ms: flight.due_ms, bytes: &self.handed })
    }

    /// When the next datagram on its way to `to` arrives, ms. One that is held back has no
    /// time yet.
    ///
    /// # Panics
    /// When there is no such node.
    #[must_use]
    pub fn next_due_ms(&self, to: usize) -> Option<u64> {
        self.inboxes[to].peek().map(|f| f.due_ms)
    }

    fn in_range(&self, from: usize, to: usize) -> bool {
        let (Some(range), Some(a), Some(b)) = (self.settings.range_u, self.places[from], self.places[to]) else {
            return true;
        };
        let (dx, dy) = (a.0 - b.0, a.1 - b.1);
        dx * dx + dy * dy <= range * range
    }

    /// Gives a copy its time of arrival and its bytes, damaged or not.
    fn fill(&mut self, flight: &mut Flight, now_ms: u64, bytes: &[u8], draws: &mut Draws) {
        let RadioSettings { delay_ms, jitter_ms, corrupt, .. } = self.settings;
        let late_ms = draws.below(jitter_ms + 1);
        flight.due_ms = now_ms.saturating_add(u64::from(delay_ms)).saturating_add(u64::from(late_ms));
        let mut copy = self.spare.pop().unwrap_or_else(|| Vec::with_capacity(ROOM));
        copy.clear();
        copy.extend_from_slice(bytes);
        if draws.happens(corrupt) && !copy.is_empty() {
            self.counts.corrupted += 1;
            flip(&mut copy, draws);
        }
        flight.bytes = copy;
        self.in_flight += 1;
    }

    /// Lets the datagram that `next` overtakes arrive right behind it.
    fn release(&mut self, next: &Flight) {
        let Some(at) = self.held.iter().position(|f| (f.from, f.to) == (next.from, next.to)) else { return };
        let held = self.held.swap_remove(at);
        // Not earlier than it would have come by itself.
        let due_ms = held.due_ms.max(next.due_ms);
        self.inboxes[usize::from(next.to)].push(Flight { due_ms, sequence: next.sequence, rank: 2, ..held });
    }
}

/// Whether the next datagram of a direction is lost.
fn loses(settings: &RadioSettings, direction: &mut Direction, sequence: u32, draws: &mut Draws) -> bool {
    let RadioSettings { loss, burst, .. } = *settings;
    let probability = match burst {
        Some(burst) if sequence > 0 && loss < 1.0 => match direction.gone {
            true => 1.0 - 1.0 / burst,
            // So that in the long run `loss` of all are lost.
            false => loss / (1.0 - loss) / burst,
        },
        _ => loss,
    };
    direction.gone = draws.happens(probability);
    direction.gone
}

/// Flips 1 to [`MOST_FLIPS`] different bits (or as many as there are).
fn flip(bytes: &mut [u8], draws: &mut Draws) {
    let bits = u32::try_from(bytes.len() * 8).unwrap_or(u32::MAX);
    let flips = (1 + draws.below(MOST_FLIPS)).min(bits);
    let mut flipped = [u32::MAX; MOST_FLIPS as usize];
    for k in 0..flips as usize {
        let mut bit = draws.below(bits);
        while flipped[..k].contains(&bit) {
            bit = (bit + 1) % bits;
        }
        flipped[k] = bit;
        bytes[bit as usize / 8] ^= 1 << (bit % 8);
    }
}
