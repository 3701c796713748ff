"""Neighbour messages: the documented bytes, the checker, the ghosts."""

import json
import os
import random
import socket
import subprocess
import sys
import tempfile
import unittest

from simlink.neighbours import frames, message
from simlink.neighbours.checker import Checker
from simlink.neighbours.ghosts import KINDS, Ghost
from simlink.neighbours.link import AddressError, SwarmAddress, SwarmSocket
from simlink.neighbours.message import Beacon, Feature, MessageError

BEACON = Beacon(7, 65_535, 42, 84_000, 102_400, -1536, 4096, -512, -100)
FEATURE = Feature(9, 1, 43, 1, 0x0123_4567, 0, (-128, 0, 127))
# As docs/messages.md prints them.
BEACON_BYTES = bytes.fromhex("01010700ffff2a000000204801000090010000faffff001000fe9c")
FEATURE_BYTES = bytes.fromhex("0102090001002b000000016745230100000380007f")
KEY, OTHER_KEY = bytes(range(32)), bytes(32)


class Layout(unittest.TestCase):
    def test_the_documented_bytes(self):
        self.assertEqual(BEACON.encode(), BEACON_BYTES)
        self.assertEqual(FEATURE.encode(), FEATURE_BYTES)
        self.assertEqual(message.decode(BEACON_BYTES), BEACON)
        self.assertEqual(message.decode(FEATURE_BYTES), FEATURE)

    def test_what_is_written_is_read_back(self):
        r = random.Random(1)
        for _ in range(300):
            beacon = Beacon(
                r.randrange(1 << 16),
                r.randrange(1 << 16),
                r.randrange(1 << 32),
                r.randrange(1 << 32),
                r.randint(-(1 << 28), 1 << 28),
                r.randint(-(1 << 28), 1 << 28),
                r.randint(-32_768, 32_767),
                r.randint(-32_768, 32_767),
                r.randint(-127, 127),
            )
            values = tuple(r.randint(-128, 127) for _ in range(r.randint(1, 64)))
            feature = Feature(
                r.randrange(1 << 16),
                r.randrange(1 << 16),
                r.randrange(1 << 32),
                r.randint(1, 17),
                r.randrange(1 << 32),
                r.randint(-32_768, 32_767),
                values,
            )
            for m in (beacon, feature):
                self.assertEqual(message.decode(m.encode()), m)

    def test_what_is_no_message_is_refused_with_a_reason(self):
        beacon, feature = bytearray(BEACON_BYTES), bytearray(FEATURE_BYTES)

        def changed(data: bytes, at: int, *to: int) -> bytes:
            return data[:at] + bytes(to) + data[at + len(to) :]

        for data, reason in (
            (b"", "too_short"),
            (b"\1", "too_short"),
            (beacon[:-1], "too_short"),
            (beacon + b"\0", "too_long"),
            (feature[:-1], "too_short"),
            (feature + b"\0", "too_long"),
            (feature[:10], "too_short"),
            (changed(beacon, 0, 2), "version"),
            (changed(beacon, 1, 3), "kind"),
            (changed(beacon, 14, 1, 0, 0, 16), "position"),
            (changed(beacon, 26, 0x80), "tie"),
            (changed(feature, 10, 0), "degree"),
            (changed(feature, 10, 18), "degree"),
            (changed(feature, 17, 0), "width"),
            (changed(feature, 17, 65), "width"),
        ):
            with self.assertRaises(MessageError) as caught:
                message.decode(bytes(data))
            self.assertEqual(caught.exception.reason, reason, data.hex())

    def test_what_the_layout_cannot_hold_is_not_written(self):
        for wrong in (
            Beacon(1, 1, 1, 1, 1 << 29, 0, 0, 0, 0),
            Beacon(1, 1, 1, 1, 0, 0, 0, 0, -128),
            Beacon(70_000, 1, 1, 1, 0, 0, 0, 0, 0),
            Feature(1, 1, 1, 0, 1, 0, (1,)),
            Feature(1, 1, 1, 1, 1, 0, ()),
            Feature(1, 1, 1, 1, 1, 0, (200,)),
        ):
            with self.assertRaises(MessageError):
                wrong.encode()


