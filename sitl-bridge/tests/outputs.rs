//! A flight whose outputs nobody reads, as a process of its own.

#[path = "node/mission.rs"]
mod mission;
#[path = "node/vehicle.rs"]
#[allow(dead_code)]
mod vehicle;

use firmware_core::geometry::Vec2;
use rustix::fs::{OFlags, fcntl_getfl, fcntl_setfl};
use sitl_bridge::autopilot::Firmware;
use sitl_bridge::frame::{Reader, Source};
use std::io::{PipeReader, PipeWriter, Write as _, pipe};
use std::net::{SocketAddr, UdpSocket};
use std::process::{Command, Stdio};
use vehicle::Vehicle;

/// A pipe that has no room left.
fn full_pipe() -> (PipeReader, PipeWriter) {
    let (reader, mut writer) = pipe().unwrap();
    let flags = fcntl_getfl(&writer).unwrap();
    fcntl_setfl(&writer, flags | OFlags::NONBLOCK).unwrap();
    while writer.write(b".").is_ok() {}
    fcntl_setfl(&writer, flags).unwrap();
    (reader, writer)
}

/// The vehicle's end of the link. The node sends one HEARTBEAT in a second of the vehicle's clock: who waits for it
/// needs no clock of his own.
struct Link {
    socket: UdpSocket,
    node: SocketAddr,
    vehicle: Vehicle,
}

impl Link {
    /// Takes in what the node sends, up to its next heartbeat.
    fn hear(&mut self) {
        let before = self.vehicle.heartbeats;
        while self.vehicle.heartbeats == before {
            self.take();
        }
    }

    fn take(&mut self) {
        let mut buffer = [0; 512];
        let (len, node) = self.socket.recv_from(&mut buffer).unwrap();
        self.node = node;
        let mut reader = Reader::new(Source::Datagrams);
        reader.push(&buffer[..len]);
        while let Some(frame) = reader.next_frame() {
            self.vehicle.hear(&frame);
        }
    }

    fn tick(&mut self) {
        for frame in self.vehicle.tick() {
            self.socket.send_to(frame.bytes(), self.node).unwrap();
        }
    }

    /// A second of the vehicle's time.
    fn second(&mut self) {
        (0..5).for_each(|_| self.tick());
        self.hear();
    }

    /// Whether a setpoint has answered what the vehicle told last.
    fn is_answered(&self) -> bool {
        self.vehicle.setpoints.last().is_some_and(|setpoint| setpoint.boot_ms == self.vehicle.boot_ms)
    }

    /// A second in flight, where the node answers every position with a setpoint.
    fn second_in_flight(&mut self) {
        for _ in 0..5 {
            self.tick();
            while !self.is_answered() {
                self.take();
            }
        }
    }
}

#[test]
fn outputs_that_nobody_reads_stop_no_flight_and_no_order() {
    let folder = tempfile::tempdir().unwrap();
    let mission = mission::mission();
    let path = folder.path().join("m.toml");
    std::fs::write(&path, mission.to_toml("")).unwrap();
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    let address = format!("udpout:{}", socket.local_addr().unwrap());
    let ((_unread, output), (_unheard, errors)) = (full_pipe(), full_pipe());
    let args = ["fly", "--id", "5", "--vehicle-system", "7", "--takeoff", "--simulated", "--json", "--autopilot"];
    let mut node = Command::new(env!("CARGO_BIN_EXE_sitl-bridge"))
        .args(args)
        .arg(address)
        .arg("--mission")
        .arg(&path)
        .stdin(Stdio::piped())
        .stdout(output)
        .stderr(errors)
        .spawn()
        .unwrap();
    let vehicle = Vehicle::new(Firmware::ArduPilot, &mission, Vec2::from_u(100.0, 100.0));
    let mut link = Link { node: socket.local_addr().unwrap(), socket, vehicle };
    // The first tells from where it sends.
    link.hear();
    let mut seconds = 0;
    while link.vehicle.setpoints.is_empty() {
        link.second();
        seconds += 1;
        assert!(seconds < 300, "not in flight: {:?}", link.vehicle.commands);
    }
    // Every position is answered.
    (0..20).for_each(|_| link.second_in_flight());
    // What is no command is answered, on a standard error that is full: the next one is heard all the same.
    let mut console = node.stdin.take().unwrap();
    console.write_all(b"hover\nhover\nland\n").unwrap();
    while link.vehicle.custom_mode != 9 {
        link.second();
        seconds += 1;
        assert!(seconds < 1000, "`land` was not heard");
    }
    rustix::process::kill_process(rustix::process::Pid::from_child(&node), rustix::process::Signal::TERM).unwrap();
    assert!(node.wait().unwrap().success());
}
