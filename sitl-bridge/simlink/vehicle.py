"""One simulated vehicle with its MAVLink messages."""

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from simlink import batteries, extras, schedule, telemetry
from simlink.autopilot import Emit
from simlink.config import FleetConfig, VehicleConfig
from simlink.endpoint import Endpoint
from simlink.extras import Extra
from simlink.protocol import Protocol
from simlink.schedule import PX4_STREAMS, Schedule
from simlink.vehicle_state import VehicleState

_POSITION_MESSAGES = (schedule.GLOBAL_POSITION_INT, schedule.LOCAL_POSITION_NED)


class Vehicle(VehicleState):
    """Receives datagrams and time, returns frames to send. Owns no socket and no clock."""

    def __init__(self, config: VehicleConfig, fleet: FleetConfig, key: bytes | None, emit: Emit) -> None:
        super().__init__(config, fleet, emit)
        self.schedule = Schedule(PX4_STREAMS if config.dialect == "px4" else {})
        self.endpoint = Endpoint(config.system, mavlink.MAV_COMP_ID_AUTOPILOT1, key)
        self.outbox: list[mavlink.MAVLink_message] = []
        self._protocol = Protocol(self, self.schedule, self.outbox)
        self._extras = [Extra(kind, config.system, key) for kind in fleet.extra if kind in extras.KINDS]
        added = [batteries.EXTRAS[kind] for kind in fleet.extra if kind in batteries.EXTRAS]
        self._batteries = [*fleet.batteries, *added]
        self.awaits_setpoint = False
        """Whether this tick's telemetry asks for a setpoint."""

    def on_reboot(self) -> None:
        """Message intervals are those of a fresh start."""
        self.schedule.reset()

    # Messages

    def telemetry(self) -> list[bytes]:
        """The frames due at this tick, the position last."""
        self.awaits_setpoint = False
        if self.is_silent:
            self.outbox.clear()
            return []
        self._protocol.flush_texts()
        frames = self.replies()
        if self.t_ms % 1000 == 0:
            frames.extend(frame for extra in self._extras for frame in extra.frames(self.boot_ms))
        stale = self.faults.is_active("pose_stale")
        for message in self.schedule.due(self.t_ms):
            if not schedule.is_known(self, message):
                continue
            if message in _POSITION_MESSAGES:
                if stale:
                    continue
                self.awaits_setpoint = True
            frames.append(self.endpoint.pack(schedule.BUILDERS[message](self)))
            if message == mavlink.MAVLINK_MSG_ID_BATTERY_STATUS:
                frames.extend(self.endpoint.pack(telemetry.other_battery_status(other)) for other in self._batteries)
        return frames

    def receive(self, datagram: bytes) -> list[bytes]:
        """Handles a datagram; returns the frames of the answers."""
        if self.is_silent:
            return []
        for message in self.endpoint.unpack(datagram):
            self._protocol.handle(message)
        return self.replies()

    def replies(self) -> list[bytes]:
        """The frames of the messages in the outbox."""
        frames = [self.endpoint.pack(message) for message in self.outbox]
        self.outbox.clear()
        return frames
