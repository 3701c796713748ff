//! The graph of dependencies between source files, and its circles.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::fmt::Write as _;

/// The uses of one file's names in another file: line (from 1) and name.
type References = BTreeSet<(usize, String)>;

/// A directed graph of source files, which are named by their paths from the package's folder.
#[derive(Debug, Default)]
pub struct Graph {
    /// For each file the files whose names it uses.
    references: BTreeMap<String, BTreeMap<String, References>>,
}

impl Graph {
    /// Adds that the file `from` uses, in a line (from 1), the name `name` that is defined in the file `to`. Uses
    /// within a file are ignored.
    pub fn add(&mut self, from: &str, to: &str, name: &str, line: usize) {
        if from != to {
            let found = self.references.entry(from.into()).or_default().entry(to.into()).or_default();
            found.insert((line, name.into()));
        }
    }

    /// The circles of the graph: its strongly connected components of more than one file.
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

    /// The files whose names a file uses.
    fn used_by<'g>(&'g self, file: &str) -> impl Iterator<Item = &'g str> + use<'g> {
        self.references.get(file).into_iter().flat_map(|to| to.keys().map(String::as_str))
    }

    /// All files that `file` depends on, directly or through others. The file itself is one of them if it is in a
    /// circle.
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

    /// The shortest path from `file` back to itself, which is the first and the last file of the path.
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

/// A group of files of which each depends on every other, directly or through others.
#[derive(Debug)]
pub struct Circle<'g> {
    graph: &'g Graph,
    /// All files of the group.
    files: BTreeSet<&'g str>,
    /// The shortest circle among them, with its first file also at the end.
    shortest: Vec<&'g str>,
}

impl Circle<'_> {
    /// The shortest circle as a line of text. After each file stands the first of its names that the file before it
    /// uses, and the line of this use.
    pub fn line(&self) -> String {
        let mut line = self.shortest.first().copied().unwrap_or_default().to_owned();
        for (from, to) in self.shortest.iter().zip(self.shortest.iter().skip(1)) {
            let first = self.references(from, to).next();
            let (number, name) = first.map_or((0, ""), |(number, name)| (*number, name.as_str()));
            let _ = write!(line, " -> {to} ({name}, line {number})");
        }
        line
    }

    /// The number of files in the group; the shortest circle may have fewer.
    pub fn len(&self) -> usize {
        self.files.len()
    }

    /// Every dependency between files of the group, one a line: `from -> to: name (line), name (line)`.
    pub fn all(&self) -> Vec<String> {
        let mut lines = Vec::new();
        for from in &self.files {
            for to in self.files.iter().filter(|to| self.references(from, to).next().is_some()) {
                // Of a name that is used often only the first line is given.
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

    /// The uses of names of the file `to` in the file `from`.
    fn references(&self, from: &str, to: &str) -> impl Iterator<Item = &(usize, String)> {
        self.graph.references.get(from).and_then(|all| all.get(to)).into_iter().flatten()
    }
}
