//! Flashing boards that have a debug probe, by the program probe-rs.

use super::actor_file::ActorFile;
use super::error::FlashError;
use super::progress::say;
use crate::command::Cmd;
use crate::error::{Error, Result};
use crate::output::print;
use crate::setup::{self, Item};
use crate::targets::artefacts::{Board, Image};

/// The name that probe-rs uses for the chip on NUCLEO-H743ZI and -H743ZI2.
const CHIP: &str = "STM32H743ZITx";
/// Address of the register with the chip's device id (DBGMCU_IDC; RM0433, section 60.5.8).
const ID_ADDRESS: &str = "0x5c001000";
/// The bits of that register that are the device id.
const ID_MASK: u32 = 0xfff;
/// The device id of STM32H743 and STM32H753.
const ID: u32 = 0x450;
/// Flash address of the actor file, as in `firmware-core/image/memory/stm32h743.x`.
const ACTOR_ADDRESS: &str = "0x080e0000";

/// The variable that moves it, in the build of the program as well.
const ADDRESS_VARIABLE: &str = "COVEY_ACTOR_ADDRESS";

/// The program probe-rs.
pub struct Probe {
    program: String,
    /// Which one, where several are connected.
    chosen: Option<String>,
}

impl Probe {
    /// Uses the probe-rs of this name or path, and this probe (VID:PID:SERIAL) or the only one.
    pub fn new(program: &str, chosen: Option<String>) -> Self {
        Self { program: program.into(), chosen }
    }

    /// Builds the flight program and writes it (unless `actor_only`) and the actor file to the board's flash. With
    /// `dry_run` it only prints the commands.
    ///
    /// # Errors
    /// There is no probe that can be used, the chip is another one, writing failed, or the build failed.
    pub fn flash(&self, actor: &ActorFile, actor_only: bool, dry_run: bool) -> Result<()> {
        let address = actor_address(std::env::var(ADDRESS_VARIABLE).ok().as_deref())?;
        let write_actor = self
            .probe_rs(&["download", "--chip", CHIP, "--verify", "--binary-format", "bin"])
            .args(["--base-address", &address])
            .arg(&actor.path);
        let reset = self.probe_rs(&["reset", "--chip", CHIP]);
        if dry_run {
            say("would run, after building the program for STM32H743:");
            let program = self.probe_rs(&["download", "--chip", CHIP, "--verify", "flight"]);
            let program = (!actor_only).then_some(program);
            for command in [self.list(), self.read_id()].into_iter().chain(program).chain([write_actor, reset]) {
                print(&format!("  {command}\n"))?;
            }
            return Ok(());
        }
        self.find_board()?;
        if !actor_only {
            setup::install(&[Item::RustTargets])?;
            say("building the program");
            let image = Image::build(Board::Stm32h743)?;
            say("writing the program");
            self.run(&self.probe_rs(&["download", "--chip", CHIP, "--verify"]).arg(&image.flight))?;
        }
        say("writing the actor file");
        let state = if actor_only {
            "the actor file may be written in part; the program is as it was: run the same command again"
        } else {
            "the program is written and verified, the actor file may not be: the same command with --actor-only writes it"
        };
        self.run(&write_actor).map_err(|cause| FlashError::unfinished(&cause, state))?;
        let state = "everything is written and verified: press the board's reset button";
        self.run(&reset).map_err(|cause| FlashError::unfinished(&cause, state))?;
        say("written and verified; the board has restarted and tests its actor");
        Ok(())
    }

    /// Checks that a board with the right chip is connected.
    fn find_board(&self) -> Result<()> {
        say("looking for the board");
        let list = self.run(&self.list())?;
        match complaint(&list) {
            Some(error) => Err(error.into()),
            None if self.chosen.is_none() && probes(&list).count() > 1 => {
                let list = probes(&list).collect::<Vec<_>>().join("\n");
                Err(FlashError::ManyProbes { list }.into())
            }
            None => check_id(&self.run(&self.read_id())?).map_err(Error::from),
        }
    }

    /// The command that lists the connected probes.
    fn list(&self) -> Cmd {
        Cmd::new(&self.program).arg("list")
    }

    /// The command that reads the register with the device id.
    fn read_id(&self) -> Cmd {
        self.probe_rs(&["read", "--chip", CHIP, "b32", ID_ADDRESS, "1"])
    }

    fn probe_rs(&self, args: &[&str]) -> Cmd {
        let probe = self.chosen.iter().flat_map(|chosen| ["--probe", chosen]);
        Cmd::new(&self.program).args(&args[..1]).args(probe).args(&args[1..])
    }

    /// Runs a command of probe-rs and returns its output.
    fn run(&self, command: &Cmd) -> Result<String> {
        command.read_all().map_err(|error| match error {
            Error::Start { .. } => FlashError::NoProbeRs.into(),
            Error::Failed { command, output, .. } => {
                complaint(&output).unwrap_or(FlashError::Probe { command, output: output.trim().into() }).into()
            }
            other => other,
        })
    }
}

/// The lines of `probe-rs list` that name a probe: they begin with its number in brackets.
fn probes(list: &str) -> impl Iterator<Item = &str> {
    let named = |line: &&str| line.strip_prefix('[').is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()));
    list.lines().map(str::trim).filter(named)
}

/// Where the actor file is written: where the program expects it, which was built with the same variable.
fn actor_address(variable: Option<&str>) -> std::result::Result<String, FlashError> {
    let Some(text) = variable else { return Ok(ACTOR_ADDRESS.to_owned()) };
    let digits = text.strip_prefix("0x").filter(|digits| u32::from_str_radix(digits, 16).is_ok());
    digits.map(|_| text.to_owned()).ok_or_else(|| FlashError::BadAddress(text.into()))
}