class Frames(unittest.TestCase):
    def test_zeros_at_the_end_survive(self):
        # MAVLink leaves them out on the way.
        ending = Feature(9, 1, 43, 1, 1, 0, (5, 0, 0, 0))
        for sent in (ending, Beacon(9, 0, 0, 0, 0, 0, 0, 0, 0)):
            frame = frames.wrap(frames.endpoint_of(9), sent.encode())
            self.assertLess(len(frame), 12 + 5 + len(sent.encode()))
            self.assertEqual(Checker().check(frame), [sent])

    def test_the_sender_in_the_frame_must_be_the_one_in_the_message(self):
        checker = Checker()
        self.assertEqual(checker.check(frames.wrap(frames.endpoint_of(8), BEACON_BYTES)), [])
        self.assertEqual(checker.rejected, {"spoofed_id": 1})

    def test_ids_that_mavlink_has_no_system_for_are_refused(self):
        self.assertEqual(frames.endpoint_of(254).system, 255)
        with self.assertRaises(ValueError):
            frames.endpoint_of(255)

    def test_signatures(self):
        signed = frames.wrap(frames.endpoint_of(7, KEY), BEACON_BYTES)
        checker = Checker(KEY)
        self.assertEqual(checker.check(signed), [BEACON])
        self.assertEqual(checker.check(signed), [], "a replay")
        self.assertEqual(checker.check(frames.wrap(frames.endpoint_of(7, OTHER_KEY), BEACON_BYTES)), [])
        self.assertEqual(checker.check(frames.wrap(frames.endpoint_of(7), BEACON_BYTES)), [])
        self.assertEqual(checker.report()["unauthentic"], 3)


class Swarm:
    """A sound swarm, step by step."""

    def __init__(self, *ids: int, key: bytes | None = None) -> None:
        self.ids = ids
        self.endpoints = {i: frames.endpoint_of(i, key) for i in ids}
        self.step = 65_530

    def datagrams(self, steps: int):
        for _ in range(steps):
            for i in self.ids:
                x, y = 1024 * i + 2048 * (self.step % 100), 1024 * i
                yield self.wrap(Beacon(i, self.step & 0xFFFF, self.step, self.step * 2000, x, y, 2048, 0, i))
            for i in self.ids:
                yield self.wrap(Feature(i, self.step & 0xFFFF, self.step, 2, 0xC0FFEE, 3, (i, 2, 3)))
            self.step += 1

    def wrap(self, m: message.Message) -> bytes:
        return frames.wrap(self.endpoints[m.id], m.encode())


class Checking(unittest.TestCase):
    def test_a_sound_swarm(self):
        checker = Checker(step_ms=2000)
        for datagram in Swarm(1, 2, 3).datagrams(20):
            checker.check(datagram)
        report = checker.report()
        self.assertTrue(report["sound"], report)
        self.assertEqual(
            report["senders"]["2"], {"beacons": 20, "features": 20, "lost": 0, "repeated": 0, "steps": [65_530, 65_549]}
        )
        self.assertEqual((report["actors"], report["widths"]), (["00c0ffee"], [3]))

    def test_losses_are_counted_and_no_fault(self):
        checker = Checker(step_ms=2000)
        for at, datagram in enumerate(Swarm(1).datagrams(20)):
            if at not in (4, 6, 11):
                checker.check(datagram)
        self.assertEqual(checker.senders[1].lost, 3)

    def test_each_wrong_thing_has_its_name(self):
        def beacon(**changes):
            fields = dict(id=1, sequence=70, step=100, time_ms=200_000, x=0, y=0, vx=0, vy=0, tie=0) | changes
            return Beacon(**fields)

        def feature(**changes):
            fields = dict(id=1, sequence=70, step=100, degree=1, actor=5, attended=0, values=(1, 2)) | changes
            return Feature(**fields)

        good = [beacon(sequence=69, step=99, time_ms=198_000), beacon(), feature()]
        for wrong, name in (
            (beacon(tie=5), "id_collision"),
            (beacon(sequence=3), "old_sequence"),
            (beacon(sequence=71, step=101, time_ms=202_000, vx=7000), "too_fast"),
            (beacon(sequence=71, step=101, time_ms=202_000, x=20_000), "teleport"),
            (beacon(sequence=71, step=98, time_ms=196_000), "clock_back"),
            (beacon(sequence=71, step=101, time_ms=210_000), "clock"),
            (feature(sequence=71), "second_feature"),
            (feature(sequence=71, step=99), "step_back"),
            (feature(sequence=71, step=101), "feature_without_beacon"),
            (feature(sequence=71, actor=6), "foreign_actor"),
            (feature(sequence=71, values=(1,)), "foreign_width"),
        ):
            checker, endpoint = Checker(step_ms=2000), frames.endpoint_of(1)
            for m in (*good, wrong):
                checker.check(frames.wrap(endpoint, m.encode()))
            self.assertIn(name, checker.report()["wrong"], wrong)
            self.assertFalse(checker.report()["sound"])


