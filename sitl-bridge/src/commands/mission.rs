//! `mission`: missions written, checked and made of other files.

use super::output::print;
use crate::mission::{Draft, Given, Loaded, Mission, Origin};
use crate::outlet::say;
use covey_env::{Scenario, World};
use covey_report::atomic;
use firmware_core::actor::Mode;
use miette::{IntoDiagnostic as _, Result, WrapErr as _, miette};
use std::path::{Path, PathBuf};

/// Arguments of `mission`.
#[derive(clap::Args)]
#[command(args_conflicts_with_subcommands = true)]
pub struct MissionCommand {
    #[command(subcommand)]
    action: Option<Action>,
    #[command(flatten)]
    world: WriteWorld,
}

#[derive(clap::Subcommand)]
enum Action {
    /// Read a mission and say what is in it and what may go wrong.
    Check(CheckMission),
    /// Make a mission in TOML of GeoJSON, KML, CSV, a QGroundControl plan or a waypoint list.
    Convert(Box<Convert>),
}

/// A world of the scenario as a mission, on the standard output.
#[derive(clap::Args)]
struct WriteWorld {
    /// Index of the world.
    #[arg(long, default_value_t = 0)]
    world: u64,
    /// Seed of the worlds.
    #[arg(long, default_value_t = 777)]
    seed: u64,
    /// Number of PoIs.
    #[arg(long, default_value_t = 120)]
    pois: usize,
    /// Latitude of the map's south-west corner, degrees.
    #[arg(long, default_value_t = Origin::default().lat, allow_hyphen_values = true)]
    lat: f64,
    /// Longitude of the map's south-west corner, degrees.
    #[arg(long, default_value_t = Origin::default().lon, allow_hyphen_values = true)]
    lon: f64,
    /// Altitude of the map above mean sea level, m.
    #[arg(long, default_value_t = Origin::default().alt_m, allow_hyphen_values = true)]
    alt: f64,
}

