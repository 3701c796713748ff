"""The other side of tests/mavsdk.rs: MAVSDK, with bytes in place of a network.

Frames come on stdin, a heartbeat first. One JSON object goes to stdout: the messages that MAVSDK heard, and the bytes
that it sent.
"""

import json
import os
import sys
import threading

# MAVSDK logs to stdout.
OUT = os.fdopen(os.dup(1), "w")
os.dup2(2, 1)

from mavsdk import ComponentType, Configuration, Mavsdk  # noqa: E402
from mavsdk.plugins.mavlink_direct import MavlinkDirect, MavlinkMessage  # noqa: E402

PATIENCE_S = 30.0
"""Nothing takes so long unless it is broken."""

HEARTBEAT_ID, SETPOINT_ID = 0, 84
SETPOINT = {
    "time_boot_ms": 84000,
    "coordinate_frame": 1,
    "type_mask": 3079,
    "x": 0.0,
    "y": 0.0,
    "z": 0.0,
    "vx": 4.5,
    "vy": -4.5,
    "vz": 0.25,
    "afx": 1.25,
    "afy": -1.25,
    "afz": 0.0,
    "yaw": 0.0,
    "yaw_rate": 0.0,
}


def main():
    frames = sys.stdin.buffer.read()
    heartbeat = 10 + frames[1] + 2
    mavsdk = Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION))
    mavsdk.add_any_connection("raw://")
    sent, heard = [], []
    found, done, gone = threading.Event(), threading.Event(), threading.Event()

    def send(data):
        sent.append(data)
        if {HEARTBEAT_ID, SETPOINT_ID} <= {int.from_bytes(frame[7:10], "little") for frame in sent}:
            gone.set()

    mavsdk.subscribe_raw_bytes_to_be_sent(send)
    mavsdk.subscribe_on_new_system(lambda *_: found.set())
    mavsdk.pass_received_raw_bytes(frames[:heartbeat])
    found.wait(PATIENCE_S)
    system = mavsdk.get_systems()[0]
    direct = MavlinkDirect(system)

    def hear(message, *_):
        heard.append(
            {
                "type": message.message_name,
                "system": message.system_id,
                "component": message.component_id,
                "fields": json.loads(message.fields_json),
            }
        )
        if message.message_name == "COMMAND_ACK":
            done.set()

    direct.subscribe_message("", hear)
    mavsdk.pass_received_raw_bytes(frames[heartbeat:])
    # The last frame is a COMMAND_ACK.
    done.wait(PATIENCE_S)
    system_id, component_id = frames[5], frames[6]
    fields = json.dumps(SETPOINT | {"target_system": system_id, "target_component": component_id})
    message = MavlinkMessage("SET_POSITION_TARGET_LOCAL_NED", 255, 190, system_id, component_id, fields)
    direct.send_message(message)
    # It goes out, and comes in, by threads of MAVSDK's own.
    gone.wait(PATIENCE_S)
    json.dump({"heard": heard, "sent": b"".join(sent).hex()}, OUT)
    OUT.flush()
    os._exit(0)


main()
