"""The messages that an autopilot sends, made from the state of its vehicle."""

import math

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from simlink.batteries import FUNCTIONS, OtherBattery
from simlink.geodesy import deg_e7
from simlink.px4 import Px4
from simlink.vehicle_state import VehicleState

_HEALTH = (
    mavlink.MAV_SYS_STATUS_SENSOR_3D_GYRO
    | mavlink.MAV_SYS_STATUS_SENSOR_3D_ACCEL
    | mavlink.MAV_SYS_STATUS_SENSOR_3D_MAG
    | mavlink.MAV_SYS_STATUS_SENSOR_ABSOLUTE_PRESSURE
    | mavlink.MAV_SYS_STATUS_SENSOR_GPS
    | mavlink.MAV_SYS_STATUS_AHRS
    | mavlink.MAV_SYS_STATUS_PREARM_CHECK
    | mavlink.MAV_SYS_STATUS_SENSOR_BATTERY
)
_EKF_ALWAYS = mavlink.EKF_ATTITUDE | mavlink.EKF_VELOCITY_VERT | mavlink.EKF_POS_VERT_ABS
_EKF_POSITION = (
    mavlink.EKF_VELOCITY_HORIZ
    | mavlink.EKF_POS_HORIZ_REL
    | mavlink.EKF_POS_HORIZ_ABS
    | mavlink.EKF_PRED_POS_HORIZ_REL
    | mavlink.EKF_PRED_POS_HORIZ_ABS
)
_PX4_AT_REST = 1023
_GOOD_VARIANCE, _BAD_VARIANCE = 0.05, 1.3
_CELLS, _FULL_CELL_V, _EMPTY_CELL_V = 4, 4.2, 3.3


def heartbeat(vehicle: VehicleState) -> mavlink.MAVLink_message:
    """HEARTBEAT."""
    autopilot = vehicle.autopilot
    base_mode = mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED | mavlink.MAV_MODE_FLAG_STABILIZE_ENABLED
    if autopilot.mode.name == autopilot.GUIDED_MODE:
        base_mode |= mavlink.MAV_MODE_FLAG_GUIDED_ENABLED
    if autopilot.armed:
        base_mode |= mavlink.MAV_MODE_FLAG_SAFETY_ARMED
    if autopilot.gcs_failsafe:
        status = mavlink.MAV_STATE_CRITICAL
    elif autopilot.armed and autopilot.airborne:
        status = mavlink.MAV_STATE_ACTIVE
    else:
        status = mavlink.MAV_STATE_STANDBY if autopilot.ekf_ready else mavlink.MAV_STATE_CALIBRATING
    kind = mavlink.MAV_AUTOPILOT_PX4 if isinstance(autopilot, Px4) else mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA
    return mavlink.MAVLink_heartbeat_message(
        mavlink.MAV_TYPE_QUADROTOR, kind, base_mode, autopilot.mode.custom_mode, status, 3
    )


def sys_status(vehicle: VehicleState) -> mavlink.MAVLink_message:
    """SYS_STATUS."""
    health = _HEALTH
    if not vehicle.autopilot.ekf_ready:
        health &= ~(mavlink.MAV_SYS_STATUS_AHRS | mavlink.MAV_SYS_STATUS_PREARM_CHECK)
    if vehicle.autopilot.gps_lost_ms is not None:
        health &= ~mavlink.MAV_SYS_STATUS_SENSOR_GPS
    percent = vehicle.battery_percent()
    return mavlink.MAVLink_sys_status_message(
        _HEALTH, _HEALTH, health, 300, _battery_mv(percent), 1500, round(percent), 0, 0, 0, 0, 0, 0
    )


def battery_status(vehicle: VehicleState) -> mavlink.MAVLink_message:
    """BATTERY_STATUS."""
    return _battery_status(0, FUNCTIONS["unknown"], vehicle.battery_percent())


def other_battery_status(battery: OtherBattery) -> mavlink.MAVLink_message:
    """BATTERY_STATUS of a battery besides the first."""
    return _battery_status(battery.id, FUNCTIONS[battery.function], battery.percent)


