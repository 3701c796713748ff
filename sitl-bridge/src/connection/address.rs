//! Connection strings.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;
use thiserror::Error;

/// The usual baud rate of telemetry radios and of autopilots' telemetry ports, bit/s.
const DEFAULT_BAUD: u32 = 57_600;

/// The address of a link, read from strings such as `udpin:0.0.0.0:14550`, `udp://:14540`,
/// `tcp:localhost:5760` or `serial:/dev/ttyACM0:57600`.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Address {
    /// Listens for datagrams and sends to the peer that sent authentic ones. `udp:` means this too.
    UdpIn {
        /// Own address, name or number; all of the computer's with 0.0.0.0 or `::`.
        host: String,
        /// Own port; 0 takes a free one.
        port: u16,
    },
    /// Sends datagrams to one address and receives only from it.
    UdpOut {
        /// The other end, name or number.
        host: String,
        /// Its port.
        port: u16,
    },
    /// A TCP client.
    Tcp {
        /// The server, name or number.
        host: String,
        /// Its port.
        port: u16,
    },
    /// A TCP server for one client at a time.
    TcpIn {
        /// Own address, name or number.
        host: String,
        /// Own port; 0 takes a free one.
        port: u16,
    },
    /// A serial line.
    Serial {
        /// The device.
        path: PathBuf,
        /// Its baud rate, bit/s.
        baud: u32,
    },
}

