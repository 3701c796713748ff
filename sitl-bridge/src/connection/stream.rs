//! Links that are streams: TCP and serial lines. A stream that breaks reconnects by itself.

use super::error::OpenError;
use super::poll::Watch;
use super::resolve::resolve;
use super::transfer::{Peer, Received, Sent};
use rustix::fs::{Mode, OFlags};
use rustix::termios::{
    ControlModes, InputModes, OptionalActions, SpecialCodeIndex, ioctl_tiocexcl, tcgetattr, tcsetattr,
};
use socket2::{Domain, Protocol, Socket, Type};
use std::fs::File;
use std::io::{self, ErrorKind, Read as _, Write as _};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::os::fd::{AsFd as _, BorrowedFd};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Time between a failure and the next attempt to reconnect.
const RETRY: Duration = Duration::from_secs(1);

/// A TCP peer that acknowledges nothing for so long is considered gone (TCP_USER_TIMEOUT).
const GONE: Duration = Duration::from_secs(5);

/// A stream and how to open it again.
#[derive(Debug)]
pub(super) struct StreamLink {
    dialer: Dialer,
    state: State,
    /// The rest of a frame that the transmit buffer had no room for.
    unsent: Vec<u8>,
}

#[derive(Debug)]
enum Dialer {
    /// To one of these addresses, in turn.
    Tcp {
        to: Vec<SocketAddr>,
        next: usize,
    },
    Listener {
        listener: TcpListener,
        local: SocketAddr,
    },
    Serial {
        path: PathBuf,
        baud: u32,
    },
}

#[derive(Debug)]
enum State {
    /// Broken; the next attempt is at this time.
    Down {
        until: Instant,
    },
    /// A TCP connection is being established.
    Dialing(TcpStream),
    Up(Line),
}

#[derive(Debug)]
enum Line {
    Tcp(TcpStream),
    Serial(File),
}

impl Line {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::Tcp(stream) => stream.read(buffer),
            Self::Serial(file) => file.read(buffer),
        }
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Self::Tcp(stream) => stream.write(bytes),
            Self::Serial(file) => file.write(bytes),
        }
    }

    fn fd(&self) -> BorrowedFd<'_> {
        match self {
            Self::Tcp(stream) => stream.as_fd(),
            Self::Serial(file) => file.as_fd(),
        }
    }
}

impl StreamLink {
    /// Connects to a server, now or whenever it comes up.
    pub(super) fn connect(host: &str, port: u16) -> Result<Self, OpenError> {
        let to = resolve(host, port)?;
        Ok(Self::new(Dialer::Tcp { to, next: 0 }, State::Down { until: Instant::now() }))
    }

    /// A server for one client at a time.
    pub(super) fn accept(host: &str, port: u16) -> Result<Self, OpenError> {
        let own = resolve(host, port)?[0];
        let failed = |source| OpenError::Bind { address: own.to_string(), source };
        let listener = TcpListener::bind(own).map_err(failed)?;
        listener.set_nonblocking(true).map_err(failed)?;
        let local = listener.local_addr().map_err(failed)?;
        Ok(Self::new(Dialer::Listener { listener, local }, State::Down { until: Instant::now() }))
    }

    /// Opens a serial line, and opens it again when its adapter comes back.
    pub(super) fn serial(path: &Path, baud: u32) -> Result<Self, OpenError> {
        let file = open_serial(path, baud).map_err(|source| OpenError::Serial { path: path.into(), source })?;
        Ok(Self::new(Dialer::Serial { path: path.into(), baud }, State::Up(Line::Serial(file))))
    }

    const fn new(dialer: Dialer, state: State) -> Self {
        Self { dialer, state, unsent: Vec::new() }
    }

    pub(super) fn recv(&mut self, buffer: &mut [u8]) -> Received {
        match self.reconnect() {
            Ok(true) => return Received::Connected,
            Ok(false) => {}
            Err(error) => return self.lose(error),
        }
        let State::Up(line) = &mut self.state else { return Received::Nothing };
        match line.read(buffer) {
            // The end of a TCP stream, or of a serial line whose adapter was pulled out.
            Ok(0) if !buffer.is_empty() => self.lose(ErrorKind::UnexpectedEof.into()),
            Ok(len) => Received::Bytes { len, peer: Peer(None) },
            Err(error) if is_nothing(&error) => Received::Nothing,
            Err(error) => self.lose(error),
        }
    }

    pub(super) fn send(&mut self, bytes: &[u8]) -> Sent {
        if !self.flush() {
            return Sent::NoPeer;
        }
        if !self.unsent.is_empty() {
            return Sent::Full;
        }
        // A frame is sent whole or not at all: what the transmit buffer has no room for waits here.
        self.unsent.extend_from_slice(bytes);
        if self.flush() { Sent::Yes } else { Sent::NoPeer }
    }