def _battery_status(number: int, function: int, percent: float) -> mavlink.MAVLink_message:
    cell = _battery_mv(percent) // _CELLS
    voltages = [cell] * _CELLS + [0xFFFF] * (10 - _CELLS)
    return mavlink.MAVLink_battery_status_message(number, function, 1, 2500, voltages, 1500, -1, -1, round(percent))


def _battery_mv(percent: float) -> int:
    return round(1000 * _CELLS * (_EMPTY_CELL_V + (_FULL_CELL_V - _EMPTY_CELL_V) * percent / 100.0))


def system_time(vehicle: VehicleState) -> mavlink.MAVLink_message:
    """SYSTEM_TIME; the time of day is unknown until there is a position."""
    if vehicle.faults.is_active("clock_unset"):
        return mavlink.MAVLink_system_time_message(vehicle.boot_us, vehicle.boot_ms)
    known = vehicle.autopilot.ekf_ready or vehicle.autopilot.airborne
    return mavlink.MAVLink_system_time_message(vehicle.unix_ms * 1000 if known else 0, vehicle.boot_ms)


def gps_raw_int(vehicle: VehicleState) -> mavlink.MAVLink_message:
    """GPS_RAW_INT."""
    e = vehicle.estimate()
    latitude, longitude = vehicle.plane.degrees(e.east, e.north)
    lost = vehicle.autopilot.gps_lost_ms is not None
    fix, satellites, eph = (1, 3, 0xFFFF) if lost else (3, 14, 80)
    course = round(math.degrees(math.atan2(e.ve, e.vn)) % 360.0 * 100.0) % 36_000
    return mavlink.MAVLink_gps_raw_int_message(
        vehicle.boot_us,
        fix,
        deg_e7(latitude),
        deg_e7(longitude),
        round((vehicle.plane.altitude_m + e.up) * 1000),
        eph,
        eph,
        min(round(math.hypot(e.ve, e.vn) * 100), 0xFFFE),
        course,
        satellites,
    )


def global_position_int(vehicle: VehicleState) -> mavlink.MAVLink_message:
    """GLOBAL_POSITION_INT."""
    e = vehicle.estimate()
    latitude, longitude = vehicle.plane.degrees(e.east, e.north)
    home = vehicle.autopilot.home
    return mavlink.MAVLink_global_position_int_message(
        vehicle.boot_ms,
        deg_e7(latitude),
        deg_e7(longitude),
        round((vehicle.plane.altitude_m + e.up) * 1000),
        round((e.up - (home[2] if home else vehicle.pad[2])) * 1000),
        round(e.vn * 100),
        round(e.ve * 100),
        round(-e.vu * 100),
        0,
    )


def local_position_ned(vehicle: VehicleState) -> mavlink.MAVLink_message:
    """LOCAL_POSITION_NED, relative to the vehicle's own EKF origin."""
    e = vehicle.estimate()
    east, north, up = vehicle.ekf_origin
    x, vx = e.north - north, e.vn
    if vehicle.faults.is_active("nan"):
        x, vx = math.nan, math.inf
    return mavlink.MAVLink_local_position_ned_message(vehicle.boot_ms, x, e.east - east, up - e.up, vx, e.ve, -e.vu)


def gps_global_origin(vehicle: VehicleState) -> mavlink.MAVLink_message:
    """GPS_GLOBAL_ORIGIN: the EKF origin."""
    east, north, up = vehicle.ekf_origin
    latitude, longitude = vehicle.plane.degrees(east, north)
    altitude = round((vehicle.plane.altitude_m + up) * 1000)
    return mavlink.MAVLink_gps_global_origin_message(deg_e7(latitude), deg_e7(longitude), altitude, vehicle.boot_us)


def home_position(vehicle: VehicleState) -> mavlink.MAVLink_message:
    """HOME_POSITION."""
    home = vehicle.autopilot.home or vehicle.pad
    origin = vehicle.ekf_origin
    latitude, longitude = vehicle.plane.degrees(home[0], home[1])
    altitude = round((vehicle.plane.altitude_m + home[2]) * 1000)
    return mavlink.MAVLink_home_position_message(
        deg_e7(latitude),
        deg_e7(longitude),
        altitude,
        home[1] - origin[1],
        home[0] - origin[0],
        origin[2] - home[2],
        (1.0, 0.0, 0.0, 0.0),
        0.0,
        0.0,
        0.0,
        vehicle.boot_us,
    )


