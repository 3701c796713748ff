//! The figures, the table and the settings in the page.

use crate::simulation::fleet_kind::FleetKind;
use crate::simulation::settings::Simulation;
use crate::simulation::summary::Summary;
use crate::simulation::world_flight::WorldFlight;
use covey_report::report::{Better, Cell, Column, Estimate, Figure, Group, Row};
use firmware_core::actor::Mode;

const fn estimate(mean: f64, decimals: usize) -> Estimate {
    Estimate { mean, standard_error: None, decimals }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

pub(super) fn figures(summary: &Summary) -> Vec<Figure> {
    let figure =
        |label: &str, value, unit: &str, note: String| Figure { label: label.into(), value, unit: unit.into(), note };
    let share = |part: u64, whole: u64| estimate(100.0 * part as f64 / whole.max(1) as f64, 1);
    let trained = summary.trainer_coverage_mean;
    let simlink = summary.simlink_coverage_mean.map(|mean| {
        figure("Coverage index, simlink", estimate(mean, 3), "", "the same worlds on simulated autopilots".into())
    });
    let mut figures = vec![
        figure("Coverage index, flown", estimate(summary.coverage_mean, 3), "", "as the nodes measured it".into()),
        figure("Coverage index, trainer", estimate(trained, 3), "", "int8 evaluation of the same worlds".into()),
        figure(
            "Share of the trainer's",
            Estimate {
                standard_error: summary.share_standard_error.map(|error| 100.0 * error),
                ..estimate(100.0 * summary.share_of_trainer, 1)
            },
            "%",
            String::new(),
        ),
        figure(
            "Decisions as the trainer's",
            share(summary.decisions_equal_to_trainer, summary.decisions_compared),
            "%",
            format!("of {} compared", summary.decisions_compared),
        ),
        figure("Faster than real time", estimate(summary.realtime_factor, 1), "×", "from step 0 to the last".into()),
    ];
    figures.splice(2..2, simlink);
    figures
}

pub(super) fn columns() -> Vec<Column> {
    let column = |name: &str, better| Column { name: name.into(), unit: String::new(), better };
    vec![
        column("coverage flown", Better::Higher),
        column("by true positions", Better::Neither),
        column("on simlink", Better::Neither),
        column("trainer's", Better::Neither),
        column("decisions as the trainer's", Better::Neither),
        column("late", Better::Lower),
        column("missed", Better::Lower),
        column("troubles", Better::Lower),
    ]
}

pub(super) fn row(index: u64, flight: &WorldFlight) -> Row {
    let value = |mean, decimals| Cell::Value(estimate(mean, decimals));
    let count = |count: u64| value(count as f64, 0);
    Row {
        name: index.to_string(),
        emphasis: false,
        cells: vec![
            value(mean(&flight.coverage), 3),
            value(mean(&flight.true_coverage), 3),
            flight.simlink_coverage.as_ref().map_or(Cell::Text("–".into()), |shares| value(mean(shares), 3)),
            value(mean(&flight.trainer_coverage), 3),
            Cell::Text(format!("{} of {}", flight.equal, flight.compared)),
            count(flight.counters.late_decisions),
            count(flight.counters.missed_decisions),
            count(flight.trouble.len() as u64),
        ],
    }
}

pub(super) fn caption(sim: &Simulation<'_>) -> String {
    let compared = if sim.ideal {
        "its own flight of the world"
    } else {
        "what it would do in the situations that were measured, all neighbours heard"
    };
    format!("Decisions are compared with the trainer's in {compared}. Troubles are time-outs, failsafes and crashes.")
}

fn autopilots(sim: &Simulation<'_>) -> String {
    match (&sim.autopilots, sim.px4) {
        (FleetKind::Simlink, false) => "simlink as ArduPilot".into(),
        (FleetKind::Simlink, true) => "simlink as PX4".into(),
        (real, _) => real.to_string(),
    }
}

const fn dynamics(sim: &Simulation<'_>) -> &'static str {
    match (sim.autopilots.is_real(), sim.ideal) {
        (true, _) => "the autopilot's own simulation",
        (false, true) => "the scenario's own",
        (false, false) => "point mass with lag and drag",
    }
}

fn pace(sim: &Simulation<'_>) -> String {
    match sim.speed {
        Some(speed) => format!("{speed} × real time"),
        None if sim.autopilots.is_real() => "real time".into(),
        None => "lock-step".into(),
    }
}

pub(super) fn configuration(sim: &Simulation<'_>, summary: &Summary) -> Vec<Group> {
    let entry = |name: &str, value: String| (name.to_owned(), value);
    let (scenario, timing) = (&sim.scenario, &sim.timing);
    let group = |name: &str, entries| Group { name: name.into(), entries };
    let flight = vec![
        entry("UAVs", scenario.uavs.to_string()),
        entry("map", format!("{0} u × {0} u", scenario.side_u)),
        entry("autopilots", autopilots(sim)),
        entry("dynamics", dynamics(sim).into()),
        entry("pace", pace(sim)),
        entry("actions", if sim.mode == Mode::Argmax { "most likely" } else { "drawn" }.into()),
        entry("telemetry", format!("{} Hz", sim.rate_hz)),
        entry("encodes, decides", format!("{} ms, {} ms into a step", timing.encode_ms, timing.decide_ms)),
        entry("actor", format!("{:016x}", sim.actor.content_hash())),
    ];
    let mut messages =
        vec![entry("sent", summary.messages_sent.to_string()), entry("used", summary.messages_received.to_string())];
    messages.extend(summary.messages_rejected.iter().map(|(reason, count)| entry(reason, count.to_string())));
    let mut groups = vec![group("Flight", flight), group("Neighbour messages", messages)];
    if !sim.fleet.is_empty() {
        let entries = sim.fleet.iter().map(|(name, value)| entry(name, value.to_string())).collect();
        groups.push(group("Fleet", entries));
    }
    groups
}
