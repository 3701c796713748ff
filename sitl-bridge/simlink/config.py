"""What a fleet is made of, read from one JSON object."""

import math
import time
from dataclasses import dataclass, field
from typing import Any

from simlink import batteries, extras
from simlink.batteries import OtherBattery
from simlink.faults import Fault, FaultError
from simlink.geodesy import Plane
from simlink.ideal import Scale

DIALECTS = ("ardupilot", "px4")
DYNAMICS = ("point", "ideal")
_NUMBER = (int, float)


class ConfigError(ValueError):
    """A fleet that cannot be; the message says what to change."""


@dataclass(frozen=True)
class Place:
    """A point on the globe: degrees, and metres above the sea."""

    lat: float = -35.363262
    lon: float = 149.165237
    alt: float = 584.0


@dataclass(frozen=True)
class Battery:
    """Charge at the start, and how long a full one lasts; None: for ever."""

    percent: float = 100.0
    minutes: float | None = None


@dataclass(frozen=True)
class VehicleConfig:
    """One vehicle: who it is and where its telemetry goes."""

    id: int
    system: int
    port: int
    host: str = "127.0.0.1"
    dialect: str = "ardupilot"
    lat: float = Place.lat
    lon: float = Place.lon
    alt: float = Place.alt
    start_u: tuple[float, float] | None = None
    parameters: dict[str, float] = field(default_factory=dict)
    """Values of the autopilot's parameters; the others have their defaults."""


@dataclass(frozen=True)
class FleetConfig:
    """The whole fleet. Times are of the fleet's own clock unless they say otherwise."""

    vehicles: tuple[VehicleConfig, ...]
    origin: Place = field(default_factory=Place)
    scale: Scale = field(default_factory=Scale)
    epoch_unix_ms: int | None = None
    """When step 0 begins."""
    rate_hz: int = 5
    """Ticks a second."""
    dynamics: str = "point"
    lockstep: bool = True
    lockstep_timeout_s: float = 2.0
    speed: float = 20.0
    wind: tuple[float, float] = (0.0, 0.0)
    """East and north, m/s."""
    gps_noise_m: float = 0.0
    seed: int = 1
    battery: Battery = field(default_factory=Battery)
    batteries: tuple[OtherBattery, ...] = ()
    """Every vehicle's batteries besides the first."""
    signing_key_file: str | None = None
    faults: tuple[Fault, ...] = ()
    extra: tuple[str, ...] = ()
    """Who else is on every vehicle's port: kinds of `extras.KINDS`."""
    shared_ports: bool = False
    """Every vehicle is on every port, and hears what is sent to any, as behind one MAVProxy."""
    guided_timeout_s: float | None = None
    """None: the autopilot's own, 3 s for ArduPilot and 1 s for PX4."""
    parameters: dict[str, float] = field(default_factory=dict)
    """Values of all autopilots' parameters; a vehicle's own count more."""
    ekf_ready_ms: int = 5_000
    boot_ms: int = 0
    unix_ms: int = 0

    @property
    def tick_ms(self) -> int:
        """Length of a tick."""
        return 1000 // self.rate_hz

    def pad_m(self, vehicle: VehicleConfig) -> tuple[float, float]:
        """Where a vehicle stands at the start, m east and north of the origin."""
        if vehicle.start_u is not None:
            return vehicle.start_u[0] * self.scale.scale_m, vehicle.start_u[1] * self.scale.scale_m
        return Plane(self.origin.lat, self.origin.lon, self.origin.alt).metres(vehicle.lat, vehicle.lon)


