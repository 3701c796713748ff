//! Reading a mission from a file, and filling in what its format has no room for.

use super::check::{Checked, check};
use super::definition::Mission;
use super::drawing::{Drawing, Extent, METRES_PER_DEGREE, turned_back};
use super::error::MissionError;
use super::fault::Fault;
use super::file::{Decide, MissionFile, Origin, line_of};
use super::format::Format;
use super::formats::detect::{Content, FORMATS};
use super::formats::{csv, geojson, kml, plan, waypoints};
use super::given::Given;
use super::loaded::{Loaded, Remark};
use super::text;
use firmware_core::actor::Mode;
use std::path::{Path, PathBuf};

/// Room around PoIs on a map that is laid around them, u.
const ROOM_U: f64 = 10.0;

/// A file that was read and not yet checked: what it lacks can be [given](Draft::fill).
#[derive(Clone, Debug)]
pub struct Draft {
    path: PathBuf,
    /// Of TOML, to find lines.
    text: String,
    format: Format,
    by_name: Option<Format>,
    has_settings: bool,
    settings: MissionFile,
    drawing: Drawing,
    notes: Vec<String>,
    simplify: bool,
}

impl Mission {
    /// Reads a mission file of any format that says where its map lies. What else is to be said of it is
    /// in [`Loaded`].
    ///
    /// # Errors
    /// See [`MissionError`].
    pub fn read(path: &Path) -> Result<Self, MissionError> {
        Loaded::read(path).map(|loaded| loaded.mission)
    }
}

impl Loaded {
    /// Reads a mission file.
    ///
    /// # Errors
    /// See [`MissionError`].
    pub fn read(path: &Path) -> Result<Self, MissionError> {
        Draft::read(path)?.finish()
    }

    /// The same of bytes; `path` is for the format and for error messages.
    ///
    /// # Errors
    /// See [`MissionError`].
    pub fn from_bytes(bytes: &[u8], path: &Path) -> Result<Self, MissionError> {
        Draft::from_bytes(bytes, path)?.finish()
    }
}

impl Draft {
    /// Reads a file.
    ///
    /// # Errors
    /// It cannot be read, or breaks the rules of its format.
    pub fn read(path: &Path) -> Result<Self, MissionError> {
        let bytes = std::fs::read(path).map_err(|source| MissionError::Read { path: path.to_owned(), source })?;
        Self::from_bytes(&bytes, path)
    }

    /// The same of bytes; `path` is for the format and for error messages.
    ///
    /// # Errors
    /// The bytes break the rules of their format.
    pub fn from_bytes(bytes: &[u8], path: &Path) -> Result<Self, MissionError> {
        let path = path.to_owned();
        let text = match text::decode(bytes) {
            Ok(text) => text,
            Err(problem) => return Err(MissionError::Text { path, problem }),
        };
        let named = Format::of_name(&path);
        let unknown = |path, what: &str| Err(MissionError::Format { path, message: format!("{what}; {FORMATS}") });
        let format = match (Format::of_content(text), named.first()) {
            (Content::Is(format), _) => format,
            (Content::Perhaps(_) | Content::Unknown, Some(&format)) => format,
            (Content::Perhaps(format), None) => format,
            (Content::Foreign(what), _) => return unknown(path, what),
            (Content::Unknown, None) => {
                return unknown(path, "neither its content nor its name tells the format");
            }
        };
        let by_name = named.first().copied().filter(|_| !named.contains(&format));
        let mut draft = Self {
            path,
            text: String::new(),
            format,
            by_name,
            has_settings: false,
            settings: MissionFile::default(),
            drawing: Drawing::default(),
            notes: Vec::new(),
            simplify: false,
        };
        draft.take(text).map_err(|fault| draft.error(fault))?;
        draft.drawing.note_turns();
        if let Some(name) = by_name {
            draft.notes.push(format!("its content is {format}, though its name says {name}; read by its content"));
        }
        Ok(draft)
    }