    pub(super) fn watch(&self) -> Option<Watch<'_>> {
        match (&self.state, &self.dialer) {
            (State::Up(line), _) => Some(Watch { fd: line.fd(), writes: !self.unsent.is_empty() }),
            (State::Dialing(stream), _) => Some(Watch { fd: stream.as_fd(), writes: true }),
            (State::Down { .. }, Dialer::Listener { listener, .. }) => {
                Some(Watch { fd: listener.as_fd(), writes: false })
            }
            (State::Down { .. }, _) => None,
        }
    }

    pub(super) const fn listens_on(&self) -> Option<SocketAddr> {
        match self.dialer {
            Dialer::Listener { local, .. } => Some(local),
            Dialer::Tcp { .. } | Dialer::Serial { .. } => None,
        }
    }

    pub(super) fn describe(&self) -> String {
        let up = matches!(self.state, State::Up(_));
        match &self.dialer {
            Dialer::Tcp { to, next } if up => format!("connected to tcp {}", to[next % to.len()]),
            Dialer::Tcp { to, next } => format!("waiting for tcp {}", to[next % to.len()]),
            Dialer::Listener { local, .. } if up => format!("serving one client on tcp {local}"),
            Dialer::Listener { local, .. } => format!("listening on tcp {local}"),
            Dialer::Serial { path, baud } if up => format!("serial line {} at {baud} bit/s", path.display()),
            Dialer::Serial { path, baud } => format!("waiting for serial line {} at {baud} bit/s", path.display()),
        }
    }

    pub(super) fn advice(&self) -> String {
        match &self.dialer {
            Dialer::Tcp { to, .. } => format!("the autopilot or simulator must serve tcp {}", to[0]),
            Dialer::Listener { local, .. } => format!("the autopilot must connect to tcp port {}", local.port()),
            Dialer::Serial { baud, .. } => format!(
                "the autopilot's port must speak MAVLink 2 at {baud} bit/s (ArduPilot: SERIALn_PROTOCOL 2 and \
                 SERIALn_BAUD; PX4: MAV_n_CONFIG and SER_…_BAUD); check that RX and TX are crossed"
            ),
        }
    }

    /// Takes the next step towards a connected stream. `true` when it has just become connected.
    fn reconnect(&mut self) -> io::Result<bool> {
        let line = match (&mut self.state, &mut self.dialer) {
            (State::Up(_), _) => return Ok(false),
            (State::Dialing(stream), _) => match connected(stream)? {
                false => return Ok(false),
                true => Line::Tcp(stream.try_clone()?),
            },
            (State::Down { .. }, Dialer::Listener { listener, .. }) => match listener.accept() {
                Ok((stream, _)) => {
                    let socket = Socket::from(stream);
                    prepare(&socket)?;
                    Line::Tcp(socket.into())
                }
                Err(error) if is_nothing(&error) => return Ok(false),
                Err(error) => return Err(error),
            },
            (State::Down { until }, _) if Instant::now() < *until => return Ok(false),
            (State::Down { .. }, Dialer::Tcp { to, next }) => {
                *next = (*next + 1) % to.len();
                self.state = State::Dialing(dial(to[*next])?);
                return Ok(false);
            }
            (State::Down { .. }, Dialer::Serial { path, baud }) => Line::Serial(open_serial(path, *baud)?),
        };
        self.state = State::Up(line);
        Ok(true)
    }

    /// Marks the stream as broken. Only one that was connected is reported as lost; a failed reconnection is
    /// not.
    fn lose(&mut self, error: io::Error) -> Received {
        let was_up = matches!(self.state, State::Up(_));
        self.state = State::Down { until: Instant::now() + RETRY };
        self.unsent.clear();
        if was_up { Received::Lost(error) } else { Received::Nothing }
    }

    /// Sends what waits, as far as the transmit buffer has room; `false` when the stream is broken. The next
    /// read then reports it.
    fn flush(&mut self) -> bool {
        let State::Up(line) = &mut self.state else { return false };
        while !self.unsent.is_empty() {
            match line.write(&self.unsent) {
                Ok(0) => return false,
                Ok(len) => drop(self.unsent.drain(..len)),
                Err(error) if is_nothing(&error) => return true,
                Err(_) => return false,
            }
        }
        true
    }
}

/// Begins a connection.
fn dial(to: SocketAddr) -> io::Result<TcpStream> {
    let socket = Socket::new(Domain::for_address(to), Type::STREAM, Some(Protocol::TCP))?;
    prepare(&socket)?;
    match socket.connect(&to.into()) {
        Err(error) if error.raw_os_error() != Some(rustix::io::Errno::INPROGRESS.raw_os_error()) => Err(error),
        _ => Ok(socket.into()),
    }
}

/// Makes calls non-blocking, sends each frame at once (TCP_NODELAY), and gives up a peer that is gone.
fn prepare(socket: &Socket) -> io::Result<()> {
    socket.set_nonblocking(true)?;
    socket.set_tcp_nodelay(true)?;
    socket.set_tcp_user_timeout(Some(GONE))
}

/// Whether the connection is established.
fn connected(stream: &TcpStream) -> io::Result<bool> {
    if let Some(error) = stream.take_error()? {
        return Err(error);
    }
    match stream.peer_addr() {
        Ok(_) => Ok(true),
        Err(error) if error.kind() == ErrorKind::NotConnected => Ok(false),
        Err(error) => Err(error),
    }
}

/// Opens a line for bytes as they are: no echo, no translation, no flow control, 8N1.
fn open_serial(path: &Path, baud: u32) -> io::Result<File> {
    let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
    let line = rustix::fs::open(path, flags, Mode::empty())?;
    let mut modes = tcgetattr(&line)?;
    // Two programs on one line would each get half of every frame.
    ioctl_tiocexcl(&line)?;
    modes.make_raw();
    modes.input_modes -= InputModes::IXON | InputModes::IXOFF | InputModes::IXANY;
    modes.control_modes |= ControlModes::CLOCAL | ControlModes::CREAD;
    modes.control_modes -= ControlModes::CRTSCTS | ControlModes::CSTOPB;
    // A read without bytes fails at once (VMIN = 1): a length of 0 means that the line is gone.
    modes.special_codes[SpecialCodeIndex::VMIN] = 1;
    modes.special_codes[SpecialCodeIndex::VTIME] = 0;
    modes.set_speed(baud)?;
    tcsetattr(&line, OptionalActions::Flush, &modes)?;
    Ok(File::from(line))
}

fn is_nothing(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted)
}
