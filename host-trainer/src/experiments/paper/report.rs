//! The page.

use super::claims::{CLAIMS, Claim};
use super::compare::improvements;
use super::design::{ALGORITHMS, title};
use super::figures::{COMPARED, FIGURES, Figure};
use super::judge::{Criterion, Finding, Verdict};
use super::kind::Kind;
use super::kind::command;
use super::metric::Metric;
use super::results::{Group, Results};
use super::statistics::bootstrap;
use super::tables::{beside_baselines, by_uavs, coverage_reached, end_of_training, interval};
use crate::settings::keys;
use firmware_core::actor::Aggregation;
use std::fmt::Write;

/// The page in Markdown; pictures are in `figures/` beside it.
#[must_use]
pub fn page(results: &Results) -> String {
    let mut out = introduction(results);
    if let Some(group) = results.group(Kind::Paper) {
        let found: Vec<(&Claim, Finding)> = CLAIMS.iter().map(|c| (c, c.test(group, results))).collect();
        out += &summary(&found);
        for f in FIGURES {
            out += &section(f, group, results, &found);
        }
    }
    out += &comparison(results);
    for group in &results.groups {
        out += &settings(group);
    }
    out
}

fn introduction(results: &Results) -> String {
    let mut out = String::from(
        "# The paper's experiments\n\n\
         The experiments of *A Graph-Based PPO Approach in Multi-UAV Navigation for Communication Coverage*, section 4, repeated: plain PPO, PPO \
         with GCN\nand PPO with GAT trained from several seeds, their curves over training, the trained policies with other numbers of UAVs, and \
         every statement of\nthat section (in our words) beside what was measured here. This page is written by the program; nothing in it is typed \
         by hand:\n\n",
    );
    for group in &results.groups {
        let graphs: Vec<&str> = group.graphs().iter().map(|g| g.name()).collect();
        let _ = writeln!(out, "    {}", command(group.kind, &graphs, &group.seeds(), &group.settings, results.worlds));
    }
    out += "\n`--report-only` writes it again from the run folders, or from `results.json` beside it, which holds all numbers behind it.\n\n";
    out += "| group | algorithms | seeds | episodes | UAVs in training |\n|---|---|---|--:|--:|\n";
    for g in &results.groups {
        let graphs: Vec<&str> = g.graphs().iter().map(|&g| title(g)).collect();
        let seeds: Vec<String> = g.seeds().iter().map(u64::to_string).collect();
        let _ = writeln!(
            out,
            "| {} | {} | {} | {} | {} |",
            g.kind.title(),
            graphs.join(", "),
            seeds.join(", "),
            g.episodes(),
            g.setting("uavs")
        );
    }
    let others: Vec<&str> = Aggregation::ALL
        .into_iter()
        .filter(|g| !ALGORITHMS.contains(g) && results.groups.iter().any(|group| group.graphs().contains(g)))
        .map(title)
        .collect();
    if !others.is_empty() {
        let _ = writeln!(
            out,
            "\n{} beside the paper's three. Its equation (6) is the attention of Veličković et al., our GAT; the work that it cites for attention, \
             Brody et al.,\nhas another, our GATv2. Its statements are judged of plain PPO, GCN and GAT.",
            others.join(" and "),
        );
    }
    if results.groups.iter().any(|g| g.seeds().len() < 3) {
        out += "\n**A trial run: from fewer than three seeds nothing can be concluded.**\n";
    }
    let _ = write!(
        out,
        "\n**How it is judged.** A claim is one number for each seed. Its mean over seeds has a 95 % interval by Student's t, since a bootstrap of \
         so few\nseeds would be too narrow. Algorithms are compared seed by seed: the same seed has the same training worlds. A claim *holds* when \
         the whole\ninterval fulfils its condition, *does not hold* when none of it does, and is *not separable* otherwise. Of many such claims \
         about one in twenty\nwould be decided by chance alone. A figure that the paper gives stands for what rounds to it; \"about the same\" is \
         within 5 %.\n\n\
         **Numbers.** Curves are means over the rounds of training ({} episodes each), bands 95 % intervals (t) of the mean over seeds. Tables \
         have the\ninterquartile mean over seeds, which leaves the lowest and the highest quarter out, with a 95 % bootstrap interval over seeds \
         (whole runs are\ndrawn, {} times, from a fixed seed). Policies fly as int8 actors, actions drawn, in worlds 0 to {} of seed {}: worlds \
         that no run was trained\non, the same for all.\n",
        results.groups.first().map_or("?", |g| g.setting("num_envs")),
        super::statistics::RESAMPLES,
        results.worlds.saturating_sub(1),
        results.world_seed,
    );
    out
}

