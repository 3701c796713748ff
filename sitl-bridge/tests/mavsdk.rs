//! MAVSDK, the other MAVLink library of companion computers, understands what the bridge sends,
//! and the bridge what MAVSDK sends.
//!
//! It is not part of the set-up: `.venv/bin/pip install mavsdk==4.1.0`, then `cargo test -p sitl-bridge --test mavsdk -- --ignored`.

use mavlink::dialects::common::{
    COMMAND_ACK_DATA, GLOBAL_POSITION_INT_DATA, HEARTBEAT_DATA, MavAutopilot, MavCmd, MavMessage, MavModeFlag,
    MavResult, MavState, MavType, V2_EXTENSION_DATA,
};
use sitl_bridge::frame::{Encoder, Frame, Reader, Source};
use sitl_bridge::signing::{Key, LinkSigning, Session, Timestamp, Unsigned};
use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};

/// What MAVSDK made of the frames: the messages it heard, and the frames that it sent.
fn peer(frames: &[Frame]) -> (Vec<serde_json::Value>, Vec<Frame>) {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let python = package.parent().expect("the workspace").join(".venv/bin/python");
    let mut command = Command::new(&python);
    command.arg(package.join("tests/mavsdk_peer.py")).stdin(Stdio::piped()).stdout(Stdio::piped());
    let child = command.stderr(Stdio::piped()).spawn();
    let mut child = child.unwrap_or_else(|e| panic!("{}: {e}. `cargo xtask setup simlink` makes it", python.display()));
    let bytes: Vec<u8> = frames.iter().flat_map(|f| f.bytes().to_vec()).collect();
    child.stdin.take().expect("a pipe").write_all(&bytes).expect("the peer reads");
    let output = child.wait_with_output().expect("the peer ends");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "`.venv/bin/pip install mavsdk==4.1.0` installs MAVSDK. {errors}");
    let mut said: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let serde_json::Value::Array(heard) = said["heard"].take() else { panic!("a list: {said}") };
    let digits = said["sent"].as_str().expect("digits");
    let byte = |at: usize| u8::from_str_radix(&digits[at..at + 2], 16).expect("a byte");
    let sent: Vec<u8> = (0..digits.len()).step_by(2).map(byte).collect();
    let mut reader = Reader::new(Source::Stream);
    reader.push(&sent);
    let frames = std::iter::from_fn(|| reader.next_frame()).collect();
    assert_eq!(reader.counts().total(), 0);
    (heard, frames)
}

#[test]
#[ignore = "needs MAVSDK: .venv/bin/pip install mavsdk==4.1.0"]
fn mavsdk_and_the_bridge_understand_each_other() {
    let mut encoder = Encoder::new(9, 191);
    let messages = [
        MavMessage::HEARTBEAT(HEARTBEAT_DATA {
            custom_mode: 4,
            mavtype: MavType::MAV_TYPE_QUADROTOR,
            autopilot: MavAutopilot::MAV_AUTOPILOT_ARDUPILOTMEGA,
            base_mode: MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED,
            system_status: MavState::MAV_STATE_ACTIVE,
            mavlink_version: 3,
        }),
        MavMessage::GLOBAL_POSITION_INT(GLOBAL_POSITION_INT_DATA {
            time_boot_ms: 84_000,
            lat: 473_977_418,
            lon: -85_455_939,
            ..GLOBAL_POSITION_INT_DATA::default()
        }),
        MavMessage::V2_EXTENSION(V2_EXTENSION_DATA {
            message_type: 0xC056,
            payload: std::array::from_fn(|i| i as u8),
            ..V2_EXTENSION_DATA::default()
        }),
        MavMessage::COMMAND_ACK(COMMAND_ACK_DATA {
            command: MavCmd::MAV_CMD_COMPONENT_ARM_DISARM,
            result: MavResult::MAV_RESULT_ACCEPTED,
        }),
    ];
    let plain = messages.map(|message| encoder.encode(&message).expect("a frame"));
    let link = LinkSigning::new(Key::new([1; 32]), 3, Unsigned::Refuse);
    let mut session = Session::new();
    let signed = plain.map(|frame| session.sign(&link, frame, Timestamp::now()).expect("a signed frame"));
    // This version of MAVSDK does not check signatures, but it reads signed frames. Its first
    // frame, the heartbeat, is always plain, as the peer takes its length for granted.
    for frames in [plain, [plain[0], signed[1], signed[2], signed[3]]] {
        let (heard, sent) = peer(&frames);
        let names: Vec<_> = heard.iter().map(|m| m["type"].as_str().expect("a name")).collect();
        assert_eq!(names, ["GLOBAL_POSITION_INT", "V2_EXTENSION", "COMMAND_ACK"]);
        assert!(heard.iter().all(|m| m["system"] == 9 && m["component"] == 191));
        let fields = |n: usize, name: &str| heard[n]["fields"][name].clone();
        assert_eq!((fields(0, "lat"), fields(0, "lon")), (473_977_418.into(), (-85_455_939).into()));
        assert_eq!(fields(0, "time_boot_ms"), 84_000);
        assert_eq!((fields(1, "message_type"), fields(1, "payload")[248].clone()), (0xC056.into(), 248.into()));
        assert_eq!(fields(2, "command"), 400);

        let setpoint = sent.iter().find(|f| f.message_id() == 84).expect("a setpoint");
        let MavMessage::SET_POSITION_TARGET_LOCAL_NED(setpoint) = setpoint.message().expect("its fields") else {
            panic!("{setpoint:?}")
        };
        assert_eq!((setpoint.time_boot_ms, setpoint.target_system, setpoint.target_component), (84_000, 9, 191));
        assert_eq!(setpoint.type_mask.bits(), 0x0C07);
        assert_eq!((setpoint.vx, setpoint.vy, setpoint.vz, setpoint.afx, setpoint.afy), (4.5, -4.5, 0.25, 1.25, -1.25));
        assert!(sent.iter().any(|f| matches!(f.message(), Ok(MavMessage::HEARTBEAT(h)) if h.mavlink_version == 3)));
    }
}
