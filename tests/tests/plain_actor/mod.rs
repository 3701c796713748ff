//! The actor written a second time, from the description of its file: a reader that
//! takes the bytes apart by hand and the network in 64-bit integers, where nothing can
//! wrap. Slow and plain on purpose; it shares no code with the actor it checks.

// Each test file uses a part of it.
#![allow(dead_code)]

use std::ops::Range;

/// Bytes before the body.
pub const HEADER: usize = 16;
/// Bytes after it.
pub const TRAILER: usize = 4;

/// How neighbours are combined, by its number in the file.
pub const NONE: u64 = 0;
/// Graph convolution.
pub const GCN: u64 = 1;
/// Graph attention.
pub const GAT: u64 = 2;
/// Graph attention scored by the receiver.
pub const GATV2: u64 = 3;
/// Mean of the neighbours.
pub const SAGE: u64 = 4;

/// A dense layer, `weights[row][column]`.
pub struct PlainLayer {
    pub weights: Vec<Vec<i64>>,
    pub biases: Vec<i64>,
    pub multipliers: Vec<i64>,
}

/// Everything in an actor file.
pub struct PlainActor {
    /// Where the weights lie in the file.
    pub weights_at: Range<usize>,
    /// Where biases and multipliers lie.
    pub tables_at: Range<usize>,
    pub observation_id: u64,
    pub aggregation: u64,
    /// Observation, hidden, feature, head, actions.
    pub widths: [usize; 5],
    pub tie_period: u64,
    pub aggregate_multiplier: i64,
    pub trainer: String,
    pub scenario: String,
    /// UAVs, seed, episodes, worlds, float and int8 coverage.
    pub numbers: [u64; 6],
    /// Where the self-tests lie.
    pub self_tests_at: Range<usize>,
    pub content_hash: u64,
    pub encoder1: PlainLayer,
    pub encoder2: PlainLayer,
    /// GATv2: receiver, sender.
    pub ends: Option<[PlainLayer; 2]>,
    pub attention: Option<PlainLayer>,
    pub graph: Option<PlainLayer>,
    pub head: PlainLayer,
    pub output: PlainLayer,
}

/// What a UAV makes of its observation.
pub struct PlainFeature {
    /// For its own head.
    pub own: Vec<i64>,
    /// Broadcast.
    pub values: Vec<i64>,
    /// Halves of the score: kept, broadcast.
    pub halves: [i64; 2],
}

/// A neighbour as it was heard.
#[derive(Clone, Debug)]
pub struct PlainNeighbour {
    pub values: Vec<i8>,
    pub degree: u8,
    pub attention_source: i16,
}

/// A place in the file.
struct Reader<'f> {
    file: &'f [u8],
    at: usize,
}

impl Reader<'_> {
    /// Seven bits a byte, the low ones first; the last byte has no top bit.
    fn varint(&mut self) -> u64 {
        let mut value = 0;
        for shift in (0..).step_by(7) {
            let byte = self.file[self.at];
            self.at += 1;
            value |= u64::from(byte & 127) << shift;
            if byte < 128 {
                break;
            }
        }
        value
    }

    fn zigzag(&mut self) -> i64 {
        let v = self.varint();
        (v >> 1) as i64 ^ -((v & 1) as i64)
    }

    fn bytes(&mut self) -> Range<usize> {
        let length = self.varint() as usize;
        self.at += length;
        self.at - length..self.at
    }

    fn text(&mut self) -> String {
        let place = self.bytes();
        String::from_utf8(self.file[place].to_vec()).expect("text")
    }
}

/// Layers in file order.
struct Layers<'f> {
    weights: &'f [u8],
    tables: &'f [u8],
}

impl Layers<'_> {
    fn take(&mut self, rows: usize, columns: usize) -> PlainLayer {
        let padded = columns.next_multiple_of(2);
        // Rows come in pairs; a pair has two bytes a column: the second row's weight
        // plus 128, then the first row's weight.
        let weight = |r: usize, c: usize| {
            let at = (r / 2) * 2 * padded + 2 * c;
            if r.is_multiple_of(2) { i64::from(self.weights[at + 1] as i8) } else { i64::from(self.weights[at]) - 128 }
        };
        let weights = (0..rows).map(|r| (0..columns).map(|c| weight(r, c)).collect()).collect();
        self.weights = &self.weights[rows.next_multiple_of(2) * padded..];
        let words = |bytes: &[u8]| -> Vec<i64> {
            bytes.chunks_exact(4).map(|b| i64::from(i32::from_le_bytes([b[0], b[1], b[2], b[3]]))).collect()
        };
        let (biases, multipliers) = (words(&self.tables[..4 * rows]), words(&self.tables[4 * rows..8 * rows]));
        self.tables = &self.tables[8 * rows..];
        PlainLayer { weights, biases, multipliers }
    }
}

