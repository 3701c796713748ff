"""ArduCopter."""

from simlink.autopilot import Autopilot
from simlink.modes import Behaviour, Mode


class ArduPilot(Autopilot):
    """Modes, timeouts and failsafes of ArduCopter 4.7."""

    MODES = (
        Mode("STABILIZE", 0, Behaviour.LEVEL, needs_position=False),
        Mode("ALT_HOLD", 2, Behaviour.LEVEL, needs_position=False),
        Mode("GUIDED", 4, Behaviour.GUIDED),
        Mode("LOITER", 5, Behaviour.HOLD),
        Mode("RTL", 6, Behaviour.RETURN, arms=False),
        Mode("LAND", 9, Behaviour.LAND, needs_position=False, arms=False),
        Mode("POSHOLD", 16, Behaviour.HOLD),
        Mode("BRAKE", 17, Behaviour.HOLD, arms=False),
    )
    INITIAL_MODE, HOLD_MODE, GUIDED_MODE = "STABILIZE", "LOITER", "GUIDED"
    PARAMETERS = {
        "MAV_SYSID": 1.0,
        "MAV_GCS_SYSID": 255.0,
        "MAV_GCS_SYSID_HI": 0.0,
        "GUID_TIMEOUT": 3.0,
        "FS_GCS_ENABLE": 0.0,
        "FS_GCS_TIMEOUT": 5.0,
        "WPNAV_ACCEL": 250.0,
        "WPNAV_SPEED": 1000.0,
        "RTL_ALT_M": 15.0,
        "FENCE_ENABLE": 0.0,
        "FENCE_ACTION": 1.0,
        "FENCE_TYPE": 7.0,
        "FENCE_ALT_MAX": 100.0,
    }

    def setpoint_timeout_ms(self) -> float:
        """GUID_TIMEOUT."""
        return self.parameters["GUID_TIMEOUT"] * 1000.0

    def on_setpoint_timeout(self) -> None:
        """Stays in GUIDED and stops."""
        self.flight.stop()

    def is_ground_station(self, system: int, kind: int) -> bool:
        """By its system id alone: MAV_GCS_SYSID, to MAV_GCS_SYSID_HI."""
        first, last = self.parameters["MAV_GCS_SYSID"], self.parameters["MAV_GCS_SYSID_HI"]
        return first <= system <= max(first, last)

    def heartbeat_timeout_ms(self) -> float | None:
        """FS_GCS_TIMEOUT, when FS_GCS_ENABLE is set."""
        return self.parameters["FS_GCS_TIMEOUT"] * 1000.0 if self.parameters["FS_GCS_ENABLE"] else None

    def return_height_m(self) -> float:
        """RTL_ALT_M."""
        return self.parameters["RTL_ALT_M"]

    def take_off(self, up: float) -> bool:
        """Only in GUIDED."""
        return self.mode.name == "GUIDED" and super().take_off(up)
