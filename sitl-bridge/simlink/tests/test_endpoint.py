"""Frames: damaged ones, several in a datagram, signatures, keys."""

import hashlib
import os
import random
import tempfile
import unittest

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from simlink.endpoint import Endpoint
from simlink.signing import KeyFileError, read_key

KEY, OTHER = bytes(range(32)), bytes(reversed(range(32)))


def heartbeat(number: int = 0) -> mavlink.MAVLink_message:
    return mavlink.MAVLink_heartbeat_message(18, 8, 0, number, 4, 3)


def numbers(endpoint: Endpoint, datagram: bytes) -> list[int]:
    return [message.custom_mode for message in endpoint.unpack(datagram)]


class Clock:
    def __init__(self, now: float = 1_800_000_000.0) -> None:
        self.now = now

    def __call__(self) -> float:
        return self.now


class Datagrams(unittest.TestCase):
    def test_it_is_pymavlink_that_packs(self):
        endpoint, mav = Endpoint(3, 1), mavlink.MAVLink(None, srcSystem=3, srcComponent=1)
        for number in range(300):
            frame = endpoint.pack(heartbeat(number))
            self.assertEqual(frame, heartbeat(number).pack(mav))
            mav.seq = (mav.seq + 1) % 256

    def test_several_frames_and_noise_in_one_datagram(self):
        sender, receiver = Endpoint(3, 1), Endpoint(4, 1)
        datagram = b"\xfd\x00noise" + sender.pack(heartbeat(1)) + b"\xfe\xfd\xff" + sender.pack(heartbeat(2))
        self.assertEqual(numbers(receiver, datagram), [1, 2])

    def test_a_damaged_datagram_harms_only_itself(self):
        r = random.Random(1)
        sender, receiver = Endpoint(3, 1), Endpoint(4, 1)
        for _ in range(500):
            frame = bytearray(sender.pack(heartbeat(7)))
            frame[r.randrange(len(frame))] ^= 1 << r.randrange(8)
            cut = bytes(frame[: r.randrange(len(frame))])
            self.assertEqual(numbers(receiver, bytes(frame)), [])
            self.assertEqual(numbers(receiver, cut), [])
            self.assertEqual(numbers(receiver, sender.pack(heartbeat(9))), [9])

    def test_any_bytes_are_borne(self):
        r, receiver = random.Random(2), Endpoint(4, 1)
        for _ in range(2000):
            noise = bytes(r.choice((0xFD, 0xFE, 0, r.randrange(256))) for _ in range(r.randrange(80)))
            list(receiver.unpack(noise))

    def test_mavlink_1_is_read(self):
        mav = mavlink.MAVLink(None, srcSystem=3, srcComponent=1)
        self.assertEqual(numbers(Endpoint(4, 1), heartbeat(5).pack(mav, force_mavlink1=True)), [5])


class Signing(unittest.TestCase):
    def test_only_the_right_key_counts(self):
        receiver = Endpoint(4, 1, KEY, Clock())
        self.assertEqual(numbers(receiver, Endpoint(3, 1, KEY, Clock()).pack(heartbeat(1))), [1])
        self.assertEqual(numbers(receiver, Endpoint(3, 1, OTHER, Clock(1_800_000_001)).pack(heartbeat(2))), [])
        self.assertEqual(numbers(receiver, Endpoint(3, 1).pack(heartbeat(3))), [])
        self.assertEqual(receiver.unauthentic, 2)

    def test_replays_and_old_frames_do_not_count(self):
        receiver = Endpoint(4, 1, KEY, Clock())
        frame = Endpoint(3, 1, KEY, Clock()).pack(heartbeat(1))
        self.assertEqual(numbers(receiver, frame), [1])
        self.assertEqual(numbers(receiver, frame), [])
        old = Endpoint(5, 1, KEY, Clock(1_800_000_000.0 - 90)).pack(heartbeat(1))
        self.assertEqual(numbers(receiver, old), [], "90 s old, from a sender not heard before")

    def test_a_forged_timestamp_shuts_nobody_out(self):
        receiver, sender = Endpoint(4, 1, KEY, Clock()), Endpoint(3, 1, KEY, Clock())
        self.assertEqual(numbers(receiver, sender.pack(heartbeat(1))), [1])
        forged = bytearray(Endpoint(3, 1, OTHER, Clock(1_900_000_000.0)).pack(heartbeat(2)))
        self.assertEqual(numbers(receiver, bytes(forged)), [])
        self.assertEqual(numbers(receiver, sender.pack(heartbeat(3))), [3])

    def test_an_idle_sender_does_not_grow_old(self):
        clock = Clock()
        receiver, sender = Endpoint(4, 1, KEY, clock), Endpoint(3, 1, KEY, clock)
        clock.now += 3600
        for endpoint in (receiver, sender):
            endpoint.refresh_signing_clock()
        self.assertEqual(numbers(receiver, sender.pack(heartbeat(1))), [1])

    def test_a_clock_that_goes_back_does_not_silence_a_sender(self):
        clock = Clock()
        receiver, sender = Endpoint(4, 1, KEY, Clock()), Endpoint(3, 1, KEY, clock)
        self.assertEqual(numbers(receiver, sender.pack(heartbeat(1))), [1])
        clock.now -= 1000
        sender.refresh_signing_clock()
        self.assertEqual(numbers(receiver, sender.pack(heartbeat(2))), [2])


class KeyFiles(unittest.TestCase):
    def read(self, content: bytes, mode: int = 0o600) -> bytes:
        with tempfile.NamedTemporaryFile() as file:
            file.write(content)
            file.flush()
            os.chmod(file.name, mode)
            return read_key(file.name)

    def test_digits_and_passphrases(self):
        self.assertEqual(self.read(KEY.hex().upper().encode() + b"\n"), KEY)
        self.assertEqual(self.read(b"correct horse\n"), hashlib.sha256(b"correct horse").digest())

    def test_what_is_no_key_is_refused_without_telling_it(self):
        for content, mode, word in (
            (KEY.hex().encode(), 0o644, "chmod 600"),
            (KEY.hex().encode()[:-1], 0o600, "63"),
            (b"  \n", 0o600, "empty"),
            (b"\xff\xfe", 0o600, "no text"),
        ):
            with self.assertRaisesRegex(KeyFileError, word) as caught:
                self.read(content, mode)
            self.assertNotIn(KEY.hex()[:32], str(caught.exception))
        with self.assertRaisesRegex(KeyFileError, "cannot read"):
            read_key("/no/such/file")
