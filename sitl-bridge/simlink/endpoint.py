"""One MAVLink identity: packs what it sends, unpacks whole datagrams, signs and checks when it has a key."""

import time
from collections.abc import Iterator

from pymavlink.dialects.v20 import ardupilotmega as mavlink

_V1, _V2 = mavlink.PROTOCOL_MARKER_V1, mavlink.PROTOCOL_MARKER_V2
_SIGNED = mavlink.MAVLINK_IFLAG_SIGNED

_SIGNING_EPOCH_S = 1_420_070_400
"""2015-01-01, where the clock of MAVLink 2 signatures begins."""


class Endpoint:
    """A sender and receiver. With a key it signs everything and takes only what is signed with it."""

    def __init__(self, system: int, component: int, key: bytes | None = None, clock=time.time) -> None:
        self._mav = mavlink.MAVLink(None, srcSystem=system, srcComponent=component)
        self._clock = clock
        self.system, self.component = system, component
        self.received = self.damaged = self.unauthentic = 0
        if key is not None:
            self._mav.signing.secret_key = key
            self._mav.signing.sign_outgoing = True
            self.refresh_signing_clock()

    def refresh_signing_clock(self) -> None:
        """pymavlink's timestamp only counts frames; without this an idle sender would look older and older."""
        signing = self._mav.signing
        signing.timestamp = max(signing.timestamp, int((self._clock() - _SIGNING_EPOCH_S) * 100_000))

    def pack(self, message: mavlink.MAVLink_message) -> bytes:
        """The frame of a message, with the next sequence number."""
        frame = message.pack(self._mav)
        self._mav.seq = (self._mav.seq + 1) & 0xFF
        return frame

    def unpack(self, datagram: bytes) -> Iterator[mavlink.MAVLink_message]:
        """The messages in a datagram. Nothing is kept between datagrams, so a damaged one harms only itself."""
        at, end = 0, len(datagram)
        while at < end:
            length = _frame_length(datagram, at)
            if length is None or at + length > end:
                self.damaged += length is not None
                at += 1
                continue
            message = self._decode(datagram[at : at + length])
            if message is None:
                at += 1
                continue
            at += length
            self.received += 1
            yield message

    def _decode(self, frame: bytes) -> mavlink.MAVLink_message | None:
        streams = self._mav.signing.stream_timestamps
        stream = (frame[-13], frame[5], frame[6]) if frame[0] == _V2 and frame[2] & _SIGNED else None
        before = streams.get(stream)
        try:
            message = self._mav.decode(bytearray(frame))
            # Of a message it does not know pymavlink cannot check anything.
            return None if isinstance(message, mavlink.MAVLink_unknown) else message
        except mavlink.MAVError as error:
            if "signature" not in str(error):
                self.damaged += 1
                return None
        self.unauthentic += 1
        # pymavlink moves the stream's timestamp on before it checks the signature: a forged one would
        # shut the true sender out.
        if stream is not None:
            if before is None:
                streams.pop(stream, None)
            else:
                streams[stream] = before
        return None


def _frame_length(datagram: bytes, at: int) -> int | None:
    """Length of the frame that seems to begin at `at`; none when none does."""
    left = len(datagram) - at
    if datagram[at] == _V2 and left >= 12 and not datagram[at + 2] & ~_SIGNED:
        return datagram[at + 1] + 12 + (13 if datagram[at + 2] & _SIGNED else 0)
    if datagram[at] == _V1 and left >= 8:
        return datagram[at + 1] + 8
    return None