impl PlainActor {
    /// Takes a sound file apart.
    pub fn read(file: &[u8]) -> Self {
        assert_eq!(&file[..8], b"COVEYACT");
        assert_eq!(file[8..12], [1, 0, 0, 0], "version 1, then zeros");
        let length = u32::from_le_bytes([file[12], file[13], file[14], file[15]]) as usize;
        assert_eq!(file.len(), HEADER + length + TRAILER);
        let mut r = Reader { file, at: HEADER };
        let align = r.bytes();
        assert!(file[align].iter().all(|&b| b == 0));
        let (weights_at, tables_at) = (r.bytes(), r.bytes());
        let observation_id = r.varint();
        let aggregation = r.varint();
        let widths = [(); 5].map(|()| r.varint() as usize);
        let (tie_period, aggregate_multiplier) = (r.varint(), r.zigzag());
        let (trainer, scenario) = (r.text(), r.text());
        let numbers = [(); 6].map(|()| r.varint());
        let (self_tests_at, content_hash) = (r.bytes(), r.varint());
        assert_eq!(r.at, HEADER + length, "the record fills the body");
        let mut layers = Layers { weights: &file[weights_at.clone()], tables: &file[tables_at.clone()] };
        let [observation, hidden, feature, head, actions] = widths;
        let encoder1 = layers.take(hidden, observation);
        let encoder2 = layers.take(feature, hidden);
        let ends = (aggregation == GATV2).then(|| [(); 2].map(|()| layers.take(feature, feature)));
        let attention = match aggregation {
            GAT => Some(layers.take(2, feature)),
            GATV2 => Some(layers.take(1, feature)),
            _ => None,
        };
        let graph = [GCN, GAT, SAGE].contains(&aggregation).then(|| layers.take(feature, feature));
        let head_layer = layers.take(head, if aggregation == NONE { feature } else { 2 * feature });
        let output = layers.take(actions, head);
        assert!(layers.weights.is_empty() && layers.tables.is_empty(), "the layers fill both blobs");
        Self {
            weights_at,
            tables_at,
            observation_id,
            aggregation,
            widths,
            tie_period,
            aggregate_multiplier,
            trainer,
            scenario,
            numbers,
            self_tests_at,
            content_hash,
            encoder1,
            encoder2,
            ends,
            attention,
            graph,
            head: head_layer,
            output,
        }
    }

    /// FNV-1a over what decides.
    pub fn computed_hash(&self, file: &[u8]) -> u64 {
        let mut bytes = (self.observation_id as u16).to_le_bytes().to_vec();
        bytes.push(self.aggregation as u8);
        bytes.extend(self.widths.iter().flat_map(|&w| (w as u16).to_le_bytes()));
        bytes.extend((self.tie_period as u32).to_le_bytes());
        bytes.extend((self.aggregate_multiplier as i32).to_le_bytes());
        bytes.extend(&file[self.weights_at.clone()]);
        bytes.extend(&file[self.tables_at.clone()]);
        fnv(&bytes)
    }

    /// The feature, own and broadcast.
    pub fn encode(&self, observation: &[i8]) -> PlainFeature {
        let x: Vec<i64> = observation.iter().map(|&o| o.into()).collect();
        let own = self.encoder2.rectified(&self.encoder1.rectified(&x));
        match (&self.ends, &self.attention) {
            (Some([_, sender]), _) => {
                let values = sender.wide(&own).iter().map(|v| (*v).clamp(-127, 127)).collect();
                PlainFeature { own, values, halves: [0, 0] }
            }
            (None, attention) => {
                let halves = attention.as_ref().map_or(vec![0, 0], |a| a.wide(&own));
                PlainFeature { values: own.clone(), own, halves: [halves[0], halves[1]] }
            }
        }
    }

