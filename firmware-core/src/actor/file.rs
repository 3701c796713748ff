//! The actor file: one postcard record in a checked envelope, read in place.
//!
//! ```text
//! 0   8  magic "COVEYACT"
//! 8   2  format version, u16 little-endian (1)
//! 10  2  zero
//! 12  4  length n of the body, u32 little-endian
//! 16  n  body: postcard, see [`Body`]
//! 16+n 4 CRC-32 (ISO-HDLC) of all bytes before, little-endian
//! ```
//!
//! `docs/actor-file.md` describes every field.

use super::layer::{Layer, LayerError, MAX_ROWS, even};
use super::{ActorInput, Aggregation, Dimensions, MAX_FEATURE, QuantisedActor, SELF_TESTS, self_test};
use crate::action::ACTIONS;
use crate::observation::{self, cells};
use crc::{CRC_32_ISO_HDLC, Crc};
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// First bytes of every actor file.
pub const MAGIC: [u8; 8] = *b"COVEYACT";
/// Format version that this code reads and writes.
pub const VERSION: u16 = 1;
/// Bytes before the body.
pub const HEADER: usize = 16;
/// Bytes after the body.
pub const TRAILER: usize = 4;

const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Where an actor comes from: for people and logs, not used in flight.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Provenance<'a> {
    /// Program and version that wrote it.
    pub trainer: &'a str,
    /// Scenario it was trained on.
    pub scenario: &'a str,
    /// UAVs in a training world.
    pub uavs: u16,
    /// Seed of the training run.
    pub seed: u64,
    /// Training episodes.
    pub episodes: u32,
    /// Worlds of the evaluation behind the two coverages (0: not evaluated).
    pub worlds: u32,
    /// Coverage index of the float policy, in 1/10,000.
    pub float_coverage: u16,
    /// Coverage index of this int8 actor, in 1/10,000.
    pub int8_coverage: u16,
}

/// The body of the file, in this order.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Body<'a> {
    /// 0 to 3 zero bytes, so that `weights` starts at a multiple of 4 in the file.
    pub align: &'a [u8],
    /// Every layer's weights in [`Dimensions::layers`] order, packed in row pairs (see
    /// [`crate::kernel`]).
    pub weights: &'a [u8],
    /// Every layer's biases and multipliers, i32 little-endian.
    pub tables: &'a [u8],
    /// Form of the observation ([`observation::BuildObservation::ID`]).
    pub observation: u16,
    /// Form of the aggregation.
    pub aggregation: Aggregation,
    /// Widths.
    pub dimensions: Dimensions,
    /// Steps for which a tie-breaker holds.
    pub tie_period: u32,
    /// Multiplier of the aggregated features (0 without aggregation).
    pub aggregate_multiplier: i32,
    /// Where the actor comes from.
    pub provenance: Provenance<'a>,
    /// [`SELF_TESTS`] vectors, see [`super::write_self_test`].
    pub self_tests: &'a [u8],
    /// [`Body::content_hash`].
    pub content_hash: u64,
}

/// Why a file is not a sound actor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum LoadError {
    /// Fewer bytes than the header says, or than a header has.
    #[error("the actor file is cut short: {found} bytes of {expected}; copy or export it again")]
    Truncated {
        /// Bytes there should be.
        expected: usize,
        /// Bytes there are.
        found: usize,
    },
    /// More bytes than the header says.
    #[error("{extra} bytes too many after the actor file; copy or export it again")]
    Extended {
        /// Bytes after the end.
        extra: usize,
    },
    /// The first bytes are not an actor file's.
    #[error("this is not an actor file (it does not begin with COVEYACT); make one with `host-trainer export`")]
    NotAnActor,
    /// Another format version.
    #[error("actor file format {found}, but this program reads format {VERSION}; export it again with this version")]
    Version {
        /// Version in the file.
        found: u16,
    },
    /// The checksum does not fit.
    #[error("the actor file is damaged (CRC-32 {found:08x}, computed {computed:08x}); copy or export it again")]
    Checksum {
        /// CRC in the file.
        found: u32,
        /// CRC of the bytes.
        computed: u32,
    },
    /// The checksum fits, but the record cannot be read.
    #[error("the actor file's record cannot be read although its checksum fits; export it again")]
    Malformed,
    /// Another form of the observation.
    #[error("the actor wants observation form {found}, this program builds form {built}; train one of that form")]
    Observation {
        /// Form in the file.
        found: u16,
        /// Form that this program builds.
        built: u16,
    },
    /// Widths that this program cannot fly.
    #[error("the actor's {what} is {found}, this program takes {allowed}; train it with fitting widths")]
    Dimension {
        /// Which width.
        what: &'static str,
        /// Width in the file.
        found: u16,
        /// What would do.
        allowed: &'static str,
    },
    /// Weights or tables of another length than the widths ask for.
    #[error("the actor's weights do not fit its widths; export it again")]
    Length,
    /// A bias or multiplier out of bounds, so sums could overflow.
    #[error("the actor has a bias or multiplier out of bounds; export it again")]
    OutOfRange,
    /// The self-test vectors cannot be read.
    #[error("the actor's self-test vectors cannot be read; export it again")]
    SelfTests,
    /// The content hash in the file is not that of its content.
    #[error("the actor's content hash does not fit its content; export it again")]
    ContentHash,
}