fn summary(found: &[(&Claim, Finding)]) -> String {
    let count = |v| found.iter().filter(|f| f.1.verdict == v).count();
    let mut out = format!(
        "\n## In short\n\nOf {} statements {} hold, {} do not hold, {} are not separable",
        found.len(),
        count(Verdict::Holds),
        count(Verdict::DoesNotHold),
        count(Verdict::NotSeparable)
    );
    match count(Verdict::NotMeasured) {
        0 => out += ".\n\n",
        n => out += &format!(", {n} were not measured (runs too short, or algorithms missing).\n\n"),
    }
    out += "| figure | the paper says | here |\n|--:|---|---|\n";
    for (claim, finding) in found {
        let _ = writeln!(out, "| {} | {} | {} |", claim.figure, claim.statement, finding.verdict.name());
    }
    out
}

fn section(f: Figure, group: &Group, results: &Results, found: &[(&Claim, Finding)]) -> String {
    let over = if f.flights { "the number of UAVs" } else { "training" };
    let name = f.metric.labels().0;
    let mut out = format!(
        "\n## Figure {}: {} over {over}\n\n![{name} over {over}](figures/{})\n\n| the paper says | measured | here | holds when | verdict |\n\
         |---|---|--:|---|---|\n",
        f.number,
        name.replacen(|c: char| c.is_ascii_uppercase(), &name[..1].to_lowercase(), 1),
        f.file
    );
    for (claim, finding) in found.iter().filter(|(c, _)| c.figure == f.number) {
        let measured = match finding.interval {
            Some(i) => interval(i, claim.decimals()),
            None => "–".into(),
        };
        let _ = writeln!(
            out,
            "| {} | {} | {measured} | {} | **{}** |",
            claim.statement,
            claim.measure.words(),
            bar(claim.criterion),
            finding.verdict.name()
        );
    }
    match f.number {
        5 => out += &format!("\nAt the end of training (mean of the last tenth):\n\n{}", end_of_training(group)),
        6 => out += &format!("\nEpisodes until a round's coverage reached:\n\n{}", coverage_reached(group)),
        _ if f.flights => {
            out += &format!("\n{}{}", by_uavs(group, &results.sizes, f.metric), overall(group, f.metric));
        }
        _ => {}
    }
    out
}

/// Interquartile mean over all runs and numbers of UAVs. A run's flights go together, so whole
/// runs are resampled.
fn overall(group: &Group, metric: Metric) -> String {
    let one = |graph: Aggregation| {
        let runs: Vec<Vec<f64>> =
            group.of(graph).map(|r| r.flights.iter().filter_map(|f| f.of(metric)).collect()).collect();
        let found = bootstrap(&runs, "interquartile mean over numbers of UAVs", |drawn| {
            let all: Vec<f64> = drawn.iter().flat_map(|run| run.iter().copied()).collect();
            super::statistics::interquartile_mean(&all)
        })?;
        Some(format!("{} {}", title(graph), interval(found, metric.decimals())))
    };
    let all: Vec<String> = group.graphs().into_iter().filter_map(one).collect();
    if all.is_empty() { String::new() } else { format!("\nOver all numbers of UAVs: {}.\n", all.join(", ")) }
}

fn bar(bar: Criterion) -> String {
    let exact = |v: f64| format!("{v}").replace('-', "−");
    match bar {
        Criterion::Above(b) => format!("above {}", exact(b)),
        Criterion::Below(b) => format!("below {}", exact(b)),
        Criterion::Within(low, high) => format!("{} to {}", exact(low), exact(high)),
    }
}

fn comparison(results: &Results) -> String {
    let mut out = String::from("\n## All policies, by number of UAVs\n\nHand-written policies in italics.\n");
    for (file, metric) in COMPARED {
        let name = metric.labels().0;
        let _ = write!(
            out,
            "\n![{name} of all policies](figures/{file})\n\n{name}:\n\n{}",
            beside_baselines(results, metric)
        );
    }
    out += "\n## Against plain PPO trained equally long\n\n\
            Differences seed by seed, their mean and 95 % interval (t). *Above* and *below*: the interval excludes 0.\n";
    let lengths: Vec<String> =
        results.groups.iter().map(|g| format!("{} episodes in {}", g.episodes(), g.kind.title())).collect();
    if results.groups.windows(2).any(|w| w[0].episodes() != w[1].episodes()) {
        let _ = writeln!(
            out,
            "Runs of one group are of equal length, those of different groups are not: {}.",
            lengths.join(", ")
        );
    }
    out + &improvements(results)
}

fn settings(group: &Group) -> String {
    let mut out = format!("\n## Settings: {}\n\n", group.kind.title());
    if group.kind == Kind::Paper {
        out += "PPO as in [training.md](../training.md), which also says in what it differs from the paper's algorithm 1; without \
                behaviour\ncloning, and what flies is the last policy as it was trained (no running average of weights, no temperature).\n\n";
    }
    out += "<details><summary>Every setting</summary>\n\n| setting | value | default |\n|---|---|---|\n";
    for (key, value) in &group.settings {
        let default = keys().iter().find(|k| k.name == *key).map_or("–", |k| &k.default);
        let same = if default == value { "the same".to_owned() } else { format!("**{default}**") };
        let _ = writeln!(out, "| `{key}` | {value} | {same} |");
    }
    out + "\n</details>\n"
}
