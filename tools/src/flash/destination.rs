//! What `--host` names: another computer, as ssh and scp want it.

use super::error::FlashError;

/// A computer that ssh reaches.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Destination {
    /// The user with an `@`, or nothing.
    user: String,
    /// Name or address, IPv6 without brackets.
    host: String,
    port: Option<u16>,
}

impl Destination {
    /// Reads `user@host`, `user@host:port`, `user@[IPv6]:port`, or any of them after `ssh://`; the user may be left
    /// out.
    ///
    /// # Errors
    /// [`FlashError::BadHost`].
    pub fn read(text: &str) -> Result<Self, FlashError> {
        Self::parse(text).map_err(|what| FlashError::BadHost { given: text.into(), what })
    }

    fn parse(text: &str) -> Result<Self, &'static str> {
        let rest = match text.split_once("://") {
            Some(("ssh", rest)) => rest.strip_suffix('/').unwrap_or(rest),
            Some(_) => return Err("the only scheme is ssh://"),
            None => text,
        };
        let (user, rest) = rest.rsplit_once('@').map_or(("", rest), |(user, rest)| (user, rest));
        let (host, port) = match rest.strip_prefix('[') {
            Some(bracketed) => {
                let (host, after) = bracketed.split_once(']').ok_or("a bracket is not closed")?;
                match after.strip_prefix(':') {
                    Some(port) => (host, Some(port)),
                    None if after.is_empty() => (host, None),
                    None => return Err("what follows the bracket is no :port"),
                }
            }
            // More than one colon is an IPv6 address, which has a port behind brackets only.
            None if rest.matches(':').count() > 1 => (rest, None),
            None => rest.split_once(':').map_or((rest, None), |(host, port)| (host, Some(port))),
        };
        let odd =
            |part: &str| part.starts_with('-') || part.contains(|c: char| c.is_whitespace() || "/[]'\"".contains(c));
        if host.is_empty() {
            return Err("the host is missing");
        }
        if odd(host) || odd(user) {
            return Err("user and host are names or addresses");
        }
        let number = |port: &str| port.parse().ok().filter(|&port| port != 0).ok_or("the port is 1 to 65535");
        let user = if user.is_empty() { String::new() } else { format!("{user}@") };
        Ok(Self { user, host: host.into(), port: port.map(number).transpose()? })
    }

    /// As ssh takes it, without the port: user@host.
    pub fn for_ssh(&self) -> String {
        format!("{}{}", self.user, self.host)
    }

    /// A path there, as scp takes it.
    pub fn path(&self, file: &str) -> String {
        let (user, host) = (&self.user, &self.host);
        if host.contains(':') { format!("{user}[{host}]:{file}") } else { format!("{user}{host}:{file}") }
    }

    /// The port as an option of ssh (`-p`) or of scp (`-P`); nothing for the usual one.
    pub fn port(&self, flag: &str) -> Vec<String> {
        self.port.iter().flat_map(|port| [flag.to_owned(), port.to_string()]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_form_is_read() {
        let cases = [
            ("pilot@uav", "pilot@uav", "pilot@uav:f", None),
            ("uav", "uav", "uav:f", None),
            ("pilot@uav:2222", "pilot@uav", "pilot@uav:f", Some("2222")),
            ("ssh://pilot@uav:2222", "pilot@uav", "pilot@uav:f", Some("2222")),
            ("ssh://uav/", "uav", "uav:f", None),
            ("pilot@[fe80::1%eth0]:2222", "pilot@fe80::1%eth0", "pilot@[fe80::1%eth0]:f", Some("2222")),
            ("[::1]", "::1", "[::1]:f", None),
            ("pilot@fe80::1", "pilot@fe80::1", "pilot@[fe80::1]:f", None),
        ];
        for (text, ssh, path, port) in cases {
            let read = Destination::read(text).unwrap();
            assert_eq!((read.for_ssh().as_str(), read.path("f").as_str()), (ssh, path), "{text}");
            assert_eq!(read.port("-p"), port.map_or(vec![], |port| vec!["-p", port]), "{text}");
        }
    }

    #[test]
    fn what_names_no_computer_is_refused() {
        for text in
            ["", "pilot@", "uav:", "uav:0", "uav:65536", "uav:ssh", "[::1", "[::1]2", "http://uav", "-oProxy=x", "a b"]
        {
            let error = Destination::read(text).unwrap_err().to_string();
            assert!(error.contains("user@host:port"), "{text}: {error}");
        }
    }
}
