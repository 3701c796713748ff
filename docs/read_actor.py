#!/usr/bin/env python3
"""Reads an actor file of Covey and proves that it computes what it should.

    python3 docs/read_actor.py FILE [--signature CASES]

A second implementation of docs/actor-file.md and docs/actor.md: standard library
only, whole numbers only, not a line shared with the Rust code. It checks the CRC-32
and the content hash, recomputes the logits of the self-test vectors, and with
--signature the signature over the first CASES neighbourhoods (10,000 by convention,
which takes half a minute). Exit status 1 when the file is not a sound actor.
"""

import argparse
import struct
import sys
import zlib
from math import isqrt
from operator import mul
from typing import NamedTuple

MAGIC, VERSION, HEADER, TRAILER = b"COVEYACT", 1, 16, 4
COMPACT, CELLS, ACTIONS = 2, 100, 17
OBSERVATION = {COMPACT: 160, CELLS: 1116}
VELOCITY, MAX_ACTIVE = 24, 120
NEIGHBOURS, MAX_FEATURE, MAX_ROWS, MAX_BIAS = 16, 64, 128, 1 << 24
SELF_TESTS = 8
AGGREGATIONS = ("none", "gcn", "gat", "gatv2", "sage")
WIDTHS = ("observation", "hidden", "feature", "head", "actions")


class NotSound(Exception):
    """What is wrong with the file."""


def require(condition, what):
    if not condition:
        raise NotSound(what)


def clamp(value, low, high):
    return max(low, min(high, value))


def signed_bytes(data):
    return [b - 256 if b > 127 else b for b in data]


# The file.


class Record:
    """A postcard record, read from front to back."""

    def __init__(self, data):
        self.data, self.at = data, 0

    def take(self, length):
        self.at += length
        require(self.at <= len(self.data), "the record ends too early")
        return self.data[self.at - length : self.at]

    def varint(self, bits):
        value = 0
        for shift in range(0, bits, 7):
            byte = self.take(1)[0]
            value |= (byte & 127) << shift
            if byte < 128:
                require(value < 1 << bits, "a number in the record is too large")
                return value
        raise NotSound("a number in the record has too many bytes")

    def zigzag(self, bits):
        value = self.varint(bits)
        return value >> 1 if value & 1 == 0 else -(value >> 1) - 1

    def bytes(self):
        return self.take(self.varint(32))

    def text(self):
        try:
            return self.bytes().decode()
        except UnicodeDecodeError:
            raise NotSound("a text in the record is not UTF-8") from None


def body_of(file):
    """Checks the envelope and returns the body."""
    require(file[:8] == MAGIC[: len(file)], "it does not begin with COVEYACT")
    require(len(file) >= HEADER + TRAILER, "it is cut short")
    version, zero, length = struct.unpack_from("<HHI", file, 8)
    require(version == VERSION, f"it is of format version {version}, not {VERSION}")
    require(len(file) == HEADER + length + TRAILER, "its length is not what it says")
    (crc,) = struct.unpack_from("<I", file, HEADER + length)
    require(crc == zlib.crc32(file[: HEADER + length]), "its CRC-32 does not fit")
    require(zero == 0, "bytes 10 and 11 are not zero")
    return file[HEADER : HEADER + length]


class Provenance(NamedTuple):
    trainer: str
    scenario: str
    uavs: int
    seed: int
    episodes: int
    worlds: int
    float_coverage: int
    int8_coverage: int


class Body(NamedTuple):
    align: bytes
    weights: bytes
    tables: bytes
    observation: int
    aggregation: int
    widths: list
    tie_period: int
    aggregate_multiplier: int
    provenance: Provenance
    self_tests: bytes
    content_hash: int


def parse(data):
    r = Record(data)
    body = Body(
        r.bytes(), r.bytes(), r.bytes(),
        r.varint(16), r.varint(32), [r.varint(16) for _ in WIDTHS],
        r.varint(32), r.zigzag(32),
        Provenance(r.text(), r.text(), r.varint(16), r.varint(64), r.varint(32),
                   r.varint(32), r.varint(16), r.varint(16)),
        r.bytes(), r.varint(64),
    )  # fmt: skip
    require(r.at == len(data), "the record ends too late")
    require(not any(body.align), "the padding before the weights is not zero")
    require(body.observation in OBSERVATION, f"it wants observation form {body.observation}")
    require(body.aggregation < len(AGGREGATIONS), "its aggregation is unknown")
    observation, hidden, feature, head, actions = body.widths
    sound = observation == OBSERVATION[body.observation] and actions == ACTIONS
    sound &= 1 <= hidden <= MAX_ROWS and 1 <= head <= MAX_ROWS
    sound &= 2 <= feature <= MAX_FEATURE and feature % 2 == 0
    require(sound, f"its widths {body.widths} cannot be flown")
    require(body.aggregate_multiplier >= 0, "its aggregate multiplier is negative")
    return body


