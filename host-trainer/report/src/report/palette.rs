//! The colours of series.

/// Colours in the style sheet.
const COLOURS: usize = 8;

/// Names of series in order of first appearance: their colours.
#[derive(Default)]
pub(super) struct Palette(Vec<String>);

impl Palette {
    /// Number of the name's colour, from 0; beyond [`COLOURS`] dashes tell them apart.
    pub fn index(&mut self, name: &str) -> usize {
        self.0.iter().position(|n| n == name).unwrap_or_else(|| {
            self.0.push(name.into());
            self.0.len() - 1
        })
    }
}

/// Classes that give a series its colour and dashes.
pub(super) fn classes(index: usize) -> String {
    let dashed = if index >= COLOURS { " dashed" } else { "" };
    format!("s{}{dashed}", index % COLOURS + 1)
}
