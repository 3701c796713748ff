"""The other side of tests/pymavlink.rs: MAVLink by pymavlink alone.

Bytes come on stdin and go to stdout; what is found is one JSON object a line.
"""

import argparse
import json
import os
import sys

os.environ["MAVLINK20"] = "1"

from pymavlink import mavutil  # noqa: E402
from pymavlink.dialects.v10 import ardupilotmega as v1  # noqa: E402
from pymavlink.dialects.v20 import ardupilotmega as v2  # noqa: E402


def messages(m):
    """What autopilots and ground stations send to a node and hear from it, each field at a value of its own."""
    nan = float("nan")
    return [
        m.MAVLink_heartbeat_message(2, 3, 217, 4, 4, 3),
        m.MAVLink_heartbeat_message(18, 8, 0, 0, 0, 3),
        m.MAVLink_system_time_message(1_790_000_000_123_456, 4_294_967_295),
        m.MAVLink_global_position_int_message(84_000, 473977418, -85455939, 488000, -10, -120, 250, 3, 35999),
        m.MAVLink_global_position_int_message(0, 0, 0, 0, 0, 0, 0, 0, 0),
        m.MAVLink_local_position_ned_message(84_000, 1.25, -2.5, -10.125, 0.5, -0.25, 1e-30),
        m.MAVLink_gps_global_origin_message(473977418, 85455939, 488000),
        m.MAVLink_home_position_message(473977418, 85455939, 488000, 1.0, 2.0, 3.0, [1.0, 0.0, 0.0, 0.0], 0, 0, 0),
        m.MAVLink_ekf_status_report_message(831, 0.125, 0.25, 0.5, 0.75, 1.0),
        m.MAVLink_sys_status_message(0x0FFF, 0x0FFF, 0x0FFF, 123, 12600, -1, 87, 0, 0, 0, 0, 0, 0),
        m.MAVLink_battery_status_message(0, 0, 1, 2500, [4200] * 10, 1000, -1, -1, 87),
        m.MAVLink_extended_sys_state_message(0, 2),
        m.MAVLink_command_ack_message(400, 0),
        m.MAVLink_command_ack_message(511, 4),
        m.MAVLink_command_long_message(1, 1, 400, 0, 1.0, 21196.0, 0.0, nan, 0.0, 0.0, 7.5),
        m.MAVLink_command_int_message(1, 1, 3, 192, 0, 0, -1.0, 1.0, 0.0, 0.0, 473977418, 85455939, 30.0),
        m.MAVLink_set_position_target_local_ned_message(
            84_000, 1, 1, 1, 0x0C07, 0.0, 0.0, 0.0, 4.5, -4.5, 0.25, 1.25, -1.25, 0.0, 0.0, 0.0
        ),
        m.MAVLink_statustext_message(5, b"Arm: need 3D fix\0"),
        m.MAVLink_radio_status_message(200, 190, 90, 40, 41, 1, 2),
        m.MAVLink_v2_extension_message(0, 0, 0, 0xC056, list(range(249))),
        m.MAVLink_timesync_message(0, 123456789),
    ]


def packer(module, system, component, key=None, link_id=0, timestamp=0):
    mav = module.MAVLink(None, srcSystem=system, srcComponent=component)
    if key:
        mav.signing.secret_key = key
        mav.signing.sign_outgoing = True
        mav.signing.link_id = link_id
        mav.signing.timestamp = timestamp
    return mav


def encode(args):
    """Packs every message, in one version."""
    module = v1 if args.v1 else v2
    mav = packer(module, 42, 7, args.key, args.link_id, args.timestamp)
    for message in messages(module):
        sys.stdout.buffer.write(message.pack(mav, **({} if args.v1 else {"force_mavlink1": False})))
        mav.seq = (mav.seq + 1) % 256


def decode(args):
    """Unpacks what comes and says what it is; with `repack`, how pymavlink itself would have packed it."""
    mav = packer(v2, 1, 1, args.key, timestamp=args.timestamp)
    mav.robust_parsing = True
    for message in mav.parse_buffer(sys.stdin.buffer.read()) or []:
        if message.get_type() == "BAD_DATA":
            print(json.dumps({"type": "BAD_DATA", "reason": message.reason}))
            continue
        header = message.get_header()
        original = bytes(message.get_msgbuf())
        again = packer(v2, header.srcSystem, header.srcComponent)
        again.seq = header.seq
        unsigned = bytes(message.pack(again, force_mavlink1=original[0] == 0xFE))
        print(
            json.dumps(
                {
                    "type": message.get_type(),
                    "system": header.srcSystem,
                    "component": header.srcComponent,
                    "sequence": header.seq,
                    "signed": bool(message.get_signed()),
                    "repacked": unsigned.hex(),
                }
            )
        )


def checksums(_args):
    """The extra byte of every message's checksum."""
    print(json.dumps({str(number): cls.crc_extra for number, cls in v2.mavlink_map.items()}))


def read_tlog(args):
    """Reads a tlog as MAVExplorer does."""
    log = mavutil.mavlink_connection(args.file)
    while (message := log.recv_match()) is not None:
        print(json.dumps({"type": message.get_type(), "us": round(message._timestamp * 1e6)}))


def write_tlog(args):
    """Writes a tlog as MAVProxy does."""
    mav = packer(v2, 42, 7)
    with open(args.file, "wb") as file:
        for number, message in enumerate(messages(v2)):
            file.write((1_790_000_000_000_000 + number * 1000).to_bytes(8, "big"))
            file.write(message.pack(mav))
            mav.seq = (mav.seq + 1) % 256


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("action", choices=["encode", "decode", "checksums", "read-tlog", "write-tlog"])
    parser.add_argument("--key", type=bytes.fromhex)
    parser.add_argument("--link-id", type=int, default=0)
    parser.add_argument("--timestamp", type=int, default=0)
    parser.add_argument("--v1", action="store_true")
    parser.add_argument("--file")
    args = parser.parse_args()
    actions = {
        "encode": encode,
        "decode": decode,
        "checksums": checksums,
        "read-tlog": read_tlog,
        "write-tlog": write_tlog,
    }
    actions[args.action](args)


main()
