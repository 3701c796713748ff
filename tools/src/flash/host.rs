//! Installing the node, the actor file and a service that starts them on a companion computer, by ssh.

use super::actor_file::ActorFile;
use super::error::FlashError;
use super::progress::say;
use crate::command::Cmd;
use crate::error::{Error, Result};
use crate::setup;
use crate::targets::NEEDS;
use crate::targets::artefacts::Node;
use crate::workspace;

/// Folder for the node and the actor file, in the user's home on the companion computer.
const FOLDER: &str = "covey";
/// The systemd unit of the service, as a path from the workspace root.
const UNIT: &str = "sitl-bridge/covey.service";

/// A companion computer that is reached by ssh.
pub struct Host {
    name: String,
    ssh: String,
    scp: String,
}

impl Host {
    /// The computer `name` (user@host), reached with these two programs.
    pub fn new(name: &str, ssh: &str, scp: &str) -> Self {
        Self { name: name.into(), ssh: ssh.into(), scp: scp.into() }
    }

    /// Installs the node, the actor file and the service, after it has checked that the computer gets the same
    /// signature over `cases` neighbourhoods as this one. With `dry_run` it only prints the commands.
    ///
    /// # Errors
    /// The computer cannot be reached, no node is built for its processor, its signature differs, or the build
    /// failed.
    pub fn install(&self, actor: &ActorFile, cases: u32, dry_run: bool) -> Result<()> {
        let unit = workspace::root().join(UNIT);
        let place = |file: &str| format!("{}:{FOLDER}/{file}.new", self.name);
        // The files are copied beside the old ones and moved over them at the end, so the node is never half
        // replaced, even while it runs.
        let uploads = |node: &str| {
            [
                self.shell(&format!("mkdir -p {FOLDER} .config/systemd/user")),
                self.copy(node, &place("sitl-bridge")),
                self.copy(&actor.path.display().to_string(), &place("policy.actor")),
                self.copy(&unit.display().to_string(), &place("covey.service")),
            ]
        };
        let sign = self.shell(&format!(
            "chmod +x {FOLDER}/sitl-bridge.new && {FOLDER}/sitl-bridge.new signature --cases {cases} {FOLDER}/policy.actor.new"
        ));
        let switch = self.shell(&format!(
            "cd {FOLDER} && mv sitl-bridge.new sitl-bridge && mv policy.actor.new policy.actor && mv covey.service.new ../.config/systemd/user/covey.service && systemctl --user daemon-reload"
        ));
        if dry_run {
            say("would run, with the node built for that machine:");
            for command in [self.machine()].into_iter().chain(uploads("sitl-bridge")).chain([sign, switch]) {
                println!("  {command}");
            }
            return Ok(());
        }

        say(&format!("asking {} what it is", self.name));
        let machine = self.run(&self.machine())?;
        let node = match machine.trim() {
            "aarch64" | "arm64" => Node::Aarch64,
            "x86_64" => Node::Host,
            other => return Err(FlashError::WrongMachine { host: self.name.clone(), machine: other.into() }.into()),
        };
        if node == Node::Aarch64 {
            setup::install(NEEDS)?;
        }
        say(&format!("building the node for {}", node.target()));
        let program = node.build()?;
        say("copying the node, the actor file and the service");
        for command in uploads(&program.display().to_string()) {
            self.run(&command)?;
        }
        say("computing the actor's signature there and here");
        let (there, here) = (self.run(&sign)?, actor.signature(cases)?);
        if u64::from_str_radix(there.trim(), 16) != Ok(here) {
            let found = there.trim().to_owned();
            return Err(FlashError::Signature { place: self.name.clone(), found, expected: here }.into());
        }
        self.run(&switch)?;
        say(&format!(
            "installed, signature {here:016x} on both; start it there with:\n  ssh {} systemctl --user enable --now covey",
            self.name
        ));
        Ok(())
    }

    /// The command that asks for the computer's processor.
    fn machine(&self) -> Cmd {
        self.shell("uname -m")
    }

    /// A shell command on the computer.
    fn shell(&self, command: &str) -> Cmd {
        Cmd::new(&self.ssh).args(["-o", "BatchMode=yes", &self.name, command])
    }

    /// The command that copies a file of this computer to `to`, as scp names it.
    fn copy(&self, file: &str, to: &str) -> Cmd {
        Cmd::new(&self.scp).args(["-q", "-o", "BatchMode=yes", file, to])
    }

    /// Runs a command of ssh or scp and returns its output.
    fn run(&self, command: &Cmd) -> Result<String> {
        command.read().map_err(|error| match error {
            // Exit status 255 is a failure of ssh itself, every other one comes from the command on the computer.
            Error::Failed { status, output, .. } if status.ends_with(": 255") => {
                FlashError::NoHost { host: self.name.clone(), output: output.trim().into() }.into()
            }
            other => other,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_support::{Script, sample};
    use super::*;

    #[test]
    fn a_host_out_of_reach_is_told_from_a_wrong_one() {
        let unreachable = Script::new("echo 'Connection refused' >&2; exit 255");
        let host = Host::new("pilot@uav", &unreachable.path(), "false");
        let error = host.install(&sample(), 1, false).unwrap_err();
        assert!(matches!(&error, Error::Flash(FlashError::NoHost { output, .. }) if output == "Connection refused"));
        let other = Script::new("echo riscv64");
        let error = Host::new("pilot@uav", &other.path(), "false").install(&sample(), 1, false).unwrap_err();
        assert!(matches!(&error, Error::Flash(FlashError::WrongMachine { machine, .. }) if machine == "riscv64"));
    }

    #[test]
    fn a_dry_run_calls_nothing() {
        let script = Script::new(r#"echo "$@" >> "$0.log"; exit 1"#);
        Host::new("pilot@uav", &script.path(), &script.path()).install(&sample(), 1, true).unwrap();
        assert_eq!(script.log(), "");
    }
}
