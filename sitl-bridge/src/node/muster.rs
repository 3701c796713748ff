//! Who else is in the air: UAVs that start together, or that share an id or an altitude layer.

use super::settings::Settings;
use crate::autopilot::Notice;
use crate::mission::Layers;
use std::collections::{BTreeMap, BTreeSet};

/// A UAV counts as in the air for so many steps after it was heard.
const HEARD_STEPS: i64 = 3;
/// One on the same layer hinders a start for so long after it was heard, ms.
const SHARED_MS: i64 = 60_000;

/// The UAVs that are heard on the swarm's link. On the ground they send nothing.
#[derive(Clone, Debug)]
pub(super) struct Muster {
    id: u16,
    layers: Layers,
    step_ms: u16,
    /// How many UAVs start together, this one included.
    size: u16,
    /// When each was last heard, ms of the node's clock.
    heard: BTreeMap<u16, i64>,
    /// All were in the air at once, or the operator does not wait for them.
    complete: bool,
    /// That it takes off after the others was told.
    late: bool,
    /// UAVs on this one's layer that were told of.
    told: BTreeSet<u16>,
    /// Messages of others with the own id up to the last start.
    collisions: u64,
}

impl Muster {
    pub fn new(settings: &Settings<'_>) -> Self {
        Self {
            id: settings.id,
            layers: settings.mission.layers,
            step_ms: settings.mission.scale.step_ms,
            size: settings.wait_for,
            heard: BTreeMap::new(),
            complete: false,
            late: false,
            told: BTreeSet::new(),
            collisions: 0,
        }
    }

    /// A new start: all have to be in the air again. `collisions` are the messages of others with the own id
    /// so far.
    pub const fn restart(&mut self, collisions: u64) {
        (self.complete, self.late, self.collisions) = (false, false, collisions);
    }

    /// The operator does not wait for the others.
    pub const fn waive(&mut self) {
        self.complete = true;
    }

    /// A message of UAV `id` was received at `now_ms` of the node's clock. Returns a warning when it is the
    /// first of one at the same height.
    pub fn hear(&mut self, id: u16, now_ms: i64) -> Option<Notice> {
        self.heard.insert(id, now_ms);
        (self.shares_layer(id) && self.told.insert(id)).then(|| Notice::warning(self.shared(id)))
    }

    /// Whether UAVs that start together with this one are still missing. Who is `airborne` counts itself.
    pub fn is_incomplete(&mut self, now_ms: i64, airborne: bool) -> bool {
        self.complete |= airborne && self.others(now_ms) + 1 >= usize::from(self.size);
        !self.complete
    }

    /// Takes note that this UAV takes off. Returns a warning when others fly already that wait for nobody.
    pub fn take_off(&mut self, now_ms: i64) -> Option<Notice> {
        let others = self.others(now_ms);
        let is_late = others >= usize::from(self.size) && !std::mem::replace(&mut self.late, true);
        is_late.then(|| {
            let uavs = if others == 1 { "a UAV flies".into() } else { format!("{others} UAVs fly") };
            Notice::warning(format!(
                "{uavs} already: on its way up this one crosses their layers (--wait-for lets UAVs start together)"
            ))
        })
    }

    /// How many other UAVs are in the air.
    fn others(&self, now_ms: i64) -> usize {
        let window_ms = HEARD_STEPS * i64::from(self.step_ms);
        self.heard.values().filter(|&&then| now_ms - then <= window_ms).count()
    }

    /// Why this UAV must not take off among the others, if so. `collisions` are the messages of others with the
    /// own id so far.
    pub fn refusal(&self, collisions: u64, now_ms: i64) -> Option<String> {
        if collisions > self.collisions {
            return Some(format!("another UAV in the air has the id {} too: give each its own --id", self.id));
        }
        let near = |(&id, &then): (&u16, &i64)| self.shares_layer(id) && now_ms - then <= SHARED_MS;
        let (&id, _) = self.heard.iter().find(|&heard| near(heard))?;
        Some(self.shared(id))
    }

    fn shares_layer(&self, id: u16) -> bool {
        id != self.id && self.layers.are_one(id, self.id)
    }

    fn shared(&self, id: u16) -> String {
        format!(
            "UAV {id} flies at the height of UAV {}: the mission has {} altitude layers (altitude.layers) for more ids",
            self.id, self.layers.count
        )
    }
}
