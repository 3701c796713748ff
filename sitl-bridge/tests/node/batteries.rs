//! Several batteries: the lowest that the vehicle flies by counts.

use crate::flight::Flight;
use crate::flying;
use firmware_core::gate::Reason;
use sitl_bridge::autopilot::Firmware;

const FIRMWARES: [Firmware; 2] = [Firmware::ArduPilot, Firmware::Px4];
/// MAV_BATTERY_FUNCTION.
const UNKNOWN: u8 = 0;
const ALL: u8 = 1;
const PROPULSION: u8 = 2;
const AVIONICS: u8 = 3;
const PAYLOAD: u8 = 4;

fn percent(flight: &Flight) -> Option<u8> {
    flight.node.status(flight.now()).battery
}

fn returns(flight: &mut Flight) -> bool {
    flight.until(10, |f| f.node.verdict().reason() == Some(Reason::BatteryLow))
}

#[test]
fn the_lowest_flight_battery_counts_whatever_the_first_has() {
    for firmware in FIRMWARES {
        for function in [UNKNOWN, ALL, PROPULSION] {
            let mut flight = flying(5, firmware);
            flight.vehicle.batteries = vec![(0, UNKNOWN, 90), (1, function, 40)];
            flight.ticks(50);
            assert_eq!((percent(&flight), flight.node.verdict().name()), (Some(40), "stream"), "{function}");
            flight.vehicle.batteries[1].2 = 12;
            assert!(returns(&mut flight), "{firmware:?} {function}: {:?}", flight.words());
        }
    }
}

#[test]
fn batteries_of_avionics_and_payload_end_no_flight() {
    for firmware in FIRMWARES {
        let mut flight = flying(5, firmware);
        flight.vehicle.batteries = vec![(0, PROPULSION, 80), (1, AVIONICS, 5), (2, PAYLOAD, 0)];
        assert!(!returns(&mut flight), "{:?}", flight.words());
        assert_eq!(percent(&flight), Some(80));
        // Nor do they stand for the flight battery where it is not told of.
        flight.vehicle.batteries.remove(0);
        flight.ticks(100);
        assert_eq!((percent(&flight), flight.node.verdict().name()), (Some(90), "stream"));
    }
}

#[test]
fn without_a_battery_of_its_own_the_summary_counts() {
    // SYS_STATUS alone; and BATTERY_STATUS without an estimate.
    for batteries in [Vec::new(), vec![(0, UNKNOWN, -1)]] {
        let mut flight = flying(5, Firmware::ArduPilot);
        flight.vehicle.batteries = batteries;
        flight.ticks(20);
        assert_eq!(percent(&flight), Some(90));
        flight.vehicle.battery = 20;
        assert!(returns(&mut flight), "{:?}", flight.words());
    }
}

#[test]
fn a_battery_that_is_told_of_counts_more_than_the_summary() {
    // SYS_STATUS speaks of a monitor that is none.
    let mut flight = flying(5, Firmware::ArduPilot);
    flight.vehicle.batteries = vec![(0, PROPULSION, 70)];
    flight.vehicle.battery = 0;
    // The first BATTERY_STATUS and SYS_STATUS come together.
    assert!(!returns(&mut flight), "{:?}", flight.words());
    assert_eq!(percent(&flight), Some(70));
}

#[test]
fn what_was_said_of_a_battery_counts_for_ten_seconds() {
    let mut flight = flying(5, Firmware::ArduPilot);
    flight.vehicle.batteries = vec![(0, UNKNOWN, 90), (1, UNKNOWN, 30)];
    flight.ticks(10);
    flight.vehicle.batteries.pop();
    flight.ticks(45);
    assert_eq!(percent(&flight), Some(30));
    flight.ticks(10);
    assert_eq!(percent(&flight), Some(90));
    // A second battery that was low once and is silent since is believed for as long.
    flight.vehicle.batteries.push((1, UNKNOWN, 10));
    flight.ticks(6);
    flight.vehicle.batteries.pop();
    assert!(returns(&mut flight), "{:?}", flight.words());
}

#[test]
fn nothing_known_of_any_battery_is_no_cause() {
    let mut flight = flying(5, Firmware::ArduPilot);
    flight.vehicle.battery = -1;
    flight.ticks(100);
    assert_eq!((percent(&flight), flight.node.verdict().name()), (None, "stream"));
}