/// Why a file could not be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum StoreError {
    /// The buffer is too small.
    #[error("the buffer is too small for the actor file")]
    Full,
}

impl Body<'_> {
    /// FNV-1a (64 bit) over what decides: observation form, aggregation, widths, tie
    /// period, aggregate multiplier, weights and tables, integers little-endian.
    #[must_use]
    pub fn content_hash(&self) -> u64 {
        let d = self.dimensions;
        let mut hash = Fnv::new();
        hash.write(&self.observation.to_le_bytes());
        hash.write(&[self.aggregation as u8]);
        for width in [d.observation, d.hidden, d.feature, d.head, d.actions] {
            hash.write(&width.to_le_bytes());
        }
        hash.write(&self.tie_period.to_le_bytes());
        hash.write(&self.aggregate_multiplier.to_le_bytes());
        hash.write(self.weights);
        hash.write(self.tables);
        hash.finish()
    }

    /// Writes the file into `out` and returns its length. `align` and `content_hash` are
    /// set here.
    ///
    /// # Errors
    /// [`StoreError::Full`] when `out` is too small.
    pub fn store(&self, out: &mut [u8]) -> Result<usize, StoreError> {
        let mut body = Body { content_hash: self.content_hash(), ..*self };
        // The weights follow the padding, its length byte and their own length.
        let length_bytes = varint_bytes(self.weights.len());
        body.align = [0u8; 3].get(..(4 - (HEADER + 1 + length_bytes) % 4) % 4).unwrap_or(&[]);
        let room = out.get_mut(HEADER..).ok_or(StoreError::Full)?;
        let n = postcard::to_slice(&body, room).map_err(|_| StoreError::Full)?.len();
        let (head, _) = out.split_at_mut_checked(HEADER).ok_or(StoreError::Full)?;
        let fields = MAGIC
            .into_iter()
            .chain(VERSION.to_le_bytes())
            .chain([0, 0])
            .chain(u32::try_from(n).map_err(|_| StoreError::Full)?.to_le_bytes());
        for (place, byte) in head.iter_mut().zip(fields) {
            *place = byte;
        }
        let sum = CRC.checksum(out.get(..HEADER + n).ok_or(StoreError::Full)?);
        out.get_mut(HEADER + n..HEADER + n + TRAILER).ok_or(StoreError::Full)?.copy_from_slice(&sum.to_le_bytes());
        Ok(HEADER + n + TRAILER)
    }
}

const fn varint_bytes(mut n: usize) -> usize {
    let mut bytes = 1;
    while n >= 128 {
        n >>= 7;
        bytes += 1;
    }
    bytes
}

/// FNV-1a, 64 bit.
pub(crate) struct Fnv(u64);

