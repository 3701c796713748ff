use proptest::prelude::*;
use sitl_bridge::connection::Address;
use sitl_bridge::swarm_link::SwarmAddress;

fn read(text: &str) -> String {
    text.parse::<Address>().map_or_else(|e| panic!("{text}: {e}"), |a| a.to_string())
}

#[test]
fn connections_are_read_as_users_of_other_programs_write_them() {
    for (text, expected) in [
        // pymavlink and MAVProxy.
        ("udpin:0.0.0.0:14550", "udpin:0.0.0.0:14550"),
        ("udp:127.0.0.1:14550", "udpin:127.0.0.1:14550"),
        ("udpout:192.168.1.20:14550", "udpout:192.168.1.20:14550"),
        ("tcp:localhost:5760", "tcp:localhost:5760"),
        ("tcpin:0.0.0.0:5770", "tcpin:0.0.0.0:5770"),
        ("/dev/ttyUSB0", "serial:/dev/ttyUSB0:57600"),
        ("/dev/ttyUSB0,115200", "serial:/dev/ttyUSB0:115200"),
        // MAVSDK.
        ("udp://:14540", "udpin:0.0.0.0:14540"),
        ("udpin://0.0.0.0:14540", "udpin:0.0.0.0:14540"),
        ("udpout://127.0.0.1:14580", "udpout:127.0.0.1:14580"),
        ("tcp://10.0.0.2:5760", "tcp:10.0.0.2:5760"),
        ("serial:///dev/ttyACM0:921600", "serial:/dev/ttyACM0:921600"),
        // rust-mavlink, and short forms.
        ("serial:/dev/ttyACM0:57600", "serial:/dev/ttyACM0:57600"),
        ("serial:/dev/ttyACM0", "serial:/dev/ttyACM0:57600"),
        ("udpin:14550", "udpin:0.0.0.0:14550"),
        ("udp::14550", "udpin:0.0.0.0:14550"),
        ("UDPIN:0.0.0.0:0", "udpin:0.0.0.0:0"),
        ("udpin:[::]:14550", "udpin:[::]:14550"),
        ("udpout:[fe80::1%eth0]:14550", "udpout:[fe80::1%eth0]:14550"),
        ("tcp://[::1]:5760", "tcp:[::1]:5760"),
        (
            "serial:/dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.0-port0",
            "serial:/dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.0-port0:57600",
        ),
    ] {
        assert_eq!(read(text), expected);
        assert_eq!(read(expected), expected);
    }
}

#[test]
fn a_wrong_connection_string_is_told_by_its_part_with_an_example() {
    for (text, part) in [
        ("", "names no kind"),
        ("14550", "names no kind"),
        ("localhost:14550", "names no kind"),
        ("192.168.1.1:14550", "names no kind"),
        ("http://localhost:80", "`http`"),
        ("udp:localhost", "lacks the port"),
        ("udpin:", "lacks the port"),
        ("udpin://", "lacks the port"),
        ("tcp:localhost:", "lacks the port"),
        ("udpin:[::1]", "lacks the port"),
        ("udpin:0.0.0.0:99999", "`99999`"),
        ("udpin:99999", "`99999`"),
        ("udpin:0.0.0.0:abc", "`abc`"),
        ("udpin:0.0.0.0:-1", "`-1`"),
        ("udpout:localhost:0", "`0`"),
        ("udpout::14550", "lacks the host"),
        ("udpout:14550", "lacks the host"),
        ("tcp://:5760", "lacks the host"),
        ("tcp:::1:5760", "brackets"),
        ("udpin:[::1:14550", "brackets"),
        ("serial:", "lacks the device"),
        ("serial::57600", "lacks the device"),
        ("serial:/dev/ttyUSB0:57k6", "`57k6`"),
        ("serial:/dev/ttyUSB0:0", "`0`"),
        ("serial:/dev/ttyUSB0:", "``"),
    ] {
        let error = text.parse::<Address>().expect_err(text).to_string();
        assert!(error.contains(part), "{text}: {error}");
        // The example in the message is itself accepted.
        let example = error.rsplit('`').nth(1).expect("an example in backquotes");
        assert!(example.parse::<Address>().is_ok(), "{text}: {error}");
    }
}

#[test]
fn swarms_are_reached_by_multicast_broadcast_or_peers() {
    for text in [
        "multicast:239.86.67.1:14600",
        "multicast:239.86.67.1:14600@192.168.4.2",
        "broadcast:192.168.4.255:14600",
        "peers:0.0.0.0:14600,192.168.4.3:14600,192.168.4.4:14601",
        "peers:127.0.0.1:0",
        "peers:[::]:14600,[fe80::2]:14600",
    ] {
        assert_eq!(text.parse::<SwarmAddress>().unwrap_or_else(|e| panic!("{text}: {e}")).to_string(), text);
    }
    assert_eq!("multicast://239.86.67.1:1".parse::<SwarmAddress>().unwrap().to_string(), "multicast:239.86.67.1:1");
    for (text, part) in [
        ("", "reached by"),
        ("239.86.67.1:14600", "reached by"),
        ("anycast:1.2.3.4:5", "`anycast`"),
        ("multicast:192.168.4.2:14600", "no multicast address"),
        ("multicast:239.86.67.1", "`239.86.67.1`"),
        ("multicast:239.86.67.1:14600@eth0", "`eth0`"),
        ("broadcast:192.168.4.255:0", "`192.168.4.255:0`"),
        ("peers:", "``"),
        ("peers:0.0.0.0:14600,drone2:14600", "`drone2:14600`"),
        ("peers:0.0.0.0:14600,1.2.3.4:0", "`1.2.3.4:0`"),
    ] {
        let error = text.parse::<SwarmAddress>().expect_err(text).to_string();
        assert!(error.contains(part), "{text}: {error}");
    }
}

proptest! {
    #[test]
    fn no_text_breaks_the_readers(text in "(udp|udpin|tcp|serial|multicast|peers|x)?:?[/\\[\\]:,@.0-9a-z%-]{0,30}") {
        if let Ok(address) = text.parse::<Address>() {
            prop_assert_eq!(address.to_string().parse(), Ok(address));
        }
        if let Ok(address) = text.parse::<SwarmAddress>() {
            prop_assert_eq!(address.to_string().parse(), Ok(address));
        }
    }
}
