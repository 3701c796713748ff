//! Companion computers, by ssh: the node, the actor file and a service that starts them.

use super::actor_file::ActorFile;
use super::error::FlashError;
use super::progress::say;
use crate::command::Cmd;
use crate::error::{Error, Result};
use crate::setup;
use crate::targets::NEEDS;
use crate::targets::artefacts::Node;
use crate::workspace;

/// Folder in the user's home there.
const FOLDER: &str = "covey";
/// The service's description, in the source tree.
const UNIT: &str = "sitl-bridge/covey.service";

/// A computer that ssh reaches.
pub struct Host {
    name: String,
    ssh: String,
    scp: String,
}

impl Host {
    /// `name` is user@host; `ssh` and `scp` are the programs.
    pub fn new(name: &str, ssh: &str, scp: &str) -> Self {
        Self { name: name.into(), ssh: ssh.into(), scp: scp.into() }
    }

    /// Installs the node with this actor, and checks its signature over `cases` neighbourhoods there.
    ///
    /// # Errors
    /// See [`FlashError`]; or the build failed.
    pub fn install(&self, actor: &ActorFile, cases: u32, dry_run: bool) -> Result<()> {
        let unit = workspace::root().join(UNIT);
        let place = |file: &str| format!("{}:{FOLDER}/{file}.new", self.name);
        // Whole files replace the old ones in one move, also while the node runs.
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

    fn machine(&self) -> Cmd {
        self.shell("uname -m")
    }

    fn shell(&self, command: &str) -> Cmd {
        Cmd::new(&self.ssh).args(["-o", "BatchMode=yes", &self.name, command])
    }

    fn copy(&self, file: &str, to: &str) -> Cmd {
        Cmd::new(&self.scp).args(["-q", "-o", "BatchMode=yes", file, to])
    }

    fn run(&self, command: &Cmd) -> Result<String> {
        command.read().map_err(|error| match error {
            // ssh's own failures end with 255, all others are the command's.
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