impl Fnv {
    pub(crate) const fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    pub(crate) fn write(&mut self, bytes: &[u8]) {
        for &b in bytes {
            self.0 = (self.0 ^ u64::from(b)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }

    pub(crate) const fn finish(&self) -> u64 {
        self.0
    }
}

/// Checks the envelope and returns the body's bytes.
fn open(file: &[u8]) -> Result<&[u8], LoadError> {
    let smallest = HEADER + TRAILER;
    let short = |expected| LoadError::Truncated { expected, found: file.len() };
    let magic = file.get(..MAGIC.len().min(file.len())).unwrap_or(&[]);
    if !MAGIC.starts_with(magic) {
        return Err(LoadError::NotAnActor);
    }
    let &[_, _, _, _, _, _, _, _, v0, v1, z0, z1, n0, n1, n2, n3] =
        file.first_chunk::<HEADER>().ok_or(short(smallest))?;
    let found = u16::from_le_bytes([v0, v1]);
    if found != VERSION {
        return Err(LoadError::Version { found });
    }
    let n = u32::from_le_bytes([n0, n1, n2, n3]) as usize;
    let expected = n.saturating_add(smallest);
    if file.len() < expected {
        return Err(short(expected));
    }
    if file.len() > expected {
        return Err(LoadError::Extended { extra: file.len() - expected });
    }
    let (content, trailer) = file.split_last_chunk::<TRAILER>().ok_or(short(smallest))?;
    let (found, computed) = (u32::from_le_bytes(*trailer), CRC.checksum(content));
    if found != computed {
        return Err(LoadError::Checksum { found, computed });
    }
    if [z0, z1] != [0, 0] {
        return Err(LoadError::Malformed);
    }
    content.get(HEADER..).ok_or(LoadError::Malformed)
}

/// The actor file at the start of a flash region: as much of it as the file's header says. A
/// region that holds no whole actor file comes back as it is, and loading says what is wrong.
#[must_use]
pub fn at_start_of(region: &[u8]) -> &[u8] {
    let &[.., n0, n1, n2, n3] = region.first_chunk::<HEADER>().unwrap_or(&[0xff; HEADER]);
    let length = (u32::from_le_bytes([n0, n1, n2, n3]) as usize).saturating_add(HEADER + TRAILER);
    region.get(..length).unwrap_or(region)
}

// The messages of `check_dimensions` say these numbers.
const _: () =
    assert!(observation::LEN == 160 && cells::LEN == 1116 && MAX_ROWS == 128 && MAX_FEATURE == 64 && ACTIONS == 17);

fn check_dimensions(d: Dimensions, numbers: usize, allowed: &'static str) -> Result<(), LoadError> {
    let refuse = |what, found, allowed| Err(LoadError::Dimension { what, found, allowed });
    let fits = |n: u16, max: usize| n >= 1 && usize::from(n) <= max;
    if usize::from(d.observation) != numbers {
        return refuse("observation length", d.observation, allowed);
    }
    if !fits(d.hidden, MAX_ROWS) {
        return refuse("first hidden width", d.hidden, "1 to 128");
    }
    if !fits(d.feature, MAX_FEATURE) || !d.feature.is_multiple_of(2) {
        return refuse("feature width", d.feature, "even, 2 to 64");
    }
    if !fits(d.head, MAX_ROWS) {
        return refuse("head width", d.head, "1 to 128");
    }
    if usize::from(d.actions) != ACTIONS {
        return refuse("number of actions", d.actions, "17");
    }
    Ok(())
}

impl From<LayerError> for LoadError {
    fn from(e: LayerError) -> Self {
        match e {
            LayerError::Short => Self::Length,
            LayerError::OutOfRange => Self::OutOfRange,
        }
    }
}

impl<'a, O: ActorInput> QuantisedActor<'a, O> {
    /// Reads an actor file in place. Every length and bound is checked before the first
    /// use; run [`Self::self_test`] next.
    ///
    /// # Errors
    /// The first thing found wrong, see [`LoadError`].
    pub fn load(file: &'a [u8]) -> Result<Self, LoadError> {
        let (body, rest): (Body<'a>, _) = postcard::take_from_bytes(open(file)?).map_err(|_| LoadError::Malformed)?;
        if !rest.is_empty() || body.align.iter().any(|&b| b != 0) {
            return Err(LoadError::Malformed);
        }
        if body.observation != O::ID {
            return Err(LoadError::Observation { found: body.observation, built: O::ID });
        }
        check_dimensions(body.dimensions, O::LEN, O::LEN_TEXT)?;
        let d = body.dimensions;
        let hidden = usize::from(d.hidden);
        let first = (O::weight_bytes(hidden), Layer::table_bytes(hidden));
        let needed = d.layers(body.aggregation).skip(1).fold(first, |(weights, tables), (rows, columns)| {
            (weights + Layer::weight_bytes(rows, columns), tables + Layer::table_bytes(rows))
        });
        if (body.weights.len(), body.tables.len()) != needed {
            return Err(LoadError::Length);
        }
        let (mut weights, mut tables) = (body.weights, body.tables);
        let encoder1 = O::take(&mut weights, &mut tables, hidden)?;
        let mut take = |rows: u16, columns: usize| {
            Layer::take(&mut weights, &mut tables, usize::from(rows), columns).map_err(LoadError::from)
        };
        let feature = usize::from(d.feature);
        let encoder2 = take(d.feature, hidden)?;
        let gat = body.aggregation == Aggregation::Gat;
        let attention = if gat { take(2, feature)? } else { Layer::default() };
        let graphed = body.aggregation != Aggregation::None;
        let graph = if graphed { take(d.feature, feature)? } else { Layer::default() };
        let head = take(d.head, if graphed { 2 * feature } else { feature })?;
        let output = take(d.actions, usize::from(d.head))?;
        if body.aggregate_multiplier < 0 {
            return Err(LoadError::OutOfRange);
        }
        if self_test::vectors::<O>(body.self_tests, feature).count() != SELF_TESTS
            || self_test::length::<O>(body.self_tests, feature) != Some(body.self_tests.len())
        {
            return Err(LoadError::SelfTests);
        }
        if body.content_hash != body.content_hash() {
            return Err(LoadError::ContentHash);
        }
        Ok(Self {
            aggregation: body.aggregation,
            dimensions: d,
            tie_period: body.tie_period,
            content_hash: body.content_hash,
            provenance: body.provenance,
            self_tests: body.self_tests,
            encoder1,
            encoder2,
            attention,
            graph,
            head,
            output,
            aggregate_multiplier: body.aggregate_multiplier,
        })
    }
}

const _: () = assert!(even(ACTIONS) <= MAX_ROWS);
