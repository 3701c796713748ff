"""Neighbour messages inside MAVLink's V2_EXTENSION."""

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from simlink.endpoint import Endpoint
from simlink.neighbours import message
from simlink.neighbours.message import Message, MessageError

MESSAGE_TYPE = 0xC056
COMPONENT = mavlink.MAV_COMP_ID_ONBOARD_COMPUTER
MAX_ID = 254
_ROOM = 249


def endpoint_of(identity: int, key: bytes | None = None) -> Endpoint:
    """The MAVLink sender of a UAV: its system is its id plus one."""
    if not 0 <= identity <= MAX_ID:
        raise ValueError(f"id {identity} cannot fly over MAVLink; ids go from 0 to {MAX_ID}")
    return Endpoint(identity + 1, COMPONENT, key)


def wrap(endpoint: Endpoint, data: bytes) -> bytes:
    """The frame that carries the bytes of a message to everybody."""
    payload = list(data) + [0] * (_ROOM - len(data))
    return endpoint.pack(mavlink.MAVLink_v2_extension_message(0, 0, 0, MESSAGE_TYPE, payload))


def unwrap(frame: mavlink.MAVLink_message) -> Message | None:
    """The neighbour message in a frame; None when it carries none; MessageError when it is a wrong one.

    MAVLink leaves zeros at the end out, so the length is the one that the message's head names.
    """
    if frame.get_msgId() != mavlink.MAVLINK_MSG_ID_V2_EXTENSION or frame.message_type != MESSAGE_TYPE:
        return None
    data = bytes(frame.payload)
    end = message.length(data)
    if any(data[end:]):
        raise MessageError("too_long", f"bytes after the {end} of the message")
    decoded = message.decode(data[:end])
    if decoded.id + 1 != frame.get_srcSystem():
        raise MessageError("spoofed_id", f"id {decoded.id} in a frame of system {frame.get_srcSystem()}")
    return decoded
