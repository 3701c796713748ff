"""All vehicles and the clock that advances them."""

import logging
from collections.abc import Callable
from typing import Any

from simlink import control
from simlink.config import FleetConfig
from simlink.faults import FaultError
from simlink.hub import CONTROL, Hub
from simlink.vehicle import Vehicle

logger = logging.getLogger(__name__)

_CATCH_UP_S = 1.0


class Fleet:
    """Advances time tick by tick: integrates, sends, then waits for setpoints or for the wall clock."""

    def __init__(
        self,
        config: FleetConfig,
        hub: Hub,
        emit: Callable[..., None],
        key: bytes | None = None,
        on_tick: Callable[["Fleet"], None] | None = None,
    ) -> None:
        self.config = config
        self.t_ms = 0
        self.speed = config.speed
        self.vehicles = [Vehicle(vehicle, config, key, self.report) for vehicle in config.vehicles]
        self._by_id = {vehicle.config.id: vehicle for vehicle in self.vehicles}
        self._hub, self._out = hub, emit
        self._on_tick = on_tick
        self.stopped = False
        self.epoch_unix_ms = config.unix_ms if config.epoch_unix_ms is None else config.epoch_unix_ms
        self._step = self.step
        self._late: set[Vehicle] = set()
        self.lockstep_timeouts = 0
        self._started = self._next_tick = hub.now()
        self._signing_second = -1

    def report(self, event: str, **fields: Any) -> None:
        """Writes an event."""
        self._out(event, t_ms=self.t_ms, **fields)

    def vehicle(self, identity: Any) -> Vehicle | None:
        """The vehicle of an id."""
        return self._by_id.get(identity)

    @property
    def step(self) -> int:
        """The step of the common clock; negative before the epoch."""
        return (self.config.unix_ms + self.t_ms - self.epoch_unix_ms) // self.config.scale.step_ms

    def run(self) -> None:
        """Flies until it is stopped."""
        self.report("ready", vehicles=len(self.vehicles))
        self._report_truth()
        try:
            while not self.stopped:
                self.tick()
                self._wait()
                if self._on_tick is not None:
                    self._on_tick(self)
        finally:
            self.report("stats", **self.stats())

    def tick(self) -> None:
        """Advances by one tick and sends the messages that are due."""
        self.t_ms += self.config.tick_ms
        host_ms = self._host_ms()
        for vehicle in self.vehicles:
            vehicle.host_ms = host_ms
            vehicle.advance(self.t_ms)
        if self.step != self._step:
            self._step = self.step
            for vehicle in self.vehicles:
                vehicle.step()
            self._report_truth()
        self._refresh_signing_clocks()
        for index, vehicle in enumerate(self.vehicles):
            for frame in vehicle.telemetry():
                self._send(index, frame)

    def _host_ms(self) -> int:
        """The host's clock since the fleet began; in lock-step, where the host waits, the fleet's own."""
        return self.t_ms if self.config.lockstep else round((self._hub.now() - self._started) * 1000.0)

    def _send(self, index: int, frame: bytes) -> None:
        """Sends what the vehicle at `index` says: to its own port or, where ports are shared, to all."""
        for port in range(len(self.vehicles)) if self.config.shared_ports else (index,):
            self._hub.send(port, frame)

    def _report_truth(self) -> None:
        if self._step < 0:
            return
        scale = self.config.scale
        positions, velocities = [], []
        for vehicle in self.vehicles:
            body, ideal = vehicle.autopilot.body, vehicle.ideal
            if ideal:
                positions.append([ideal.x, ideal.y])
                velocities.append([ideal.vx, ideal.vy])
            else:
                positions.append([round(body.east / scale.scale_m, 5), round(body.north / scale.scale_m, 5)])
                velocities.append([round(scale.velocity_u(body.ve), 5), round(scale.velocity_u(body.vn), 5)])
        heights = [round(vehicle.autopilot.body.height_m, 2) for vehicle in self.vehicles]
        modes = [vehicle.autopilot.mode.name for vehicle in self.vehicles]
        self.report("truth", step=self._step, u=positions, v=velocities, height_m=heights, modes=modes)

    def _refresh_signing_clocks(self) -> None:
        second = int(self._hub.now())
        if second != self._signing_second:
            self._signing_second = second
            for vehicle in self.vehicles:
                vehicle.endpoint.refresh_signing_clock()

    # Between two ticks

    def _wait(self) -> None:
        """Receives until every streaming vehicle has its setpoint, or until the wall clock allows the next tick."""
        hub, began = self._hub, self._hub.now()
        waiting = self._awaited_vehicles()
        give_up = began + self.config.lockstep_timeout_s
        go_on = self._pace(began)
        first = True
        while not self.stopped:
            waiting = {vehicle for vehicle in waiting if self._owes_setpoint(vehicle)}
            now = hub.now()
            if waiting and now >= give_up:
                self._report_late(waiting)
                waiting = set()
            until = give_up if waiting else go_on
            if not first and not waiting and now >= until:
                break
            first = False
            for index, datagram in hub.receive(until - now):
                self._take(index, datagram)

    def _awaited_vehicles(self) -> set[Vehicle]:
        if not self.config.lockstep:
            return set()
        self._late = {
            vehicle for vehicle in self._late if vehicle.autopilot.setpoint_ms != self.t_ms - self.config.tick_ms
        }
        return {
            vehicle
            for vehicle in self.vehicles
            if vehicle.awaits_setpoint and vehicle.autopilot.is_streaming and vehicle not in self._late
        }

    def _owes_setpoint(self, vehicle: Vehicle) -> bool:
        """Whether its controller streams setpoints and has sent none since this tick's telemetry."""
        return vehicle.autopilot.is_streaming and vehicle.autopilot.setpoint_ms != self.t_ms

    def _pace(self, now: float) -> float:
        """Wall-clock time at which the next tick may begin, s."""
        tick_s = self.config.tick_ms / 1000.0 / self.speed
        if self.config.lockstep:
            return now + tick_s if any(self._needs_wall_clock(vehicle) for vehicle in self.vehicles) else now
        self._next_tick = max(self._next_tick, now - _CATCH_UP_S) + tick_s
        return self._next_tick

    def _needs_wall_clock(self, vehicle: Vehicle) -> bool:
        """Whether time must not run faster than `speed`, as no setpoints are waited for and the controller must keep up."""
        autopilot = vehicle.autopilot
        return not autopilot.crashed and (not autopilot.is_streaming or vehicle in self._late)

    def _report_late(self, late: set[Vehicle]) -> None:
        for vehicle in sorted(late, key=lambda vehicle: vehicle.config.id):
            self.lockstep_timeouts += 1
            self.report("lockstep_timeout", id=vehicle.config.id)
            logger.warning("vehicle %d sent no setpoint; no longer waiting for it", vehicle.config.id)
        self._late |= late

    def _take(self, index: int, datagram: bytes | None) -> None:
        if index == CONTROL:
            self._handle_control(datagram)
            return
        for hearer in range(len(self.vehicles)) if self.config.shared_ports else (index,):
            for frame in self.vehicles[hearer].receive(datagram or b""):
                self._send(hearer, frame)

    # Control lines

    def _handle_control(self, line: bytes | None) -> None:
        """Carries out a control line; one that makes no sense is answered with an `error` event."""
        try:
            command = control.parse(line)
            if command is not None:
                self._carry_out(command)
        except (ValueError, TypeError, KeyError) as error:
            logger.error("control: %s", error)
            self.report("error", reason=f"control: {error}")

    def _carry_out(self, command: control.Command) -> None:
        match command:
            case control.Stop():
                self.stopped = True
            case control.AddFault(fault):
                vehicle = self.vehicle(fault.id)
                if vehicle is None:
                    raise FaultError(f"there is no vehicle {fault.id}")
                vehicle.faults.add(fault)
            case control.PilotMode(identity, name):
                vehicle = self.vehicle(identity)
                if vehicle is None:
                    raise ValueError(f"there is no vehicle {identity}")
                vehicle.pilot_mode(name)
            case control.SetEpoch(unix_ms):
                self.epoch_unix_ms = unix_ms
            case control.SetSpeed(speed):
                self.speed = speed
            case control.ReportStats():
                self.report("stats", **self.stats())

    def stats(self) -> dict[str, Any]:
        """Statistics of the whole flight."""
        wall_s = self._hub.now() - self._started
        return {
            "simulated_s": self.t_ms / 1000.0,
            "wall_s": round(wall_s, 3),
            "realtime_factor": round(self.t_ms / 1000.0 / wall_s, 2) if wall_s > 0 else None,
            "lockstep_timeouts": self.lockstep_timeouts,
            "vehicles": [
                {
                    "id": vehicle.config.id,
                    "messages": vehicle.endpoint.received,
                    "damaged": vehicle.endpoint.damaged,
                    "unauthentic": vehicle.endpoint.unauthentic,
                    "setpoints": dict(sorted(vehicle.autopilot.counts.items())),
                    "flown_m": round(vehicle.autopilot.body.flown_m, 1),
                }
                for vehicle in self.vehicles
            ],
        }
