"""The state of one simulated vehicle: autopilot, body, clocks, faults."""

import math
import random
from typing import NamedTuple

from simlink import actions, modes
from simlink.ardupilot import ArduPilot
from simlink.autopilot import Emit
from simlink.body import Body
from simlink.config import ConfigError, FleetConfig, VehicleConfig
from simlink.faults import Fault, FaultPlan
from simlink.float32 import f32
from simlink.geodesy import Plane
from simlink.ideal import IdealState
from simlink.modes import Behaviour
from simlink.px4 import Px4
from simlink.setpoint import Kind

_NOISE_TIME_S = 5.0
_REBOOT_MS = 2_000


class Estimate(NamedTuple):
    """What the EKF believes: m and m/s east, north, up of the fleet's origin."""

    east: float
    north: float
    up: float
    ve: float
    vn: float
    vu: float


class VehicleState:
    """Everything of a vehicle but its MAVLink messages. Owns no clock."""

    def __init__(self, config: VehicleConfig, fleet: FleetConfig, emit: Emit) -> None:
        self.config = config
        self.plane = Plane(fleet.origin.lat, fleet.origin.lon, fleet.origin.alt)
        self._fleet = fleet
        self._emit = emit
        east, north = fleet.pad_m(config)
        self.pad = (east, north, config.alt - fleet.origin.alt)
        self.ideal = None
        if fleet.dynamics == "ideal":
            x, y = config.start_u or (east / fleet.scale.scale_m, north / fleet.scale.scale_m)
            self.ideal = IdealState(fleet.scale, x, y)
            self.pad = (*self.ideal.position_m(), self.pad[2])
        body = Body(*self.pad, wind=fleet.wind)
        px4 = config.dialect == "px4"
        self.autopilot = (Px4 if px4 else ArduPilot)(body, self._report, fleet.ekf_ready_ms)
        if fleet.guided_timeout_s is not None:
            self.autopilot.parameters["COM_OF_LOSS_T" if px4 else "GUID_TIMEOUT"] = fleet.guided_timeout_s
        self.autopilot.parameters["MAV_SYS_ID" if px4 else "MAV_SYSID"] = float(config.system)
        self._set_parameters({**fleet.parameters, **config.parameters})
        self.faults = FaultPlan([fault for fault in fleet.faults if fault.id == config.id])
        self._random = random.Random(f"{fleet.seed}/{config.id}")
        self._noise = [self._random.gauss(0.0, fleet.gps_noise_m) for _ in range(2)]
        self._battery_percent, self._battery_ms = fleet.battery.percent, 0
        self._boot_offset_ms = fleet.boot_ms
        self._rebooting_until: int | None = None
        self._frozen: Estimate | None = None
        self._estimate: Estimate | None = None
        self.t_ms = 0
        self.host_ms = 0
        """Time of the host's clock since the fleet began."""

    def _set_parameters(self, values: dict[str, float]) -> None:
        known = self.autopilot.parameters
        for name, value in values.items():
            if name not in known:
                raise ConfigError(
                    f"vehicle {self.config.id} ({self.config.dialect}) has no parameter {name!r}; known: {', '.join(known)}"
                )
            known[name] = float(value)

    # Clocks, all in ms

    @property
    def boot_ms(self) -> int:
        """Since the autopilot started; wraps at 32 bits."""
        return self.t_ms + self._boot_offset_ms & 0xFFFF_FFFF

    @property
    def boot_us(self) -> int:
        """The same in µs, which does not wrap."""
        return max(0, self.t_ms + self._boot_offset_ms) * 1000

    @property
    def unix_ms(self) -> int:
        """Time of day: ArduPilot has it from its GPS, PX4 from its host."""
        return self._fleet.unix_ms + (self.host_ms if isinstance(self.autopilot, Px4) else self.t_ms)

    # Estimates

    @property
    def ekf_origin(self) -> tuple[float, float, float]:
        """Where LOCAL_POSITION_NED is zero: the pad; in ideal flight the fleet's origin, so that nothing is rounded."""
        return (0.0, 0.0, 0.0) if self.ideal else self.pad

    def estimate(self) -> Estimate:
        """What the EKF believes at this tick."""
        if self._estimate is None:
            body = self.autopilot.body
            fresh = Estimate(
                body.east + self._noise[0], body.north + self._noise[1], body.up, body.ve, body.vn, body.vu
            )
            if not self.faults.is_active("pose_frozen"):
                self._frozen = None
            elif self._frozen is None:
                self._frozen = fresh
            self._estimate = self._frozen or fresh
        return self._estimate

    def battery_percent(self) -> float:
        """Remaining charge, 0 to 100 %."""
        minutes = self._fleet.battery.minutes
        if minutes is None:
            return self._battery_percent
        return max(0.0, self._battery_percent - (self.t_ms - self._battery_ms) / 60_000.0 / minutes * 100.0)

    # Time

    def advance(self, t_ms: int) -> None:
        """Advances to `t_ms`, ms since the fleet began."""
        dt_s = (t_ms - self.t_ms) / 1000.0
        self.t_ms = t_ms
        self._estimate = None
        begun, ended = self.faults.advance(t_ms, self.autopilot.phase())
        for kind in ended:
            self._end_fault(kind)
        for fault in begun:
            self._begin_fault(fault)
        if self._rebooting_until is not None and t_ms >= self._rebooting_until:
            self._restart()
        self._advance_noise(dt_s)
        behaviour = self.autopilot.mode.behaviour
        down = behaviour in (Behaviour.RETURN, Behaviour.LAND) or not self.autopilot.armed
        self.autopilot.advance(t_ms, self.ideal is None or down)
        if self.ideal:
            self._follow_body(self.ideal, down)

    def _advance_noise(self, dt_s: float) -> None:
        sigma = self._fleet.gps_noise_m
        if sigma:
            keep = math.exp(-dt_s / _NOISE_TIME_S)
            spread = sigma * math.sqrt(1.0 - keep * keep)
            self._noise = [keep * n + self._random.gauss(0.0, spread) for n in self._noise]

    # Ideal flight

    def _follow_body(self, ideal: IdealState, down: bool) -> None:
        body, scale_m = self.autopilot.body, self._fleet.scale.scale_m
        if down and self.autopilot.airborne:
            ideal.x, ideal.y = f32(body.east / scale_m), f32(body.north / scale_m)
        if not self._acts():
            ideal.stop()
            if not down:
                body.stop_horizontally()

    def _acts(self) -> bool:
        autopilot = self.autopilot
        return autopilot.follows and autopilot.airborne and autopilot.flight.setpoint is not None

    def step(self) -> None:
        """A step boundary of an ideal flight: moves by the last setpoint."""
        ideal, setpoint = self.ideal, self.autopilot.flight.setpoint
        if ideal is None or setpoint is None or not self._acts():
            return
        scale = self._fleet.scale
        if setpoint.has_acceleration:
            ae, an, _ = setpoint.acceleration
            ideal.act(actions.nearest(scale.acceleration_u(ae), scale.acceleration_u(an)))
        elif setpoint.kind is Kind.VELOCITY:
            ve, vn, _ = setpoint.velocity
            ideal.coast_at(scale.velocity_u(ve), scale.velocity_u(vn))
        else:
            ideal.stop()
        body, (east, north) = self.autopilot.body, ideal.position_m()
        body.flown_m += math.hypot(east - body.east, north - body.north)
        body.east, body.north = east, north
        body.ve, body.vn = ideal.velocity_mps()
        self._estimate = None

    # Faults

    def _begin_fault(self, fault: Fault) -> None:
        self._emit("fault", id=self.config.id, kind=fault.kind, state="begins")
        autopilot = self.autopilot
        match fault.kind:
            case "gps_lost":
                autopilot.gps_lost_ms = self.t_ms
            case "ekf_bad":
                autopilot.ekf_bad = True
            case "clock_jump":
                self._boot_offset_ms += fault.option
            case "reboot":
                self._rebooting_until = self.t_ms + (fault.for_ms or _REBOOT_MS)
                autopilot.disarm(force=True)
            case "pilot_mode":
                self.pilot_mode(fault.option)
            case "battery_low":
                self._battery_percent, self._battery_ms = fault.option, self.t_ms
                autopilot.send_text(4, "Battery 1 is low")
            case "teleport":
                self._teleport(*fault.option)
            case "disarm":
                autopilot.disarm(force=True)

    def _end_fault(self, kind: str) -> None:
        self._emit("fault", id=self.config.id, kind=kind, state="ends")
        if kind == "gps_lost":
            self.autopilot.gps_lost_ms = None
        elif kind == "ekf_bad":
            self.autopilot.ekf_bad = False

    def pilot_mode(self, name: str) -> None:
        """The pilot changes the mode; ValueError when the autopilot has no such mode."""
        mode = modes.by_name(self.autopilot.MODES, name)
        if mode is None:
            known = ", ".join(mode.name for mode in self.autopilot.MODES)
            raise ValueError(f"vehicle {self.config.id} has no mode {name!r}; known: {known}")
        self.autopilot.change_mode(mode, "pilot")

    def _teleport(self, x_u: float, y_u: float) -> None:
        body, scale_m = self.autopilot.body, self._fleet.scale.scale_m
        body.east += x_u * scale_m
        body.north += y_u * scale_m
        if self.ideal:
            self.ideal.x, self.ideal.y = f32(self.ideal.x + x_u), f32(self.ideal.y + y_u)

    def _restart(self) -> None:
        self._rebooting_until = None
        self._boot_offset_ms = -self.t_ms
        crashed = self.autopilot.crashed
        self.autopilot.boot(self.t_ms)
        self.autopilot.crashed = crashed
        self._emit("reboot", id=self.config.id)
        self.on_reboot()

    def on_reboot(self) -> None:
        """The autopilot has started again from nothing."""

    @property
    def is_silent(self) -> bool:
        """Neither sends nor receives anything."""
        return self._rebooting_until is not None or self.faults.is_active("link_cut") or self.autopilot.crashed

    def _report(self, event: str, **fields: object) -> None:
        self._emit(event, id=self.config.id, **fields)
