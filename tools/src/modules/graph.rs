//! Which file uses which, and where that goes round in circles.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::fmt::Write as _;

/// The references of one file to another: the line (from 1) and the name.
type References = BTreeSet<(usize, String)>;

/// Files and their references to each other. A file is named by its path from the package's folder.
#[derive(Debug, Default)]
pub struct Graph {
    references: BTreeMap<String, BTreeMap<String, References>>,
}

impl Graph {
    /// Notes that `from` uses `name` of `to` in a line (from 1). What a file uses of itself does not count.
    pub fn add(&mut self, from: &str, to: &str, name: &str, line: usize) {
        if from != to {
            let found = self.references.entry(from.into()).or_default().entry(to.into()).or_default();
            found.insert((line, name.into()));
        }
    }

    /// Every group of files that need each other, directly or through others of the group: the strongly connected
    /// components of more than one file.
    pub fn circles(&self) -> Vec<Circle<'_>> {
        let reach: BTreeMap<&str, BTreeSet<&str>> =
            self.references.keys().map(|file| (file.as_str(), self.reached_from(file))).collect();
        let mut circles = Vec::new();
        let mut told: BTreeSet<&str> = BTreeSet::new();
        for (file, reached) in &reach {
            if told.contains(file) || !reached.contains(file) {
                continue;
            }
            let back = |other: &&str| reach.get(other).is_some_and(|reached| reached.contains(file));
            let files: BTreeSet<&str> = reached.iter().copied().filter(back).collect();
            told.extend(&files);
            let shortest = files.iter().filter_map(|file| self.shortest_circle(file)).min_by_key(Vec::len);
            circles.push(Circle { graph: self, files, shortest: shortest.unwrap_or_default() });
        }
        circles
    }

    fn used_by<'g>(&'g self, file: &str) -> impl Iterator<Item = &'g str> + use<'g> {
        self.references.get(file).into_iter().flat_map(|to| to.keys().map(String::as_str))
    }

    /// All files that `file` uses, directly or not; itself only where it is in a circle.
    fn reached_from<'g>(&'g self, file: &str) -> BTreeSet<&'g str> {
        let mut reached = BTreeSet::new();
        let mut waiting: Vec<&str> = self.used_by(file).collect();
        while let Some(next) = waiting.pop() {
            if reached.insert(next) {
                waiting.extend(self.used_by(next));
            }
        }
        reached
    }

    /// The fewest files from `file` back to itself, which is both the first and the last of them.
    fn shortest_circle<'g>(&'g self, file: &'g str) -> Option<Vec<&'g str>> {
        let mut came_from: BTreeMap<&str, &str> = BTreeMap::new();
        let mut waiting = VecDeque::from([file]);
        while let Some(at) = waiting.pop_front() {
            for next in self.used_by(at) {
                if next == file {
                    let mut circle = vec![file, at];
                    while let Some(before) = circle.last().and_then(|last| came_from.get(last)) {
                        circle.push(before);
                    }
                    circle.reverse();
                    return Some(circle);
                }
                if !came_from.contains_key(next) {
                    came_from.insert(next, at);
                    waiting.push_back(next);
                }
            }
        }
        None
    }
}

/// Files of which each needs every other.
#[derive(Debug)]
pub struct Circle<'g> {
    graph: &'g Graph,
    files: BTreeSet<&'g str>,
    shortest: Vec<&'g str>,
}

impl Circle<'_> {
    /// The shortest way round, in a line: each file with the first name that the file before uses of it, and the line
    /// there.
    pub fn line(&self) -> String {
        let mut line = self.shortest.first().copied().unwrap_or_default().to_owned();
        for (from, to) in self.shortest.iter().zip(self.shortest.iter().skip(1)) {
            let first = self.references(from, to).next();
            let (number, name) = first.map_or((0, ""), |(number, name)| (*number, name.as_str()));
            let _ = write!(line, " -> {to} ({name}, line {number})");
        }
        line
    }

    /// How many files are in it; the shortest way round may leave some out.
    pub fn len(&self) -> usize {
        self.files.len()
    }

    /// Every reference inside the circle, one a line: `from -> to: name (line), name (line)`.
    pub fn all(&self) -> Vec<String> {
        let mut lines = Vec::new();
        for from in &self.files {
            for to in self.files.iter().filter(|to| self.references(from, to).next().is_some()) {
                // A name that is used often is told once.
                let mut names: BTreeMap<&str, usize> = BTreeMap::new();
                for (line, name) in self.references(from, to) {
                    names.entry(name).or_insert(*line);
                }
                let names: Vec<String> = names.iter().map(|(name, line)| format!("{name} ({line})")).collect();
                lines.push(format!("{from} -> {to}: {}", names.join(", ")));
            }
        }
        lines
    }

    fn references(&self, from: &str, to: &str) -> impl Iterator<Item = &(usize, String)> {
        self.graph.references.get(from).and_then(|all| all.get(to)).into_iter().flatten()
    }
}