class Fnv:
    """FNV-1a, 64 bit."""

    def __init__(self):
        self.value = 0xCBF29CE484222325

    def write(self, data):
        for byte in data:
            self.value = (self.value ^ byte) * 0x100000001B3 % (1 << 64)


def content_hash(body):
    fnv = Fnv()
    fnv.write(struct.pack("<HB5HIi", body.observation, body.aggregation, *body.widths,
                          body.tie_period, body.aggregate_multiplier))  # fmt: skip
    fnv.write(body.weights)
    fnv.write(body.tables)
    return fnv.value


# The network.


def requantise(acc, multiplier):
    """round(acc·multiplier / 2³²), halves up."""
    return (acc * multiplier + (1 << 31)) >> 32


class Layer:
    """A dense layer, taken off the front of the weights and the tables."""

    def __init__(self, weights, tables, rows, columns):
        pair = 2 * (columns + columns % 2)
        packed = weights.take((rows + 1) // 2 * pair)
        self.weights = []
        for at in range(0, len(packed), pair):
            both = packed[at : at + pair]
            # Odd bytes are row a; even bytes are row b with the top bit turned over.
            self.weights.append(signed_bytes(both[1::2])[:columns])
            self.weights.append(signed_bytes(b ^ 128 for b in both[0::2])[:columns])
        self.take_tables(tables, rows)

    def take_tables(self, tables, rows):
        self.biases = struct.unpack(f"<{rows}i", tables.take(4 * rows))
        self.multipliers = struct.unpack(f"<{rows}i", tables.take(4 * rows))
        sound = all(abs(b) <= MAX_BIAS for b in self.biases) and min(self.multipliers) >= 0
        require(sound, "a bias or multiplier is out of bounds")

    def sums(self, x):
        return [sum(map(mul, w, x)) + b for w, b in zip(self.weights, self.biases)]

    def rectified(self, x):
        """int8 behind a ReLU, 0 to 127."""
        return [clamp(requantise(s, m), 0, 127) for s, m in zip(self.sums(x), self.multipliers)]

    def wide(self, x):
        """16 bits, in 1/256 of a doubling."""
        return [clamp(requantise(s << 4, m), -32768, 32767) for s, m in zip(self.sums(x), self.multipliers)]


class CellsLayer(Layer):
    """The first layer of an actor that observes cells: of each input the weights of all rows."""

    def __init__(self, weights, tables, rows, columns):
        padded = (rows + 7) // 8 * 8
        packed = weights.take(columns * padded)
        self.weights = [signed_bytes(packed[at : at + rows]) for at in range(0, len(packed), padded)]
        self.take_tables(tables, rows)

    def sums(self, x):
        factors = [(VELOCITY, x.east), (VELOCITY + 1, x.north)] + [(i, 127) for i in x.ones]
        return [sum(v * self.weights[i][r] for i, v in factors) + b for r, b in enumerate(self.biases)]


def root(square, halvings):
    """floor(square^(1/2^halvings))."""
    for _ in range(halvings):
        square = isqrt(square)
    return square


# round(2¹⁵/√d) for degrees 1 to 17, and round(2^(16 − k/256)) for k from 0 to 255.
INVERSE_ROOT = [(root((1 << 32) // d, 1) + 1) // 2 for d in range(1, NEIGHBOURS + 2)]
EXP2 = [(root(1 << (17 * 256 - k), 8) + 1) // 2 for k in range(256)]


def weight(below):
    """2^(−below/256), Q16."""
    return EXP2[below & 255] >> (below >> 8)


def leaky(score):
    return (score * 6554 + (1 << 14)) >> 15 if score < 0 else score


class Feature(NamedTuple):
    own: list
    values: list
    attending: int
    attended: int


class Cells(NamedTuple):
    """An observation in cells: the velocity, and the inputs that are one."""

    east: int
    north: int
    ones: list


class Neighbour(NamedTuple):
    degree: int
    attended: int
    values: list


class Actor:
    def __init__(self, body):
        observation, hidden, self.feature, head, actions = body.widths
        self.aggregation = AGGREGATIONS[body.aggregation]
        self.form = body.observation
        self.multiplier = body.aggregate_multiplier
        self.graphed = self.aggregation != "none"
        weights, tables = Record(body.weights), Record(body.tables)

        def layer(rows, columns):
            return Layer(weights, tables, rows, columns)

        first = CellsLayer if self.form == CELLS else Layer
        self.encoder = [first(weights, tables, hidden, observation), layer(self.feature, hidden)]
        v2 = self.aggregation == "gatv2"
        self.receiver, self.sender = (layer(self.feature, self.feature) if v2 else None for _ in range(2))
        self.attention = layer(1 if v2 else 2, self.feature) if self.aggregation in ("gat", "gatv2") else None
        self.graph = layer(self.feature, self.feature) if self.graphed and not v2 else None
        self.head = layer(head, (1 + self.graphed) * self.feature)
        self.output = layer(actions, head)
        require(weights.at == len(body.weights) and tables.at == len(body.tables), "weights or tables are left over")

    def encode(self, observation):
        h = self.encoder[1].rectified(self.encoder[0].rectified(observation))
        if self.aggregation == "gatv2":
            return Feature(h, [clamp(v, -127, 127) for v in self.sender.wide(h)], 0, 0)
        attending, attended = self.attention.wide(h) if self.attention else (0, 0)
        return Feature(h, h, attending, attended)

    def shares(self, own, degree, neighbours):
        """Q15 weights of the own feature and of each neighbour's."""
        if self.aggregation == "gcn":
            roots = [INVERSE_ROOT[clamp(d, 1, 17) - 1] for d in [degree] + [n.degree for n in neighbours]]
            return [(roots[0] * r + (1 << 14)) >> 15 for r in roots]
        if self.aggregation == "sage":
            count = max(len(neighbours), 1)
            return [0] + [((1 << 15) + count // 2) // count] * len(neighbours)
        if self.aggregation == "gatv2":
            received = [clamp(v, -511, 511) for v in self.receiver.wide(own.own)]
            scores = [self.score(received, sent) for sent in [own.values] + [n.values for n in neighbours]]
        else:
            scores = [leaky(own.attending + a) for a in [own.attended] + [n.attended for n in neighbours]]
        weights = [weight(max(scores) - s) for s in scores]
        total = sum(weights)
        return [((w << 15) + total // 2) // total for w in weights]

    def score(self, received, sent):
        """Of a neighbour, with a leaky ReLU times five."""
        sums = [left + right for left, right in zip(received, sent)]
        return self.attention.wide([x if x < 0 else 5 * x for x in sums])[0]

    def logits(self, own, degree, neighbours):
        joined = own.own
        if self.graphed:
            shares = self.shares(own, degree, neighbours)
            channels = zip(own.values, *(n.values for n in neighbours))
            sums = [sum(map(mul, shares, h)) for h in channels]
            combined = [clamp(requantise(s, self.multiplier), -127, 127) for s in sums]
            joined = own.own + (self.graph.rectified(combined) if self.graph else [max(c, 0) for c in combined])
        return self.output.wide(self.head.rectified(joined))


def sample(logits, draw):
    """The action that a 32-bit draw picks."""
    weights = [weight(max(logits) - logit) for logit in logits]
    left = draw * sum(weights) >> 32
    for action, w in enumerate(weights):
        if left < w:
            return action
        left -= w


# Proof.


def observed(r, form):
    """The observation that a self-test vector begins with."""
    if form == COMPACT:
        return signed_bytes(r.take(OBSERVATION[COMPACT]))
    (count,) = r.take(1)
    east, north = signed_bytes(r.take(2))
    ones = struct.unpack(f"<{count}H", r.take(2 * count))
    right = all(i < OBSERVATION[CELLS] and i not in (VELOCITY, VELOCITY + 1) for i in ones)
    require(count <= MAX_ACTIVE and right, "a self-test vector is malformed")
    return Cells(east, north, ones)


def self_test(actor, data):
    """Recomputes the vectors of the file; returns how many there are."""
    r, count = Record(data), 0
    while r.at < len(data):
        observation = observed(r, actor.form)
        degree, neighbours = r.take(2)
        require(1 <= degree <= NEIGHBOURS + 1 and neighbours <= NEIGHBOURS, "a self-test vector is malformed")
        heard = []
        for _ in range(neighbours):
            of, attended = struct.unpack("<Bh", r.take(3))
            heard.append(Neighbour(of, attended, signed_bytes(r.take(actor.feature))))
        wanted = list(struct.unpack(f"<{ACTIONS}h", r.take(2 * ACTIONS)))
        logits = actor.logits(actor.encode(observation), degree, heard)
        require(logits == wanted, f"self-test vector {count} gives {logits}, not {wanted}")
        count += 1
    require(count == SELF_TESTS, f"it has {count} self-test vectors, not {SELF_TESTS}")
    return count


class Xoshiro128:
    """xoshiro128++ of Blackman and Vigna, seeded by SplitMix64."""

    def __init__(self, seed):
        self.s = []
        for _ in range(2):
            seed = (seed + 0x9E3779B97F4A7C15) % (1 << 64)
            z = (seed ^ (seed >> 30)) * 0xBF58476D1CE4E5B9 % (1 << 64)
            z = (z ^ (z >> 27)) * 0x94D049BB133111EB % (1 << 64)
            z ^= z >> 31
            self.s += [z & 0xFFFFFFFF, z >> 32]

    def next(self):
        def rotate(x, k):
            return (x << k | x >> (32 - k)) & 0xFFFFFFFF

        a, b, c, d = self.s
        result = (rotate((a + d) & 0xFFFFFFFF, 7) + a) & 0xFFFFFFFF
        c, d, t = c ^ a, d ^ b, b << 9 & 0xFFFFFFFF
        self.s = [a ^ d, b ^ c, c ^ t, rotate(d, 11)]
        return result


def drawn(random, form):
    """A pseudo-random observation."""
    if form == COMPACT:
        draws = [random.next() for _ in range(OBSERVATION[COMPACT])]
        seen = signed_bytes(r >> 8 & 255 for r in draws)
        return [0 if r & 3 == 0 else max(o, -127) for r, o in zip(draws, seen)]

    def below(n):
        return random.next() * n >> 32

    east, north = below(255) - 127, below(255) - 127
    ones = [below(OBSERVATION[CELLS] - 2) for _ in range(below(MAX_ACTIVE + 1))]
    return Cells(east, north, [i if i < VELOCITY else i + 2 for i in ones])


def signature(actor, cases):
    fnv = Fnv()
    for case in range(cases):
        random = Xoshiro128(0x5160_0000_0000 | case)
        own = actor.encode(drawn(random, actor.form))
        heard = []
        for _ in range(case % (NEIGHBOURS + 1)):
            values = [random.next() >> 25 for _ in range(MAX_FEATURE)][: actor.feature]
            r = random.next()
            # The upper half as a signed number, over 16, towards zero.
            upper = (r >> 16) - (r >> 31 << 16)
            heard.append(Neighbour(1 + r % 17, upper // 16 if upper >= 0 else -(-upper // 16), values))
        logits = actor.logits(own, len(heard) + 1, heard)
        fnv.write(bytes(v & 255 for v in own.values).ljust(MAX_FEATURE, b"\0"))
        fnv.write(struct.pack("<2h17hB", own.attending, own.attended, *logits, sample(logits, random.next())))
    return fnv.value


def main():
    arguments = argparse.ArgumentParser(description="Reads an actor file of Covey and checks it.")
    arguments.add_argument("file", metavar="FILE")
    arguments.add_argument("--signature", metavar="CASES", type=int, default=0)
    args = arguments.parse_args()
    try:
        with open(args.file, "rb") as f:
            data = f.read()
        body = parse(body_of(data))
        actor = Actor(body)
        tests = self_test(actor, body.self_tests)
        own_hash = content_hash(body)
        require(own_hash == body.content_hash, "its content hash is not that of its content")
    except (OSError, NotSound) as error:
        sys.exit(f"{args.file}: not a sound actor: {error}")
    p = body.provenance
    lines = [
        f"file          {args.file}: a sound actor, {len(data)} bytes",
        f"aggregation   {actor.aggregation}",
        f"widths        {' '.join(map(str, body.widths))}",
        f"tie period    {body.tie_period}",
        f"content hash  {own_hash:016x}, in messages {(own_hash ^ own_hash >> 32) & 0xFFFFFFFF:08x}",
        f"self-test     {tests} of {tests} vectors give the same logits",
        f"trained by    {p.trainer} on {p.scenario}, {p.uavs} UAVs, seed {p.seed}, {p.episodes} episodes",
        f"coverage      {p.int8_coverage}/10000 int8, {p.float_coverage}/10000 float, {p.worlds} worlds",
    ]
    if args.signature:
        lines.append(f"signature     {signature(actor, args.signature):016x} over {args.signature} cases")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
