//! What is known of whose the vehicle is.

/// What heartbeats and commands tell of who has the vehicle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Control {
    /// `custom_mode` and arming in the last heartbeat.
    pub last: Option<(u32, bool)>,
    /// Its mode follows setpoints, or is one that the node's commands led to.
    pub ours: bool,
    /// A takeoff was commanded here, and neither GUIDED nor another's mode was heard since.
    pub climbs: bool,
    /// Arming was accepted here, and it has not been disarmed since.
    pub armed_here: bool,
    /// `custom_mode` of the return or landing that was last commanded, and of the one before where that was
    /// obeyed.
    pub ordered: [Option<u32>; 2],
    /// GUIDED was heard since the bring-up changed to it.
    pub was_guided: bool,
    /// PX4's AUTO.TAKEOFF was heard since the last start.
    pub took_off: bool,
    /// When the last heartbeat came, ms of the node's clock.
    pub heard_ms: i64,
    /// A setpoint was sent since then.
    pub streams: bool,
}

impl Control {
    /// Nothing was heard and nothing commanded.
    pub const fn new() -> Self {
        Self {
            last: None,
            ours: false,
            climbs: false,
            armed_here: false,
            ordered: [None; 2],
            was_guided: false,
            took_off: false,
            heard_ms: 0,
            streams: false,
        }
    }

    /// Another start: nothing that was commanded before counts.
    pub const fn restart(&mut self) {
        (self.climbs, self.was_guided, self.took_off) = (false, false, false);
    }

    /// Somebody else has it.
    pub const fn lose(&mut self) {
        (self.ours, self.climbs, self.ordered) = (false, false, [None; 2]);
    }

    /// A takeoff is commanded.
    pub const fn climb(&mut self) {
        self.climbs = true;
    }

    /// A return or a landing is commanded.
    pub fn order(&mut self, custom_mode: u32) {
        let before = self.ordered[0].filter(|_| self.has_obeyed());
        self.ordered = [Some(custom_mode), before];
    }

    /// Arming was accepted.
    pub const fn arm(&mut self) {
        self.armed_here = true;
    }

    /// Whether the vehicle is armed and in a mode that the node may order it out of.
    pub fn takes_orders(&self) -> bool {
        self.ours && self.last.is_some_and(|(_, armed)| armed)
    }

    /// Whether this is the `custom_mode` in the last heartbeat.
    pub fn is_in(&self, custom_mode: u32) -> bool {
        self.last.is_some_and(|(last, _)| last == custom_mode)
    }

    /// Whether it is in the mode that was last ordered.
    pub fn has_obeyed(&self) -> bool {
        self.ordered[0].is_some_and(|ordered| self.is_in(ordered))
    }

    /// Whether an order led to the mode that it is in.
    pub fn is_in_ordered_mode(&self) -> bool {
        self.ordered.iter().flatten().any(|&ordered| self.is_in(ordered))
    }
}
