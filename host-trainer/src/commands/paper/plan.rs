//! Which runs the flags ask for.

use crate::cli::ExperimentPaper;
use crate::commands::settings::apply;
use crate::experiments::paper::{QUICK, run_name};
use crate::settings::Settings;
use miette::{IntoDiagnostic, Result, miette};

/// Settings of every run, seed by seed: an experiment that is stopped early has all algorithms of its
/// first seeds.
pub fn plan(args: &ExperimentPaper) -> Result<Vec<Settings>> {
    let kind = args.settings;
    let mut base = kind.settings();
    let quick = QUICK.iter().filter(|_| args.quick).map(|s| (*s).to_owned());
    let episodes = args.episodes.map(|n| format!("episodes={n}"));
    let all: Vec<String> = quick.chain(args.set.iter().cloned()).chain(episodes).collect();
    if let Some(set) = all.iter().find(|s| ["graph", "seed"].contains(&s.split('=').next().unwrap_or("").trim())) {
        return Err(miette!("--set {set}: the experiment chooses it; use --graphs and --seeds"));
    }
    let seeds = match &args.seeds {
        Some(text) => seeds(text)?,
        None if args.quick => vec![10, 11],
        None => (10..15).collect(),
    };
    let graphs: Vec<_> = match &args.graphs[..] {
        [] => kind.graphs().to_vec(),
        some => some.to_vec(),
    };
    apply(&mut base, &all)?;
    let mut found = Vec::new();
    for &seed in &seeds {
        for &graph in &graphs {
            let settings = Settings { graph, seed, ..base.clone() };
            settings.validate().into_diagnostic()?;
            if found.contains(&settings) {
                return Err(miette!("{} is named twice", run_name(&settings)));
            }
            found.push(settings);
        }
    }
    Ok(found)
}

/// `10-14` or `1,2,5`, also mixed.
fn seeds(text: &str) -> Result<Vec<u64>> {
    let wrong = || miette!("--seeds {text}: write 10-14 or 1,2,5");
    let number = |t: &str| t.trim().parse::<u64>().map_err(|_| wrong());
    let mut found = Vec::new();
    for part in text.split(',') {
        match part.split_once('-') {
            Some((first, last)) => {
                let (first, last) = (number(first)?, number(last)?);
                if first > last || last - first >= 1000 {
                    return Err(wrong());
                }
                found.extend(first..=last);
            }
            None => found.push(number(part)?),
        }
    }
    Ok(found)
}