    fn take(&mut self, text: &str) -> Result<(), Fault> {
        self.drawing = match self.format {
            Format::Toml => {
                self.text = text.to_owned();
                self.settings = MissionFile::from_toml(text)?;
                self.has_settings = true;
                Drawing::default()
            }
            Format::GeoJson => {
                let geojson::Read { covey, drawing } = geojson::read(text)?;
                self.has_settings = covey.is_some();
                self.settings = covey.unwrap_or_default();
                drawing
            }
            Format::Kml => kml::read(text)?,
            Format::Csv => csv::read(text)?,
            Format::Plan => plan::read(text)?,
            Format::Waypoints => waypoints::read(text)?,
        };
        Ok(())
    }

    /// Puts what a user gives over what the file says, and lays the map around what is drawn where nobody says where it
    /// lies. An altitude is never guessed.
    pub fn fill(&mut self, given: &Given) {
        let file = &mut self.settings;
        let put = |field: &mut f64, value: Option<f64>| *field = value.unwrap_or(*field);
        put(&mut file.scale_m, given.scale_m);
        put(&mut file.altitude.base_m, given.base_m);
        put(&mut file.altitude.spacing_m, given.spacing_m);
        file.altitude.layers = given.layers.unwrap_or(file.altitude.layers);
        file.step_ms = given.step_ms.unwrap_or(file.step_ms);
        file.policy_seed = given.policy_seed.unwrap_or(file.policy_seed);
        file.epoch_unix_ms = given.epoch_unix_ms.unwrap_or(file.epoch_unix_ms);
        file.fence.margin_u = given.margin_u.or(file.fence.margin_u);
        if let Some(mode) = given.mode {
            file.decide = if mode == Mode::Argmax { Decide::Argmax } else { Decide::Sample };
        }
        self.simplify = given.simplify_fence;
        let laid = self.laid_around(given.side_u);
        let file = &mut self.settings;
        let known = file.origin;
        let lat = given.lat.or(known.map(|o| o.lat)).or(laid.map(|(origin, _)| origin[0]));
        let lon = given.lon.or(known.map(|o| o.lon)).or(laid.map(|(origin, _)| origin[1]));
        let home = self.drawing.home_alt_m.filter(|_| given.alt_m.is_none() && known.is_none());
        let alt_m = given.alt_m.or(known.map(|o| o.alt_m)).or(home);
        if let (Some(lat), Some(lon), Some(alt_m)) = (lat, lon, alt_m) {
            file.origin = Some(Origin { lat, lon, alt_m });
            if let Some(alt) = home {
                self.notes.push(format!("the origin's altitude is the home position's, {alt} m above sea level"));
            }
            let is_laid = known.is_none() && given.lat.is_none() && given.lon.is_none();
            if let Some((_, side_u)) = laid.filter(|_| is_laid) {
                if !self.has_settings && given.side_u.is_none() {
                    file.side_u = side_u;
                }
                let side_u = file.side_u;
                self.notes.push(format!(
                    "the map is laid around what is drawn: origin at latitude {lat}, longitude {lon}, side {side_u} u ({} m)",
                    side_u * file.scale_m
                ));
            }
        }
        file.side_u = given.side_u.unwrap_or(file.side_u);
    }

    /// South-west corner and side (u) of a map with what is drawn in its middle.
    fn laid_around(&self, side_u: Option<f64>) -> Option<([f64; 2], f64)> {
        let Extent { lat, lon, north, east } = self.drawing.extent()?;
        let scale_m = self.settings.scale_m;
        let east_m = METRES_PER_DEGREE * lat.to_radians().cos().max(0.01);
        let [high, wide] = [north * METRES_PER_DEGREE, east * east_m];
        let room = if self.drawing.fence.is_some() { 0.0 } else { 2.0 * ROOM_U };
        // A unit more for the rounding of the corner.
        let side = (high.max(wide) / scale_m + room + 1.0).ceil().max(f64::from(covey_env::Scenario::MIN_SIDE_U));
        let side = side_u.unwrap_or(side);
        let corner = |least: f64, extent_m: f64, per_degree: f64| {
            let corner = least - (side * scale_m - extent_m) / 2.0 / per_degree;
            (corner * 1e6).round() / 1e6
        };
        let lon = turned_back(corner(lon, wide, east_m));
        Some(([corner(lat, high, METRES_PER_DEGREE), lon], side))
    }

