//! Installing the node, the actor file and a service that starts them on a companion computer, by ssh.

use super::actor_file::ActorFile;
use super::destination::Destination;
use super::error::FlashError;
use super::progress::say;
use crate::command::Cmd;
use crate::error::{Error, Result};
use crate::output::print;
use crate::setup;
use crate::targets::NEEDS;
use crate::targets::artefacts::Node;
use crate::workspace;

/// Folder for the node and the actor file, in the user's home on the companion computer.
const FOLDER: &str = "covey";
/// The systemd unit of the service, as a path from the workspace root.
const UNIT: &str = "sitl-bridge/covey.service";
/// What is there when something failed before the switch.
const UNTOUCHED: &str = "what was installed there before is as it was: the new files lie beside it in ~/covey, with .new at the end of their names; the same command begins again";
/// What is there when the switch failed.
const HALF_SWITCHED: &str = "the new files are there and checked, but not all are in place: node, actor file and service may be old or new; do not start it there before the same command has succeeded";

/// A companion computer that is reached by ssh.
pub struct Host {
    /// As on the command line.
    name: String,
    place: Destination,
    ssh: String,
    scp: String,
}

impl Host {
    /// The computer `name`, as [`Destination::read`] reads it, reached with these two programs.
    ///
    /// # Errors
    /// The name names no computer.
    pub fn new(name: &str, ssh: &str, scp: &str) -> Result<Self> {
        let place = Destination::read(name)?;
        Ok(Self { name: name.into(), place, ssh: ssh.into(), scp: scp.into() })
    }

    /// Installs the node, the actor file and the service, after it has checked that the computer gets the same
    /// signature over `cases` neighbourhoods as this one. With `dry_run` it only prints the commands.
    ///
    /// # Errors
    /// The computer cannot be reached, no node is built for its processor, its signature differs, or the build
    /// failed.
    pub fn install(&self, actor: &ActorFile, cases: u32, dry_run: bool) -> Result<()> {
        let unit = workspace::root().join(UNIT);
        let place = |file: &str| self.place.path(&format!("{FOLDER}/{file}.new"));
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
                print(&format!("  {command}\n"))?;
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
        let untouched = |cause: Error| FlashError::unfinished(&cause, UNTOUCHED);
        say("copying the node, the actor file and the service");
        for command in uploads(&program.display().to_string()) {
            self.run(&command).map_err(untouched)?;
        }
        say("computing the actor's signature there and here");
        let (there, here) = (self.run(&sign).map_err(untouched)?, actor.signature(cases)?);
        if u64::from_str_radix(there.trim(), 16) != Ok(here) {
            let found = there.trim().to_owned();
            let differs = FlashError::Signature { place: self.name.clone(), found, expected: here };
            return Err(untouched(differs.into()).into());
        }
        self.run(&switch).map_err(|cause| FlashError::unfinished(&cause, HALF_SWITCHED))?;
        say(&format!(
            "installed, signature {here:016x} on both; start it there with:\n  {}",
            self.shell("systemctl --user enable --now covey")
        ));
        Ok(())
    }

    /// What stands behind `ssh` when one types it.
    fn reach(&self) -> String {
        self.place.port("-p").into_iter().chain([self.place.for_ssh()]).collect::<Vec<_>>().join(" ")
    }

    /// The command that asks for the computer's processor.
    fn machine(&self) -> Cmd {
        self.shell("uname -m")
    }

    /// A shell command on the computer.
    fn shell(&self, command: &str) -> Cmd {
        Cmd::new(&self.ssh)
            .args(["-o", "BatchMode=yes"])
            .args(self.place.port("-p"))
            .args([self.place.for_ssh().as_str(), command])
    }

    /// The command that copies a file of this computer to `to`, as scp names it.
    fn copy(&self, file: &str, to: &str) -> Cmd {
        Cmd::new(&self.scp).args(["-q", "-o", "BatchMode=yes"]).args(self.place.port("-P")).args([file, to])
    }

    /// Runs a command of ssh or scp and returns its output.
    fn run(&self, command: &Cmd) -> Result<String> {
        command.read().map_err(|error| match error {
            // Exit status 255 is a failure of ssh itself, every other one comes from the command on the computer.
            Error::Failed { status, output, .. } if status.ends_with(": 255") => {
                FlashError::NoHost { host: self.reach(), output: output.trim().into() }.into()
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
        let host = Host::new("pilot@uav:2222", &unreachable.path(), "false").unwrap();
        let error = host.install(&sample(), 1, false).unwrap_err();
        assert!(error.to_string().contains("try `ssh -p 2222 pilot@uav true`"), "{error}");
        assert!(matches!(&error, Error::Flash(FlashError::NoHost { output, .. }) if output == "Connection refused"));
        let other = Script::new("echo riscv64");
        let error = Host::new("pilot@uav", &other.path(), "false").unwrap().install(&sample(), 1, false).unwrap_err();
        assert!(matches!(&error, Error::Flash(FlashError::WrongMachine { machine, .. }) if machine == "riscv64"));
    }

    #[test]
    fn a_dry_run_calls_nothing() {
        let script = Script::new(r#"echo "$@" >> "$0.log"; exit 1"#);
        Host::new("pilot@uav", &script.path(), &script.path()).unwrap().install(&sample(), 1, true).unwrap();
        assert_eq!(script.log(), "");
    }
}