def read(raw: Any) -> FleetConfig:
    """The fleet that a JSON object describes.

    Raises ConfigError, with the field in the message.
    """
    top = _Fields("the fleet", raw)
    defaults = FleetConfig(vehicles=())
    origin = _place(top.take("origin", dict, {}), "origin")
    raw_vehicles = top.take("vehicles", list)
    starts = top.take("start_u", list, None)
    if starts is not None and len(starts) != len(raw_vehicles):
        raise ConfigError(f"start_u has {len(starts)} places for {len(raw_vehicles)} vehicles; give one each")
    vehicles = tuple(
        _vehicle(entry, origin, None if starts is None else starts[i]) for i, entry in enumerate(raw_vehicles)
    )
    scale = Scale(
        top.positive("scale_m", Scale.scale_m),
        top.take("step_ms", int, Scale.step_ms),
        top.positive("map_side_u", Scale.map_side_u),
    )
    battery = top.take("battery", (dict, *_NUMBER), {})
    battery_fields = _Fields("battery", battery if isinstance(battery, dict) else {"percent": battery})
    try:
        faults = tuple(Fault.read(fault) for fault in top.take("faults", list, []))
    except FaultError as error:
        raise ConfigError(str(error)) from None
    config = FleetConfig(
        vehicles=vehicles,
        origin=origin,
        scale=scale,
        epoch_unix_ms=top.take("epoch_unix_ms", int, None),
        rate_hz=top.take("rate_hz", int, defaults.rate_hz),
        dynamics=top.choice("dynamics", DYNAMICS),
        lockstep=top.take("lockstep", bool, defaults.lockstep),
        lockstep_timeout_s=top.positive("lockstep_timeout_s", defaults.lockstep_timeout_s),
        speed=top.positive("speed", defaults.speed),
        wind=_pair(top.take("wind", list, [0.0, 0.0]), "wind"),
        gps_noise_m=top.take("gps_noise_m", _NUMBER, 0.0),
        seed=top.take("seed", int, defaults.seed),
        battery=Battery(
            battery_fields.take("percent", _NUMBER, Battery.percent),
            battery_fields.positive("minutes", None),
        ),
        batteries=tuple(_other_battery(entry) for entry in top.take("batteries", list, [])),
        signing_key_file=top.take("signing_key_file", str, None),
        faults=faults,
        extra=tuple(top.take("extra", list, [])),
        shared_ports=top.take("shared_ports", bool, defaults.shared_ports),
        guided_timeout_s=top.take("guided_timeout_s", _NUMBER, None),
        parameters=_parameters(top, "the fleet"),
        ekf_ready_ms=round(1000 * top.take("ekf_ready_s", _NUMBER, 5)),
        boot_ms=top.take("boot_ms", int, 0),
        unix_ms=top.take("unix_ms", int, None) or int(time.time() * 1000),
    )
    battery_fields.done()
    top.done()
    check(config)
    return config


def check(config: FleetConfig) -> None:
    """Raises ConfigError when parts of a fleet do not fit together."""
    if not config.vehicles:
        raise ConfigError("the fleet has no vehicles; give at least one in `vehicles`")
    for what in ("id", "system"):
        seen = [getattr(vehicle, what) for vehicle in config.vehicles]
        if twice := next((value for value in seen if seen.count(value) > 1), None):
            raise ConfigError(f"two vehicles have the {what} {twice}; each needs its own")
    if not 1 <= config.rate_hz <= 100 or 1000 % config.rate_hz:
        raise ConfigError(f"rate_hz is {config.rate_hz}; it must divide 1000 and be at most 100, such as 5 or 10")
    if config.scale.step_ms < config.tick_ms:
        raise ConfigError(f"step_ms is {config.scale.step_ms}, shorter than a tick of {config.tick_ms} ms")
    if config.dynamics == "ideal" and (any(config.wind) or config.gps_noise_m):
        raise ConfigError("ideal dynamics know no wind and no noise; set both to 0 or take dynamics point")
    for kind in config.extra:
        if kind not in extras.NAMES:
            raise ConfigError(f"there is no extra {kind!r}; known: {', '.join(extras.NAMES)}")
    if config.gps_noise_m < 0:
        raise ConfigError("gps_noise_m is negative")
    ids = {vehicle.id for vehicle in config.vehicles}
    for fault in config.faults:
        if fault.id not in ids:
            raise ConfigError(f"fault {fault.kind} is for vehicle {fault.id}, which is not in the fleet")