    /// The logits of a UAV that sees `observation` and has heard `neighbours`.
    pub fn logits(&self, observation: &[i8], degree: u8, neighbours: &[PlainNeighbour]) -> Vec<i64> {
        let PlainFeature { own, values: sent, halves: [attention_destination, attention_source] } =
            self.encode(observation);
        let values = |n: &PlainNeighbour| n.values.iter().map(|&v| i64::from(v)).collect();
        // Oneself first.
        let mut around: Vec<(Vec<i64>, u8, i64)> = vec![(sent, degree, attention_source)];
        around.extend(neighbours.iter().take(16).map(|n| (values(n), n.degree, i64::from(n.attention_source))));
        let weights: Vec<i64> = match self.aggregation {
            NONE => Vec::new(),
            GCN => {
                let root = |d: u8| (32_768.0 / f64::from(d).sqrt()).round() as i64;
                around.iter().map(|(_, d, _)| (root(degree) * root(*d) + (1 << 14)) >> 15).collect()
            }
            GAT => shares(&around.iter().map(|(_, _, t)| leaky(attention_destination + t)).collect::<Vec<_>>()),
            GATV2 => {
                let receiver = self.ends.as_ref().map(|[receiver, _]| receiver.wide(&own)).expect("two ends");
                let score = |sent: &Vec<i64>| {
                    let sums = receiver.iter().zip(sent).map(|(l, r)| (*l).clamp(-511, 511) + r);
                    // Five times the leaky ReLU.
                    let fifths: Vec<i64> = sums.map(|x| x.max(5 * x)).collect();
                    self.attention.as_ref().expect("a").wide(&fifths)[0]
                };
                shares(&around.iter().map(|(sent, _, _)| score(sent)).collect::<Vec<_>>())
            }
            _ => {
                // Of the others alone, each alike.
                let others = around.len() as i64 - 1;
                let share = (32_768.0 / others as f64).round() as i64;
                std::iter::once(0).chain((0..others).map(|_| share)).collect()
            }
        };
        let mut joined = own;
        if self.aggregation != NONE {
            let mean: Vec<i64> = (0..self.widths[2])
                .map(|k| weights.iter().zip(&around).map(|(w, (h, _, _))| w * h[k]).sum())
                .map(|sum| requantise(sum, self.aggregate_multiplier).clamp(-127, 127))
                .collect();
            // Without a graph layer a rectifier is left of it.
            joined.extend(match &self.graph {
                Some(graph) => graph.rectified(&mean),
                None => mean.into_iter().map(|v| v.max(0)).collect(),
            });
        }
        self.output.wide(&self.head.rectified(&joined))
    }
}

/// Softmax of scores, Q15.
fn shares(scores: &[i64]) -> Vec<i64> {
    let top = *scores.iter().max().expect("oneself");
    let raw: Vec<i64> = scores.iter().map(|s| power(top - s)).collect();
    let total: i64 = raw.iter().sum();
    raw.iter().map(|w| ((w << 15) + total / 2) / total).collect()
}

impl PlainLayer {
    fn sums(&self, x: &[i64]) -> impl Iterator<Item = (i64, i64)> {
        let sums = self.weights.iter().zip(&self.biases).map(move |(row, bias)| {
            assert_eq!(row.len(), x.len());
            row.iter().zip(x).map(|(w, x)| w * x).sum::<i64>() + bias
        });
        sums.zip(&self.multipliers).map(|(s, &m)| (s, m))
    }

    fn rectified(&self, x: &[i64]) -> Vec<i64> {
        self.sums(x).map(|(s, m)| requantise(s, m).clamp(0, 127)).collect()
    }

    fn wide(&self, x: &[i64]) -> Vec<i64> {
        self.sums(x).map(|(s, m)| requantise(16 * s, m).clamp(-32_768, 32_767)).collect()
    }
}

/// `round(sum·m/2³²)`, halves up.
fn requantise(sum: i64, m: i64) -> i64 {
    ((i128::from(sum) * i128::from(m) + (1 << 31)) >> 32) as i64
}

/// Slope 6554/2¹⁵ below zero, rounded.
fn leaky(score: i64) -> i64 {
    if score < 0 { (score * 6554 + (1 << 14)) >> 15 } else { score }
}

/// `2^(16 − below/256)`: the fraction rounded, then halved `below/256` times.
pub fn power(below: i64) -> i64 {
    let fraction = (16.0 - (below % 256) as f64 / 256.0).exp2().round() as i64;
    fraction >> (below / 256).min(63)
}

/// FNV-1a, 64 bit.
pub fn fnv(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |h, &b| (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3))
}