#[derive(clap::Args)]
struct CheckMission {
    /// The file: TOML, GeoJSON, KML, CSV, .plan or .waypoints.
    file: PathBuf,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

#[derive(clap::Args)]
struct Convert {
    /// The file: TOML, GeoJSON, KML, CSV, .plan or .waypoints.
    input: PathBuf,
    /// Where the mission goes; `-` prints it.
    output: PathBuf,
    /// Write over a file that is there.
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    given: GivenArgs,
}

/// What the file lacks or is to have instead.
#[derive(clap::Args)]
struct GivenArgs {
    /// Latitude of the map's south-west corner, degrees; laid around what is drawn when neither file nor this says.
    #[arg(long, allow_hyphen_values = true)]
    lat: Option<f64>,
    /// Longitude of the map's south-west corner, degrees.
    #[arg(long, allow_hyphen_values = true)]
    lon: Option<f64>,
    /// Altitude of the ground there above mean sea level, m: altitudes of UAVs count from it, and it is never guessed.
    #[arg(long, visible_alias = "alt", value_name = "METRES", allow_hyphen_values = true)]
    alt_m: Option<f64>,
    /// Metres in a map unit.
    #[arg(long)]
    scale_m: Option<f64>,
    /// Side of the map, u.
    #[arg(long)]
    side_u: Option<f64>,
    /// Length of a step, ms.
    #[arg(long)]
    step_ms: Option<u16>,
    /// Seed of actions and tie-breakers.
    #[arg(long)]
    policy_seed: Option<u64>,
    /// How actions are drawn.
    #[arg(long, value_parser = ["sample", "argmax"])]
    decide: Option<String>,
    /// When step 0 begins, Unix time in ms.
    #[arg(long, allow_hyphen_values = true)]
    epoch_unix_ms: Option<i64>,
    /// Altitude of the lowest layer above the origin, m.
    #[arg(long)]
    base_m: Option<f64>,
    /// Between two layers, m.
    #[arg(long)]
    spacing_m: Option<f64>,
    /// Number of altitude layers.
    #[arg(long)]
    layers: Option<u16>,
    /// How far outside the map the fence stands where none is drawn, u.
    #[arg(long)]
    margin_u: Option<f64>,
    /// Make a fence of more than 16 corners simpler; it becomes smaller, never larger.
    #[arg(long)]
    simplify_fence: bool,
}

impl GivenArgs {
    fn given(&self) -> Given {
        Given {
            lat: self.lat,
            lon: self.lon,
            alt_m: self.alt_m,
            scale_m: self.scale_m,
            side_u: self.side_u,
            step_ms: self.step_ms,
            policy_seed: self.policy_seed,
            mode: self.decide.as_deref().map(|d| if d == "argmax" { Mode::Argmax } else { Mode::Sample }),
            epoch_unix_ms: self.epoch_unix_ms,
            base_m: self.base_m,
            spacing_m: self.spacing_m,
            layers: self.layers,
            margin_u: self.margin_u,
            simplify_fence: self.simplify_fence,
        }
    }
}

impl MissionCommand {
    /// Carries it out.
    ///
    /// # Errors
    /// A file cannot be read, flown or written; no world or no map can be made of the numbers.
    pub fn run(self) -> Result<()> {
        match self.action {
            None => self.world.run(),
            Some(Action::Check(args)) => args.run(),
            Some(Action::Convert(args)) => args.run(),
        }
    }
}

impl WriteWorld {
    fn run(self) -> Result<()> {
        let scenario = Scenario { pois: self.pois, ..Scenario::default() };
        let mut world = World::new(&scenario).into_diagnostic()?;
        world.reset(self.seed, self.world);
        let origin = Origin { lat: self.lat, lon: self.lon, alt_m: self.alt };
        let mission = Mission::of_world(&world, origin).into_diagnostic().wrap_err("no map can be laid there")?;
        print(&mission.to_toml(&format!("World {} of seed {}", self.world, self.seed)))
    }
}

impl CheckMission {
    fn run(self) -> Result<()> {
        let loaded = finish(&self.file, Draft::read(&self.file).into_diagnostic()?)?;
        let Loaded { mission, format, remarks } = &loaded;
        let (lat, lon) = mission.plane.origin_degrees();
        let alt_m = f64::from(mission.plane.alt_mm) / 1000.0;
        let hash = hexadecimal(&mission.hash());
        if self.json {
            let said = |warning| remarks.iter().filter(|r| r.warning == warning).map(|r| &r.text).collect::<Vec<_>>();
            let object = serde_json::json!({
                "file": self.file.to_string_lossy(), "format": format.to_string(), "hash": hash,
                "origin": {"lat": lat, "lon": lon, "alt_m": alt_m}, "side_u": mission.side_u,
                "scale_m": mission.scale.unit_m, "step_ms": mission.scale.step_ms, "pois": mission.pois.len(),
                "fence_corners": mission.fence.len(), "epoch_unix_ms": mission.epoch_unix_ms,
                "notes": said(false), "warnings": said(true),
            });
            return print(&format!("{}\n", serde_json::to_string_pretty(&object).into_diagnostic()?));
        }
        let remarks_told: String = remarks.iter().map(|remark| format!("{remark}\n")).collect();
        let end = if remarks.iter().any(|remark| remark.warning) { "" } else { "no warnings\n" };
        print(&format!("{}hash       {hash}\n{remarks_told}{end}", describe(&self.file, &loaded)))
    }
}

impl Convert {
    fn run(self) -> Result<()> {
        let mut draft = Draft::read(&self.input).into_diagnostic()?;
        draft.fill(&self.given.given());
        let loaded = finish(&self.input, draft)?;
        tell(&self.input, &loaded);
        let name = self.input.file_name().unwrap_or_default().to_string_lossy();
        let title = format!("Made of {}", name.chars().filter(|c| !c.is_control()).collect::<String>());
        let toml = loaded.mission.to_toml(&title);
        if self.output.as_os_str() == "-" {
            return print(&toml);
        }
        // Also where the output is the input.
        if !self.force && self.output.exists() {
            return Err(miette!(
                "{} exists: name another file, or give --force to write over it",
                self.output.display()
            ));
        }
        if self.output.extension().is_some_and(|e| !e.eq_ignore_ascii_case("toml")) {
            say(&format!("note: {} is written as TOML whatever its name says", self.output.display()));
        }
        let written = || format!("cannot write {}", self.output.display());
        atomic::write(&self.output, toml.as_bytes()).into_diagnostic().wrap_err_with(written)?;
        say(describe(&self.output, &loaded).trim_end());
        Ok(())
    }
}

/// Checks a mission; what was read of one that is refused is said too.
fn finish(path: &Path, draft: Draft) -> Result<Loaded> {
    let notes: Vec<String> = draft.notes().map(str::to_owned).collect();
    draft.finish().into_diagnostic().inspect_err(|_| {
        notes.iter().for_each(|note| say(&format!("note: mission {}: {note}", path.display())));
    })
}

/// What was read, for people.
fn describe(path: &Path, loaded: &Loaded) -> String {
    let mission = &loaded.mission;
    let (lat, lon) = mission.plane.origin_degrees();
    let side_m = mission.side_u * mission.scale.unit_m;
    let layers = mission.layers;
    let highest_m = layers.base_m + f64::from(layers.count - 1) * layers.spacing_m;
    format!(
        "{}: {} from {}
map        {} u ({side_m} m) a side; south-west corner at latitude {lat}, longitude {lon}, {} m above sea level
fence      {} corners
altitude   {} m to {highest_m} m above the origin, {} layers
steps      {} ms; step 0 at Unix time {} ms
",
        path.display(),
        if mission.pois.len() == 1 { "1 PoI".to_owned() } else { format!("{} PoIs", mission.pois.len()) },
        loaded.format,
        mission.side_u,
        f64::from(mission.plane.alt_mm) / 1000.0,
        mission.fence.len(),
        layers.base_m,
        layers.count,
        mission.scale.step_ms,
        mission.epoch_unix_ms,
    )
}

/// Says the remarks on a mission on the standard error.
pub(super) fn tell(path: &Path, loaded: &Loaded) {
    for remark in &loaded.remarks {
        let kind = if remark.warning { "warning" } else { "note" };
        say(&format!("{kind}: mission {}: {}", path.display(), remark.text));
    }
}

/// Reads a mission for a flight, and says its remarks.
///
/// # Errors
/// See [`crate::mission::MissionError`].
pub(super) fn read(path: &Path) -> Result<Mission> {
    let loaded = Loaded::read(path).into_diagnostic()?;
    tell(path, &loaded);
    Ok(loaded.mission)
}

pub(super) fn hexadecimal(bytes: &[u8]) -> String {
    use std::fmt::Write as _;
    bytes.iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}
