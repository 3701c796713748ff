"""Stands in for ArduPilot's program: takes its options, and tells of a vehicle that moves north at 5 m/s.

It says nothing of ArduPilot: only how the fleet starts, hears and ends a program. Each request that it receives is
answered with two seconds of samples, so that nothing here waits for a clock.
"""

import argparse
import socket
import sys

from pymavlink.dialects.v20 import ardupilotmega as mavlink
from simlink.geodesy import METRES_PER_DEGREE

UNIX_MS = 1_800_000_000_000


def main() -> None:
    """Answers until it is killed."""
    parser = argparse.ArgumentParser(prefix_chars="-")
    for option in ("--model", "--speedup", "--sysid", "--home", "--defaults", "--serial0", "--serial1", "--serial2"):
        parser.add_argument(option, required=True)
    parser.add_argument("-I", dest="instance", type=int)
    options = parser.parse_args()
    print("started as", " ".join(sys.argv[1:]), flush=True)
    lat, lon, _, _ = (float(number) for number in options.home.split(","))
    if options.speedup == "13":
        print("the bearings are dry", flush=True)
        sys.exit(3)
    _, host, port = options.serial1.split(":")
    link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    link.connect((host, int(port)))
    mav = mavlink.MAVLink(None, srcSystem=int(options.sysid), srcComponent=1)
    link.send(mavlink.MAVLink_heartbeat_message(2, 3, 0, 0, 3, 3).pack(mav))
    boot_ms = 0
    while True:
        link.recv(4096)
        for _ in range(20):
            boot_ms += 100
            link.send(mavlink.MAVLink_system_time_message((UNIX_MS + boot_ms) * 1000, boot_ms).pack(mav))
            north = lat + 0.005 * boot_ms / METRES_PER_DEGREE
            link.send(mavlink.MAVLink_simstate_message(*[0.0] * 9, round(north * 1e7), round(lon * 1e7)).pack(mav))


if __name__ == "__main__":
    main()