def extended_sys_state(vehicle: VehicleState) -> mavlink.MAVLink_message:
    """EXTENDED_SYS_STATE."""
    if not vehicle.autopilot.airborne:
        landed = mavlink.MAV_LANDED_STATE_ON_GROUND
    elif vehicle.autopilot.flight.climbing:
        landed = mavlink.MAV_LANDED_STATE_TAKEOFF
    else:
        landed = mavlink.MAV_LANDED_STATE_IN_AIR
    return mavlink.MAVLink_extended_sys_state_message(0, landed)


def ekf_status_report(vehicle: VehicleState) -> mavlink.MAVLink_message:
    """EKF_STATUS_REPORT (ArduPilot)."""
    flags, variance = _ekf(vehicle)
    return mavlink.MAVLink_ekf_status_report_message(flags, variance, variance, variance, variance, 0.0, 0.0)


def estimator_status(vehicle: VehicleState) -> mavlink.MAVLink_message:
    """ESTIMATOR_STATUS (PX4); its flags share their bits with EKF_STATUS_REPORT up to the tenth.

    On the ground all ten are set, constant position among them, as was seen on PX4 at rest.
    """
    flags, ratio = _ekf(vehicle)
    if vehicle.autopilot.ekf_ready and not vehicle.autopilot.airborne:
        flags = _PX4_AT_REST
    if flags & mavlink.EKF_UNINITIALIZED:
        flags = 0
    return mavlink.MAVLink_estimator_status_message(
        vehicle.boot_us, flags, ratio, ratio, ratio, ratio, 0.0, 0.0, 0.3 if ratio < 1.0 else 20.0, 0.4
    )


def _ekf(vehicle: VehicleState) -> tuple[int, float]:
    autopilot = vehicle.autopilot
    if autopilot.ekf_ready:
        return _EKF_ALWAYS | _EKF_POSITION, _GOOD_VARIANCE
    if autopilot.ekf_bad:
        return _EKF_ALWAYS | mavlink.EKF_VELOCITY_HORIZ | mavlink.EKF_POS_HORIZ_REL, _BAD_VARIANCE
    if autopilot.gps_lost_ms is not None:
        return _EKF_ALWAYS | mavlink.EKF_CONST_POS_MODE, _GOOD_VARIANCE
    return mavlink.EKF_UNINITIALIZED, 0.0


def attitude(vehicle: VehicleState) -> mavlink.MAVLink_message:
    """ATTITUDE: leans as the acceleration needs, nose to the north."""
    body = vehicle.autopilot.body
    roll, pitch = math.atan2(body.acceleration_e, 9.81), -math.atan2(body.acceleration_n, 9.81)
    return mavlink.MAVLink_attitude_message(vehicle.boot_ms, roll, pitch, 0.0, 0.0, 0.0, 0.0)


def vfr_hud(vehicle: VehicleState) -> mavlink.MAVLink_message:
    """VFR_HUD."""
    e = vehicle.estimate()
    speed = math.hypot(e.ve, e.vn)
    throttle = 40 if vehicle.autopilot.armed else 0
    return mavlink.MAVLink_vfr_hud_message(speed, speed, 0, throttle, vehicle.plane.altitude_m + e.up, e.vu)


def autopilot_version(vehicle: VehicleState) -> mavlink.MAVLink_message:
    """AUTOPILOT_VERSION."""
    capabilities = (
        mavlink.MAV_PROTOCOL_CAPABILITY_PARAM_FLOAT
        | mavlink.MAV_PROTOCOL_CAPABILITY_COMMAND_INT
        | mavlink.MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_LOCAL_NED
        | mavlink.MAV_PROTOCOL_CAPABILITY_MAVLINK2
    )
    major, minor = (1, 15) if isinstance(vehicle.autopilot, Px4) else (4, 7)
    none = (0,) * 8
    return mavlink.MAVLink_autopilot_version_message(
        capabilities, major << 24 | minor << 16, 0, 0, 0, none, none, none, 0, 0, vehicle.config.system
    )
