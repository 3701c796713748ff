//! The table of causes in `docs/safety.md` is the one the code goes by.

use firmware_core::gate::{Clock, Limits, Reason};

const DOCUMENT: &str = include_str!("../../../docs/safety.md");

/// Cells of the rows between two marks.
fn rows(mark: &str) -> Vec<Vec<String>> {
    let text = DOCUMENT.split_once(&format!("<!-- {mark} -->")).expect(mark).1;
    let text = text.split_once("<!-- end -->").expect("end of the table").0;
    let rows = text.lines().filter(|line| line.starts_with("| `"));
    rows.map(|row| row.trim_matches('|').split('|').map(|cell| cell.trim().replace('`', "")).collect()).collect()
}

#[test]
fn causes_actions_and_times_are_as_documented() {
    let limits = Limits::default();
    let documented: Vec<Vec<String>> = rows("causes").into_iter().map(|row| row[..4].to_vec()).collect();
    let expected: Vec<Vec<String>> = Reason::ALL
        .iter()
        .map(|reason| {
            let ms = reason.deadline_ms(&limits);
            let clock = if reason.clock() == Clock::Wall { " (own clock)" } else { "" };
            let within = format!("{}.{} s{clock}", ms / 1000, ms % 1000 / 100);
            vec![reason.name().into(), reason.action().name().into(), within, reason.recovery().name().into()]
        })
        .collect();
    for (documented, expected) in documented.iter().zip(&expected) {
        assert_eq!(documented, expected);
    }
    assert_eq!(documented.len(), expected.len());
}

/// Every setting and its default, as in the derived `Debug` text.
fn settings() -> Vec<(String, String)> {
    let text = format!("{:#?}", Limits::default()).replace("Some(\n        ", "").replace(",\n    )", "");
    let fields = text.lines().filter_map(|line| line.trim().trim_end_matches(',').split_once(": "));
    fields.map(|(name, value)| (name.to_string(), value.to_string())).collect()
}

#[test]
fn settings_and_defaults_are_as_documented() {
    let documented: Vec<(String, String)> =
        rows("settings").into_iter().map(|row| (row[0].clone(), row[1].replace(',', ""))).collect();
    assert_eq!(documented, settings());
}
