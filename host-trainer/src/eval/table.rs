//! Rows as tables for people.

use super::row::{EvalRow, RadioRow};

/// A table of rows, with a column for radios where there are any.
#[must_use]
pub fn table(rows: &[EvalRow]) -> String {
    let radio = if rows.iter().any(|r| r.radio.is_some()) { "  radio" } else { "" };
    let mut out = format!(
        "{:<12} {:<10} {:>5}  {:<7} {:>14} {:>8} {:>7} {:>11} {:>7} {:>12}{radio}\n",
        "policy", "scenario", "uavs", "decide", "coverage", "last", "energy", "individual", "group", "reward"
    );
    for r in rows {
        let radio = r.radio.as_ref().map_or(String::new(), |row| format!("  {}", row.radio));
        out += &format!(
            "{:<12} {:<10} {:>5}  {:<7} {:>6.4} ±{:.4} {:>9.4} {:>7.3} {:>11.2} {:>7.2} {:>6.1} ±{:<4.1}{radio}\n",
            r.policy,
            r.scenario,
            r.uavs,
            r.decide,
            r.coverage,
            r.coverage_se,
            r.coverage_last,
            r.energy,
            r.individual,
            r.group,
            r.reward,
            r.reward_se
        );
    }
    out
}

/// What radios did, a line each.
#[must_use]
pub fn radio_table(rows: &[RadioRow]) -> String {
    let width = rows.iter().map(|r| r.radio.len()).max().unwrap_or(0).max(5);
    let mut out = format!(
        "{:<width$} {:>12} {:>12} {:>12} {:>8} {:>8} {:>9}\n",
        "radio", "sent", "lost", "refused", "known", "ghosts", "features"
    );
    for r in rows {
        out += &format!(
            "{:<width$} {:>12} {:>12} {:>12} {:>6.1} % {:>6.1} % {:>7.1} %\n",
            r.radio,
            r.datagrams_sent,
            r.datagrams_out_of_range + r.datagrams_lost,
            r.messages_refused + r.messages_malformed,
            100.0 * r.neighbours_known,
            100.0 * r.neighbours_ghost,
            100.0 * r.neighbours_with_feature
        );
    }
    out + "known, ghosts, features: neighbours known of, believed in range and not there, and whose feature was at hand,\n\
           each as a share of the neighbours in range\n"
}