    /// What was read otherwise than it stands there, so far.
    pub fn notes(&self) -> impl Iterator<Item = &str> {
        self.drawing.notes.iter().chain(&self.notes).map(String::as_str)
    }

    /// Checks it all.
    ///
    /// # Errors
    /// Something is missing, or cannot be flown.
    pub fn finish(self) -> Result<Loaded, MissionError> {
        let origin = match self.settings.origin {
            Some(origin) => origin,
            // What has no PoI is refused for that.
            None if self.has_pois() => return Err(self.without_origin()),
            None => Origin::default(),
        };
        match check(&self.settings, origin, &self.drawing, self.format, self.simplify) {
            Ok(Checked { mission, notes, warnings }) => {
                let remark = |warning| move |text| Remark { warning, text };
                let notes = self.drawing.notes.into_iter().chain(self.notes).chain(notes).map(remark(false));
                let remarks = notes.chain(warnings.into_iter().map(remark(true))).collect();
                Ok(Loaded { mission, format: self.format, remarks })
            }
            Err(fault) => Err(self.error(fault)),
        }
    }

    fn has_pois(&self) -> bool {
        !(self.settings.pois_u.is_empty() && self.settings.pois_lat_lon.is_empty() && self.drawing.pois.is_empty())
    }

    fn error(&self, fault: Fault) -> MissionError {
        let (path, format, by_name) = (self.path.clone(), self.format, self.by_name);
        let Fault { field, problem } = fault;
        // With the files' names the command can be typed.
        let problem = problem.replace("convert IN OUT", &self.convert());
        if field.is_empty() {
            return MissionError::Syntax { path, format, by_name, message: problem };
        }
        let line = if format == Format::Toml { line_of(&self.text, &field) } else { None };
        MissionError::Value { path, format, by_name, line, field, problem }
    }

    /// The command that makes a mission of this file.
    fn convert(&self) -> String {
        let is_toml = self.path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml"));
        let output = self.path.with_extension(if is_toml { "new.toml" } else { "toml" });
        format!("convert {} {}", self.path.display(), output.display())
    }

    /// Shows what to add.
    fn without_origin(&self) -> MissionError {
        let ([lat, lon], side_u) = self.laid_around(None).unwrap_or(([47.397_742, 8.545_594], 200.0));
        let alt = if self.drawing.home_alt_m.is_some() { "convert" } else { "convert --alt-m METRES" };
        let convert = format!("sitl-bridge mission {}", self.convert().replacen("convert", alt, 1));
        let problem = match self.format {
            Format::Toml => format!(
                "missing field `origin`, the map's south-west corner. Add\n  origin = {{ lat = {lat}, lon = {lon}, alt_m = \
                 0.0 }}\nwith your place, and the ground's altitude above sea level for alt_m"
            ),
            Format::GeoJson if self.has_settings => format!(
                "missing field `covey.origin`, the map's south-west corner. Put into `covey`\n  \"origin\": {{\"lat\": {lat}, \
                 \"lon\": {lon}, \"alt_m\": 0}}\nwith the ground's altitude above sea level for alt_m"
            ),
            Format::GeoJson => format!(
                "it has no member `covey`, which says where the map lies. Add, beside \"type\",\n  \"covey\": {{\"origin\": {{\"lat\": \
                 {lat}, \"lon\": {lon}, \"alt_m\": 0}},\n    \"side_u\": {side_u}}},\nwith the ground's altitude above sea level \
                 for alt_m. Or make a mission of it:\n  {convert}"
            ),
            format => format!(
                "{format} has no room for where the map lies and how high UAVs fly. Make a mission of it:\n  {convert}\n(METRES: \
                 the ground's altitude above sea level; `sitl-bridge mission convert --help` tells what else can be given)"
            ),
        };
        MissionError::Value {
            path: self.path.clone(),
            format: self.format,
            by_name: self.by_name,
            line: None,
            field: "origin".into(),
            problem,
        }
    }
}