/// The error that the output of probe-rs stands for, if it says that there is no probe that can be used.
fn complaint(output: &str) -> Option<FlashError> {
    let words = output.to_lowercase();
    let says = |phrases: &[&str]| phrases.iter().any(|phrase| words.contains(phrase));
    if says(&["permission denied", "insufficient permission", "access denied"]) {
        Some(FlashError::NoPermission)
    } else if says(&["no debug probes were found", "no connected probes were found", "probe was not found"]) {
        Some(FlashError::NoProbe)
    } else {
        None
    }
}

/// Checks the device id in the output of `probe-rs read`.
fn check_id(output: &str) -> std::result::Result<(), FlashError> {
    let words = output.split_whitespace().map(|word| word.trim_start_matches("0x"));
    let id = words.filter(|word| word.len() == 8).find_map(|word| u32::from_str_radix(word, 16).ok());
    match id.map(|id| id & ID_MASK) {
        Some(ID) => Ok(()),
        Some(found) => Err(FlashError::WrongChip { found, expected: ID }),
        None => Err(FlashError::Probe { command: "probe-rs read".into(), output: output.trim().into() }),
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_support::{Script, sample};
    use super::*;

    /// A stand-in for probe-rs that runs the given commands for `list` and `read`, and logs its arguments.
    fn fake(list: &str, read: &str) -> Script {
        Script::new(&format!(
            r#"echo "$@" >> "$0.log"
case $1 in
list) {list} ;;
read) {read} ;;
esac"#
        ))
    }

    fn flash(script: &Script) -> Result<()> {
        Probe::new(&script.path(), None).flash(&sample(), true, false)
    }

    #[test]
    fn the_actor_is_written_to_its_address_and_the_board_reset() {
        let script = fake("echo '[0]: STLink V3'", "echo 10036450");
        flash(&script).unwrap();
        let log = script.log();
        let calls: Vec<_> = log.lines().map(|line| line.split(' ').next().unwrap()).collect();
        assert_eq!(calls, ["list", "read", "download", "reset"]);
        assert!(log.contains("--base-address 0x080e0000"), "{log}");
    }

    #[test]
    fn each_trouble_has_its_own_message() {
        let no_probe = fake("echo 'No debug probes were found.'", ":");
        assert!(matches!(flash(&no_probe), Err(Error::Flash(FlashError::NoProbe))));
        let no_permission =
            fake("echo '[0]: STLink V3'", "echo 'Caused by: 1: Permission denied (os error 13)' >&2; exit 1");
        assert!(matches!(flash(&no_permission), Err(Error::Flash(FlashError::NoPermission))));
        let listed_only = fake("echo '[0]: STLink V3 (insufficient permissions)'", ":");
        assert!(matches!(flash(&listed_only), Err(Error::Flash(FlashError::NoPermission))));
        let wrong_chip = fake("echo '[0]: STLink V3'", "echo 20006483");
        let error = flash(&wrong_chip).unwrap_err();
        assert!(matches!(error, Error::Flash(FlashError::WrongChip { found: 0x483, .. })));
        assert!(error.to_string().contains("0x483"));
        let unplugged = fake("echo '[0]: STLink V3'", "echo 'Target device did not respond' >&2; exit 1");
        assert!(matches!(flash(&unplugged), Err(Error::Flash(FlashError::Probe { .. }))));
        let missing = Probe::new("/nowhere/probe-rs", None).flash(&sample(), true, false);
        assert!(matches!(missing, Err(Error::Flash(FlashError::NoProbeRs))));
    }

    #[test]
    fn one_of_several_probes_is_chosen() {
        let script = fake("echo '[0]: STLink V3 -- 0483:374e:A'; echo '[1]: J-Link -- 1366:0101:B'", "echo 10036450");
        let error = flash(&script).unwrap_err().to_string();
        assert!(error.contains("--probe") && error.contains("0483:374e:A") && error.contains("1366:0101:B"), "{error}");
        Probe::new(&script.path(), Some("1366:0101:B".into())).flash(&sample(), true, false).unwrap();
        let log = script.log();
        for call in ["read", "download", "reset"] {
            assert!(log.contains(&format!("{call} --probe 1366:0101:B --chip")), "{log}");
        }
    }

    #[test]
    fn what_was_written_before_a_failure_is_told() {
        let script =
            Script::new("case $1 in list) echo '[0]: A';; read) echo 10036450;; *) echo broken >&2; exit 1;; esac");
        let error = flash(&script).unwrap_err().to_string();
        assert!(error.contains("broken") && error.contains("the program is as it was"), "{error}");
    }

    #[test]
    fn the_actor_is_written_where_the_program_expects_it() {
        assert_eq!(actor_address(None).unwrap(), ACTOR_ADDRESS);
        assert_eq!(actor_address(Some("0x08040000")).unwrap(), "0x08040000");
        for wrong in ["", "0x", "08040000", "0x108040000", "sector 2"] {
            assert!(actor_address(Some(wrong)).unwrap_err().to_string().contains("0x08040000"), "{wrong}");
        }
    }

    #[test]
    fn a_dry_run_calls_nothing() {
        let script = fake("exit 1", "exit 1");
        Probe::new(&script.path(), None).flash(&sample(), false, true).unwrap();
        assert_eq!(script.log(), "");
    }
}