class Ghosts(unittest.TestCase):
    def haunted(self, kind: str, steps: int = 12, key: bytes | None = None, **options) -> dict:
        """What the checker says about a swarm with this ghost."""
        checker = Checker(key, step_ms=2000)
        ghost = Ghost(kind, key=key, **options)
        sent = 0
        for datagram in Swarm(1, 2, key=key).datagrams(steps):
            checker.check(datagram)
            for answer in ghost.receive(datagram):
                sent += 1
                checker.check(answer)
                self.assertEqual(ghost.receive(answer), [], "it does not talk to itself")
        self.assertGreater(sent, 3)
        return checker.report()

    def test_a_mere_ghost_is_a_sound_neighbour(self):
        report = self.haunted("ghost")
        self.assertTrue(report["sound"], report)
        self.assertEqual(report["senders"]["200"]["beacons"], 12)
        self.assertEqual(report["senders"]["200"]["features"], 12)

    def test_the_others_are_found_out(self):
        self.assertIn("id_collision", self.haunted("id-collision", id=1)["wrong"])
        self.assertIn("foreign_actor", self.haunted("foreign-actor")["wrong"])
        self.assertIn("teleport", self.haunted("teleport")["wrong"])
        self.assertIn("old_sequence", self.haunted("replay")["wrong"])
        corrupt = self.haunted("corrupt", steps=40)
        self.assertGreater(corrupt["damaged"], 20)
        self.assertEqual(corrupt["senders"]["1"]["beacons"], 40, "the sound ones still count")

    def test_in_a_signed_swarm(self):
        self.assertGreater(self.haunted("unsigned", key=KEY)["unauthentic"], 10)
        self.assertGreater(self.haunted("replay", key=KEY)["unauthentic"], 10)
        self.assertTrue(self.haunted("ghost", key=KEY)["sound"])

    def test_a_seed_says_all(self):
        def said(seed: int) -> list[bytes]:
            ghost = Ghost("corrupt", seed=seed)
            return [answer for datagram in Swarm(1, 2).datagrams(5) for answer in ghost.receive(datagram)]

        self.assertEqual(said(4), said(4))
        self.assertNotEqual(said(4), said(5))

    def test_there_is_no_other_kind(self):
        with self.assertRaisesRegex(ValueError, "poltergeist"):
            Ghost("poltergeist")
        self.assertEqual(len(KINDS), 7)


class Link(unittest.TestCase):
    def test_addresses(self):
        multicast = SwarmAddress.read("multicast:239.86.67.1:14600@127.0.0.1")
        self.assertEqual((multicast.listen, multicast.interface), (("239.86.67.1", 14_600), "127.0.0.1"))
        broadcast = SwarmAddress.read("broadcast://192.168.4.255:14600")
        self.assertEqual(broadcast.listen, ("0.0.0.0", 14_600))
        peers = SwarmAddress.read("peers:0.0.0.0:14600,192.168.4.3:14600, 192.168.4.4:14601")
        self.assertEqual(peers.to, (("192.168.4.3", 14_600), ("192.168.4.4", 14_601)))
        for wrong in (
            "",
            "udp:1.2.3.4:5",
            "multicast:10.0.0.1:5",
            "peers:1.2.3.4",
            "broadcast:x:1",
            "peers:1.2.3.4:99999",
        ):
            with self.assertRaises(AddressError, msg=wrong):
                SwarmAddress.read(wrong)

    def test_peers_hear_each_other(self):
        one = SwarmSocket(SwarmAddress.read("peers:127.0.0.1:0"))
        port = one.listens_on[1]
        two = SwarmSocket(SwarmAddress.read(f"peers:127.0.0.1:0,127.0.0.1:{port}"))
        two.send(b"hello")
        # It lies in the other's queue by now.
        self.assertEqual(one.receive(0.0), b"hello")
        one.close()
        two.close()

    def test_the_command_line_listens_and_judges(self):
        with tempfile.NamedTemporaryFile("w", suffix=".key") as key:
            key.write(KEY.hex())
            key.flush()
            os.chmod(key.name, 0o600)
            command = [sys.executable, "-m", "simlink.neighbours", "listen", "peers:127.0.0.1:0"]
            command += ["--messages", "12", "--seconds", "3600", "--key-file", key.name, "--json", "--step-ms", "2000"]
            listener = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
            port = int(listener.stderr.readline().rsplit(":", 1)[1])
            with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as s:
                for datagram in Swarm(1, 2, key=KEY).datagrams(3):
                    s.sendto(datagram, ("127.0.0.1", port))
            out, err = listener.communicate()
        report = json.loads(out)
        self.assertEqual((listener.returncode, report["sound"]), (0, True), report)
        self.assertEqual(report["senders"]["1"]["beacons"], 3)
        self.assertNotIn(KEY.hex(), out + err)
        self.assertEqual(err, "", "it says nothing more")
