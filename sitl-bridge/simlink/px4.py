"""PX4's multicopter."""

from simlink.autopilot import SEVERITY_CRITICAL, Autopilot
from simlink.modes import Behaviour, Mode
from simlink.setpoint import Setpoint

MAV_TYPE_GCS = 6
STREAM_BEFORE_OFFBOARD_MS = 1_000
STREAM_GAP_MS = 500
"""Setpoints must come faster than 2 Hz."""


_OFFBOARD_LOSS = {0: "POSCTL", 1: "ALTCTL", 2: "STABILIZED", 3: "RTL", 4: "LAND"}


def _mode(main: int, sub: int = 0) -> int:
    return main << 16 | sub << 24


class Px4(Autopilot):
    """Modes, timeouts and failsafes of PX4 1.15 without a remote control."""

    MODES = (
        Mode("MANUAL", _mode(1), Behaviour.LEVEL, needs_position=False),
        Mode("ALTCTL", _mode(2), Behaviour.LEVEL, needs_position=False),
        Mode("POSCTL", _mode(3), Behaviour.HOLD),
        Mode("TAKEOFF", _mode(4, 2), Behaviour.TAKEOFF),
        Mode("LOITER", _mode(4, 3), Behaviour.HOLD),
        Mode("RTL", _mode(4, 5), Behaviour.RETURN, arms=False),
        Mode("LAND", _mode(4, 6), Behaviour.LAND, needs_position=False, arms=False),
        Mode("OFFBOARD", _mode(6), Behaviour.GUIDED),
        Mode("STABILIZED", _mode(7), Behaviour.LEVEL, needs_position=False),
    )
    INITIAL_MODE, HOLD_MODE, GUIDED_MODE = "LOITER", "LOITER", "OFFBOARD"
    PARAMETERS = {
        "MAV_SYS_ID": 1.0,
        "COM_OF_LOSS_T": 1.0,
        "COM_DL_LOSS_T": 10.0,
        "COM_OBL_RC_ACT": 0.0,
        "NAV_DLL_ACT": 0.0,
        "MPC_XY_VEL_MAX": 12.0,
        "MPC_ACC_HOR": 3.0,
        "RTL_RETURN_ALT": 30.0,
        "GF_ACTION": 2.0,
        "MIS_TAKEOFF_ALT": 2.5,
    }

    INTEGERS = frozenset({"MAV_SYS_ID", "COM_OBL_RC_ACT", "NAV_DLL_ACT", "GF_ACTION"})

    def return_height_m(self) -> float:
        """RTL_RETURN_ALT."""
        return self.parameters["RTL_RETURN_ALT"]

    def setpoint_timeout_ms(self) -> float:
        """COM_OF_LOSS_T."""
        return self.parameters["COM_OF_LOSS_T"] * 1000.0

    def on_setpoint_timeout(self) -> None:
        """Leaves OFFBOARD as COM_OBL_RC_ACT says: by default for POSCTL, as was seen without a remote control too."""
        mode = _OFFBOARD_LOSS.get(int(self.parameters["COM_OBL_RC_ACT"]), self.HOLD_MODE)
        self.send_text(SEVERITY_CRITICAL, f"Failsafe: no offboard signal, {mode}")
        timed_out, stopped = self._timed_out, self._stopped
        self.change_mode(self._named(mode), "failsafe")
        self._timed_out, self._stopped = timed_out, stopped

    def is_ground_station(self, system: int, kind: int) -> bool:
        """By its type: the loss of an onboard controller is only logged."""
        return kind == MAV_TYPE_GCS

    def arm(self, force: bool) -> bool:
        """Not without a ground station, when NAV_DLL_ACT is set."""
        if self.parameters["NAV_DLL_ACT"] and self.station_heartbeat_ms is None and not force:
            self.send_text(SEVERITY_CRITICAL, "Preflight Fail: No connection to the GCS")
            return False
        return super().arm(force)

    def heartbeat_timeout_ms(self) -> float | None:
        """COM_DL_LOSS_T, when NAV_DLL_ACT is set."""
        return self.parameters["COM_DL_LOSS_T"] * 1000.0 if self.parameters["NAV_DLL_ACT"] else None

    def change_mode(self, mode: Mode, why: str) -> bool:
        """OFFBOARD only after a second of setpoints at more than 2 Hz."""
        if mode.behaviour is Behaviour.GUIDED and not self._has_stream():
            self.send_text(SEVERITY_CRITICAL, "Mode change to OFFBOARD failed: no offboard signal")
            return False
        last = self._offboard_ms
        if not super().change_mode(mode, why):
            return False
        if mode.behaviour is Behaviour.GUIDED:
            self.setpoint_ms, self._stopped = last, False
        return True

    def boot(self, t_ms: int) -> None:
        """Starts from nothing."""
        self._offboard_ms: int | None = None
        super().boot(t_ms)

    def _has_stream(self) -> bool:
        last = self._offboard_ms
        if last is None or self.t_ms - last > STREAM_GAP_MS:
            return False
        return last - self._stream_since_ms >= STREAM_BEFORE_OFFBOARD_MS

    def accept_setpoint(self, setpoint: Setpoint) -> bool:
        """Setpoints count as a stream in every mode; numbers that are not finite are ignored."""
        if not setpoint.is_finite:
            self.count("ignored_not_finite")
            self._emit("setpoint_ignored", reason="not finite")
            return False
        if self._offboard_ms is None or self.t_ms - self._offboard_ms > STREAM_GAP_MS:
            self._stream_since_ms = self.t_ms
        self._offboard_ms = self.t_ms
        return super().accept_setpoint(setpoint)

    def take_off(self, up: float) -> bool:
        """Changes to TAKEOFF by itself."""
        return (
            self.armed
            and not self.airborne
            and self.change_mode(self._named("TAKEOFF"), "command")
            and super().take_off(up)
        )

    def on_airborne(self) -> None:
        """Goes on to hold."""
        if self.mode.name == "TAKEOFF":
            self.change_mode(self._named(self.HOLD_MODE), "takeoff")