def _vehicle(raw: Any, origin: Place, start_u: Any) -> VehicleConfig:
    fields = _Fields("a vehicle", raw)
    own = fields.take("start_u", list, None)
    start = own if own is not None else start_u
    vehicle = VehicleConfig(
        id=fields.take("id", int),
        system=fields.take("system", int, None) or raw["id"],
        port=fields.take("port", int),
        host=fields.take("host", str, VehicleConfig.host),
        dialect=fields.choice("dialect", DIALECTS),
        lat=fields.take("lat", _NUMBER, origin.lat),
        lon=fields.take("lon", _NUMBER, origin.lon),
        alt=fields.take("alt", _NUMBER, origin.alt),
        start_u=None if start is None else _pair(start, "start_u"),
        parameters=_parameters(fields, "a vehicle"),
    )
    fields.done()
    if not 1 <= vehicle.system <= 254:
        raise ConfigError(f"vehicle {vehicle.id}: the MAVLink system is 1 to 254, not {vehicle.system}")
    if not 1 <= vehicle.port <= 65_535:
        raise ConfigError(f"vehicle {vehicle.id}: the port is 1 to 65535, not {vehicle.port}")
    return vehicle


def _other_battery(raw: Any) -> OtherBattery:
    fields = _Fields("a battery", raw)
    battery = OtherBattery(
        fields.take("id", int), fields.choice("function", tuple(batteries.FUNCTIONS)), fields.take("percent", _NUMBER)
    )
    fields.done()
    if not 1 <= battery.id <= 255:
        raise ConfigError(f"the id of another battery is 1 to 255, not {battery.id}")
    if not 0 <= battery.percent <= 100:
        raise ConfigError(f"battery {battery.id}: percent is 0 to 100, not {battery.percent}")
    return battery


def _parameters(fields: "_Fields", what: str) -> dict[str, float]:
    values = fields.take("parameters", dict, {})
    for name, value in values.items():
        if not _is_number(value):
            raise ConfigError(f"{what}: parameter {name} is a number, not {value!r}")
    return values


def _place(raw: dict, what: str) -> Place:
    fields = _Fields(what, raw)
    place = Place(*(fields.take(name, _NUMBER, getattr(Place, name)) for name in ("lat", "lon", "alt")))
    fields.done()
    if abs(place.lat) > 90 or abs(place.lon) > 180:
        raise ConfigError(f"{what}: {place.lat}, {place.lon} is no latitude and longitude in degrees")
    return place


def _pair(raw: Any, what: str) -> tuple[float, float]:
    ok = isinstance(raw, list | tuple) and len(raw) == 2 and all(_is_number(v) for v in raw)
    if not ok:
        raise ConfigError(f"{what} is a pair of numbers, not {raw!r}")
    return float(raw[0]), float(raw[1])


def _is_number(value: Any) -> bool:
    return isinstance(value, _NUMBER) and not isinstance(value, bool) and math.isfinite(value)


_MUST = object()


class _Fields:
    """Takes fields out of a JSON object, checks their types, and complains about those left over."""

    def __init__(self, what: str, raw: Any) -> None:
        if not isinstance(raw, dict):
            raise ConfigError(f"{what} is a JSON object, not {raw!r}")
        self._what, self._left = what, dict(raw)

    def take(self, name: str, kind: type | tuple[type, ...], default: Any = _MUST) -> Any:
        value = self._left.pop(name, None)
        if value is None:
            if default is _MUST:
                raise ConfigError(f"{self._what} lacks `{name}`")
            return default
        kinds = kind if isinstance(kind, tuple) else (kind,)
        wrong_bool = isinstance(value, bool) and bool not in kinds
        if wrong_bool or not isinstance(value, kinds) or (isinstance(value, float) and not math.isfinite(value)):
            raise ConfigError(f"{self._what}: `{name}` is {' or '.join(k.__name__ for k in kinds)}, not {value!r}")
        return value

    def positive(self, name: str, default: float | None) -> Any:
        value = self.take(name, _NUMBER, default)
        if value is not None and value <= 0:
            raise ConfigError(f"{self._what}: `{name}` is greater than 0, not {value!r}")
        return value

    def choice(self, name: str, known: tuple[str, ...]) -> str:
        value = self.take(name, str, known[0])
        if value not in known:
            raise ConfigError(f"{self._what}: there is no {name} {value!r}; known: {', '.join(known)}")
        return value

    def done(self) -> None:
        if self._left:
            raise ConfigError(f"{self._what} has no field `{min(self._left)}`")
