"""What ArduPilot and PX4 have in common: arming, modes, setpoints, failsafes.

No MAVLink in here: `protocol.py` calls in, `telemetry.py` reads out.
"""

from collections.abc import Callable

from simlink import modes
from simlink.body import Body
from simlink.flight import Flight
from simlink.modes import Behaviour, Mode
from simlink.setpoint import Kind, Setpoint

Emit = Callable[..., None]

HARD_LANDING_MPS = 3.0
AUTO_DISARM_MS = 10_000
EKF_FAILSAFE_MS = 5_000
GPS_LOSS_TO_EKF_MS = 1_000
STREAMING_MS = 2_000
"""A vehicle streams when it has taken a setpoint within this time."""

SEVERITY_CRITICAL, SEVERITY_WARNING, SEVERITY_INFO = 2, 4, 6


class Autopilot:
    """The state of one autopilot; ArduPilot and PX4 derive from it."""

    MODES: tuple[Mode, ...]
    INITIAL_MODE: str
    HOLD_MODE: str
    GUIDED_MODE: str
    PARAMETERS: dict[str, float]
    """Names and defaults."""
    INTEGERS: frozenset[str] = frozenset()
    """Parameters whose value is sent as the bytes of an integer."""

    def __init__(self, body: Body, emit: Emit, ekf_ready_ms: int) -> None:
        self.body = body
        self.flight = Flight(body)
        self._emit = emit
        self.parameters = dict(self.PARAMETERS)
        self.texts: list[tuple[int, str]] = []
        self.counts: dict[str, int] = {}
        self._ekf_after_ms = ekf_ready_ms
        self.t_ms = 0
        self.boot(0)

    def boot(self, t_ms: int) -> None:
        """Boots: disarmed, in the initial mode, without a position."""
        self.t_ms = t_ms
        self.mode = self._named(self.INITIAL_MODE)
        self.flight.enter(self.mode.behaviour)
        self.armed = False
        self.crashed = False
        self.home: tuple[float, float, float] | None = None
        self.station_heartbeat_ms: int | None = None
        self.controller_heard = False
        """A HEARTBEAT of somebody who is no autopilot arrived."""
        self.gcs_failsafe = False
        self.setpoint_ms: int | None = None
        self._stream_since_ms = 0
        self._flown_at_setpoint = 0.0
        self._timed_out = False
        self._stopped = True
        self._armed_ms = 0
        self._ekf_ready_ms = t_ms + self._ekf_after_ms
        self.gps_lost_ms: int | None = None
        self.ekf_bad = False
        self._ekf_lost_ms: int | None = None
        self.has_origin = False
        """The EKF has been ready since the start."""

    # What each autopilot decides

    def setpoint_timeout_ms(self) -> float:
        """Without a setpoint for this long the vehicle stops following, ms."""
        raise NotImplementedError

    def on_setpoint_timeout(self) -> None:
        """What the autopilot does after a setpoint timeout."""
        raise NotImplementedError

    def is_ground_station(self, system: int, kind: int) -> bool:
        """Whether the HEARTBEATs of this system and MAV_TYPE are the ground station's."""
        raise NotImplementedError

    def return_height_m(self) -> float:
        """Height above home to which a return climbs first, m."""
        raise NotImplementedError

    def heartbeat_timeout_ms(self) -> float | None:
        """Without a HEARTBEAT of the ground station for this long its failsafe acts, ms; None when it is off."""
        raise NotImplementedError

    # State

    @property
    def airborne(self) -> bool:
        """Off the ground."""
        return not self.flight.grounded

    @property
    def follows(self) -> bool:
        """Whether it follows a setpoint that has not timed out."""
        has_one = self.setpoint_ms is not None and not self._timed_out
        return has_one and self.armed and self.mode.behaviour is Behaviour.GUIDED

    @property
    def is_streaming(self) -> bool:
        """Whether it follows setpoints and has accepted one lately."""
        return self.follows and self.setpoint_ms is not None and self.t_ms - self.setpoint_ms <= STREAMING_MS

    @property
    def ekf_ready(self) -> bool:
        """The EKF has an absolute position."""
        lost = self.gps_lost_ms is not None and self.t_ms - self.gps_lost_ms >= GPS_LOSS_TO_EKF_MS
        return self.t_ms >= self._ekf_ready_ms and not lost and not self.ekf_bad

    def phase(self) -> str | None:
        """The phase of flight: takeoff, transit or hold; None on the ground and during return and landing."""
        if not self.armed or self.flight.grounded:
            return None
        if self.flight.climbing:
            return "takeoff"
        if self.mode.behaviour is not Behaviour.GUIDED:
            return None
        return "transit" if self.body.speed > 0.5 else "hold"

    def count(self, what: str) -> None:
        """Adds one to a count of the final statistics."""
        self.counts[what] = self.counts.get(what, 0) + 1

    def send_text(self, severity: int, text: str) -> None:
        """Queues a STATUSTEXT."""
        self.texts.append((severity, text))

    # Commands

    def change_mode(self, mode: Mode, why: str) -> bool:
        """Changes the mode; false when it must not."""
        if mode.needs_position and not self.ekf_ready and why != "failsafe":
            self.send_text(SEVERITY_WARNING, f"Mode change to {mode.name} failed: requires position")
            return False
        if mode is self.mode:
            return True
        self.mode = mode
        self.setpoint_ms = None
        self._timed_out = False
        self._stopped = True
        self.flight.return_height_m = self.return_height_m()
        self.flight.enter(mode.behaviour)
        self._emit("mode", mode=mode.name, why=why)
        return True

    def arm(self, force: bool) -> bool:
        """Starts the motors; false with a reason in STATUSTEXT when a check fails."""
        if self.armed:
            return True
        if not self.ekf_ready and not force:
            self.send_text(SEVERITY_CRITICAL, "PreArm: Need Position Estimate")
            return False
        if not self.mode.arms:
            self.send_text(SEVERITY_CRITICAL, f"Arm: {self.mode.name} mode not armable")
            return False
        self.armed = True
        self._armed_ms = self.t_ms
        if self.home is None or self.flight.grounded:
            self.home = (self.body.east, self.body.north, self.body.up)
        self._emit("armed")
        return True

    def disarm(self, force: bool) -> bool:
        """Stops the motors; in the air only when forced."""
        if self.armed and self.airborne and not force:
            self.send_text(SEVERITY_WARNING, "Disarm: vehicle is not landed")
            return False
        if self.armed:
            self.armed = False
            self._emit("disarmed", airborne=self.airborne)
        return True

    def take_off(self, up: float) -> bool:
        """Climbs to `up` m above the origin."""
        if not self.armed or self.airborne:
            return False
        self.flight.take_off(up)
        return True

    def heartbeat(self) -> None:
        """A HEARTBEAT of the ground station arrived."""
        self.station_heartbeat_ms = self.t_ms
        if self.gcs_failsafe:
            self.gcs_failsafe = False
            self.send_text(SEVERITY_WARNING, "GCS Failsafe Cleared")

    def accept_setpoint(self, setpoint: Setpoint) -> bool:
        """Follows a setpoint; False when it is ignored."""
        if self.mode.behaviour is not Behaviour.GUIDED:
            self.count("ignored_in_other_mode")
            return False
        if not setpoint.is_finite:
            self.crash("setpoint is not finite: a simulated ArduPilot would have aborted")
            return False
        if not self.armed or not self.airborne:
            self.count("ignored_on_ground")
            return False
        climbing = self.flight.climbing
        self.flight.follow(setpoint)
        if climbing:
            self._end_take_off()
        self._accept()
        return True

    def _accept(self) -> None:
        self.count("accepted")
        self.setpoint_ms = self.t_ms
        self._flown_at_setpoint = self.body.flown_m
        self._timed_out = False
        self._stopped = False

    def crash(self, reason: str) -> None:
        """The vehicle has crashed and is out of the simulation."""
        self.crashed = True
        self.armed = False
        self.body.stop()
        self._emit("crash", reason=reason)

    def enter_failsafe(self, reason: str, mode: str) -> None:
        """A failsafe changes the mode."""
        self.send_text(SEVERITY_CRITICAL, f"{reason} failsafe: {mode}")
        self._emit("failsafe", reason=reason, mode=mode)
        self.change_mode(self._named(mode), "failsafe")

    # Time

    def advance(self, t_ms: int, moves_by_itself: bool) -> None:
        """Advances to `t_ms`. In guided flight the body stays where it is unless it `moves_by_itself`."""
        dt_ms, self.t_ms = t_ms - self.t_ms, t_ms
        if self.crashed:
            return
        if not self.has_origin and self.ekf_ready:
            self.has_origin = True
            self._emit("ekf_ready")
        self._check_failsafes()
        climbing = self.flight.climbing
        impact = self.flight.advance(dt_ms / 1000.0, self.armed, moves_by_itself)
        if climbing and not self.flight.climbing and self.airborne:
            self._end_take_off()
        if impact is not None:
            self._land(impact)
        if self._timed_out and not self._stopped and self.body.speed < 0.1:
            self._stopped = True
            self._emit("stopped", flown_m=round(self.flown_since_setpoint_m, 2))

    def _end_take_off(self) -> None:
        self._emit("airborne", height_m=round(self.body.height_m, 2))
        self.on_airborne()

    def on_airborne(self) -> None:
        """The take-off is finished."""

    @property
    def flown_since_setpoint_m(self) -> float:
        """Distance over ground since the last accepted setpoint, m."""
        return self.body.flown_m - self._flown_at_setpoint

    def _check_failsafes(self) -> None:
        if not self.armed:
            return
        limit = self.heartbeat_timeout_ms()
        seen = self.station_heartbeat_ms
        if limit is not None and seen is not None and not self.gcs_failsafe and self.t_ms - seen > limit:
            self.gcs_failsafe = True
            if self.airborne and self.mode.behaviour not in (Behaviour.RETURN, Behaviour.LAND):
                self.enter_failsafe("GCS", "RTL")
        self._check_ekf()
        self._check_setpoint_timeout()
        if self.flight.grounded and not self.flight.climbing and self.t_ms - self._armed_ms > AUTO_DISARM_MS:
            self.disarm(force=True)

    def _check_setpoint_timeout(self) -> None:
        # A position is a goal that does not age.
        if not self.follows or self.setpoint_ms is None or self.flight.target_kind is Kind.POSITION:
            return
        silent_ms = self.t_ms - self.setpoint_ms
        if silent_ms > self.setpoint_timeout_ms():
            self._timed_out = True
            self._emit("timeout", silent_ms=silent_ms, flown_m=round(self.flown_since_setpoint_m, 2))
            self.on_setpoint_timeout()

    def _check_ekf(self) -> None:
        if self.ekf_ready or not self.airborne:
            self._ekf_lost_ms = None
        elif self._ekf_lost_ms is None:
            self._ekf_lost_ms = self.t_ms
        elif self.t_ms - self._ekf_lost_ms > EKF_FAILSAFE_MS and self.mode.behaviour not in (
            Behaviour.LAND,
            Behaviour.LEVEL,
        ):
            self.enter_failsafe("EKF", "LAND")

    def _land(self, impact_mps: float) -> None:
        if impact_mps > HARD_LANDING_MPS:
            self.crash(f"hit the ground at {impact_mps:.1f} m/s")
            return
        self._emit("landed")
        if self.armed:
            self.disarm(force=True)

    def _named(self, name: str) -> Mode:
        mode = modes.by_name(self.MODES, name)
        assert mode is not None, name
        return mode