/// Why a connection string is refused.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum AddressError {
    /// It does not begin with a kind of connection.
    #[error(
        "`{0}` names no kind of connection: write udpin, udpout, tcp, tcpin or serial in front, as in `udpin:0.0.0.0:14550`"
    )]
    NoKind(String),
    /// It begins with an unknown kind of connection.
    #[error(
        "`{0}` is no kind of connection: there are udp, udpin, udpout, tcp, tcpin and serial, as in `udpin:0.0.0.0:14550`"
    )]
    UnknownKind(String),
    /// The host is missing, and the kind of link has no default.
    #[error("`{0}` lacks the host to connect to, as in `{1}:192.168.1.20:14550`")]
    NoHost(String, &'static str),
    /// The port is missing.
    #[error("`{0}` lacks the port, as in `{1}:127.0.0.1:14550`")]
    NoPort(String, &'static str),
    /// The port is no number up to 65535, or 0 where that cannot be.
    #[error("`{0}` is no port: a number from 1 to 65535, as in `{1}:127.0.0.1:14550`")]
    BadPort(String, &'static str),
    /// An IPv6 address without brackets, or brackets that do not close.
    #[error("`{0}`: an IPv6 address goes in brackets, as in `{1}:[::1]:14550`")]
    Brackets(String, &'static str),
    /// The serial line's device is missing.
    #[error("`{0}` lacks the device, as in `serial:/dev/ttyACM0:57600`")]
    NoDevice(String),
    /// The serial line's baud rate is no number.
    #[error("`{0}` is no speed in bit/s, as in `serial:/dev/ttyACM0:57600`")]
    BadBaud(String),
}

impl FromStr for Address {
    type Err = AddressError;

    fn from_str(text: &str) -> Result<Self, AddressError> {
        if text.starts_with("/dev/") {
            return serial(text, text);
        }
        let Some((kind, rest)) = text.split_once(':') else { return Err(AddressError::NoKind(text.into())) };
        let rest = rest.strip_prefix("//").unwrap_or(rest);
        match kind.to_ascii_lowercase().as_str() {
            "udp" => listener(text, rest, "udp").map(|(host, port)| Self::UdpIn { host, port }),
            "udpin" => listener(text, rest, "udpin").map(|(host, port)| Self::UdpIn { host, port }),
            "tcpin" => listener(text, rest, "tcpin").map(|(host, port)| Self::TcpIn { host, port }),
            "udpout" => target(text, rest, "udpout").map(|(host, port)| Self::UdpOut { host, port }),
            "tcp" => target(text, rest, "tcp").map(|(host, port)| Self::Tcp { host, port }),
            "serial" => serial(text, rest),
            // `127.0.0.1:14550` or `localhost:14550`: a host, not a kind.
            _ if rest.bytes().all(|b| b.is_ascii_digit()) => Err(AddressError::NoKind(text.into())),
            _ => Err(AddressError::UnknownKind(kind.into())),
        }
    }
}

/// The shortest string that reads back as the same address.
impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (kind, host, port) = match self {
            Self::UdpIn { host, port } => ("udpin", host, port),
            Self::UdpOut { host, port } => ("udpout", host, port),
            Self::Tcp { host, port } => ("tcp", host, port),
            Self::TcpIn { host, port } => ("tcpin", host, port),
            Self::Serial { path, baud } => return write!(f, "serial:{}:{baud}", path.display()),
        };
        if host.contains(':') { write!(f, "{kind}:[{host}]:{port}") } else { write!(f, "{kind}:{host}:{port}") }
    }
}

/// Host and port of a listener: without a host it is the whole computer.
fn listener(text: &str, rest: &str, kind: &'static str) -> Result<(String, u16), AddressError> {
    let (host, port) = match rest.bytes().all(|b| b.is_ascii_digit()) {
        true => ("", rest),
        false => split(text, rest, kind)?,
    };
    if port.is_empty() {
        return Err(AddressError::NoPort(text.into(), kind));
    }
    let port = port.parse().map_err(|_| AddressError::BadPort(port.into(), kind))?;
    Ok((if host.is_empty() { "0.0.0.0".into() } else { host.into() }, port))
}

/// Host and port of the other end: both are required.
fn target(text: &str, rest: &str, kind: &'static str) -> Result<(String, u16), AddressError> {
    if !rest.is_empty() && rest.bytes().all(|b| b.is_ascii_digit()) {
        return Err(AddressError::NoHost(text.into(), kind));
    }
    let (host, port) = split(text, rest, kind)?;
    if host.is_empty() {
        return Err(AddressError::NoHost(text.into(), kind));
    }
    match port.parse() {
        Ok(number) if number > 0 => Ok((host.into(), number)),
        _ => Err(AddressError::BadPort(port.into(), kind)),
    }
}

fn split<'a>(text: &str, rest: &'a str, kind: &'static str) -> Result<(&'a str, &'a str), AddressError> {
    let brackets = || AddressError::Brackets(text.into(), kind);
    let no_port = || AddressError::NoPort(text.into(), kind);
    if let Some(inner) = rest.strip_prefix('[') {
        let (host, port) = inner.split_once(']').ok_or_else(brackets)?;
        return match port.strip_prefix(':') {
            Some("") | None => Err(no_port()),
            Some(port) => Ok((host, port)),
        };
    }
    match rest.rsplit_once(':') {
        Some((host, _)) if host.contains(':') => Err(brackets()),
        Some((_, "")) | None => Err(no_port()),
        Some(parts) => Ok(parts),
    }
}

/// `DEVICE`, `DEVICE:BAUD` or `DEVICE,BAUD`.
fn serial(text: &str, rest: &str) -> Result<Address, AddressError> {
    let (path, baud) = match rest.rsplit_once([':', ',']) {
        // Names by path (`…-usb-0:1.2:1.0-port0`) have colons of their own and lines behind them.
        Some((path, baud)) if !baud.contains(['.', '-', '/']) => (path, Some(baud)),
        _ => (rest, None),
    };
    if path.is_empty() {
        return Err(AddressError::NoDevice(text.into()));
    }
    let baud = match baud {
        Some(baud) => baud.parse().ok().filter(|&b| b > 0).ok_or_else(|| AddressError::BadBaud(baud.into()))?,
        None => DEFAULT_BAUD,
    };
    Ok(Address::Serial { path: path.into(), baud })
}
