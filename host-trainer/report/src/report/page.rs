//! The report as one HTML page.

use super::chart_html::charts;
use super::error::ReportError;
use super::escape::Escaped;
use super::model::{Content, Figure, Group, Report, Section};
use super::palette::Palette;
use super::{player, table};
use crate::atomic;
use std::fmt::Write;
use std::path::Path;

const STYLE: &str = include_str!("../assets/page.css");
/// First in the page, so that it counts the errors of all that follows.
const WATCH: &str = include_str!("../assets/watch.js");
const CHARTS: &str = include_str!("../assets/charts.js");
const MAP: &str = include_str!("../assets/map.js");
const PLAYER: &str = include_str!("../assets/player.js");

/// Forbids every request: the page has all it needs, and no text in it can call out.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:";

impl Report {
    /// The page as HTML.
    ///
    /// # Errors
    /// [`ReportError`] when parts of the report contradict each other.
    pub fn html(&self) -> Result<String, ReportError> {
        html(self)
    }

    /// Writes the page to `path` atomically ([`atomic::write`]), and creates its folder if there is none.
    ///
    /// # Errors
    /// As [`Report::html`], and [`ReportError::Write`] or [`ReportError::Folder`].
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), ReportError> {
        let html = self.html()?;
        if let Some(folder) = path.as_ref().parent().filter(|f| !f.as_os_str().is_empty()) {
            std::fs::create_dir_all(folder)
                .map_err(|source| ReportError::Folder { folder: folder.display().to_string(), source })?;
        }
        Ok(atomic::write(path, html.as_bytes())?)
    }
}

fn html(report: &Report) -> Result<String, ReportError> {
    let mut palette = Palette::default();
    let mut body = String::new();
    for (index, section) in report.sections.iter().enumerate() {
        body += &section_html(index, section, &mut palette)?;
    }
    let title = Escaped(&report.title);
    let subtitle = match report.subtitle.as_str() {
        "" => String::new(),
        text => format!("<p>{}</p>", Escaped(text)),
    };
    Ok(format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n\
         <title>{title}</title>\n<link rel=\"icon\" href=\"data:,\">\n\
         <style>\n{STYLE}</style>\n<script>\n{WATCH}</script>\n</head>\n<body>\n\
         <header><div><h1>{title}</h1>{subtitle}</div>\
         <button type=\"button\" class=\"theme\" data-theme-button aria-label=\"Light or dark\"></button></header>\n\
         {navigation}<main>\n{body}</main>\n\
         <footer>Covey {version}. This page is one file and needs no network.</footer>\n\
         <script>\n{CHARTS}{MAP}{PLAYER}</script>\n</body>\n</html>\n",
        navigation = navigation(&report.sections),
        version = env!("CARGO_PKG_VERSION"),
    ))
}

fn navigation(sections: &[Section]) -> String {
    if sections.len() < 3 {
        return String::new();
    }
    let mut out = String::from("<nav aria-label=\"Sections\">");
    for (index, section) in sections.iter().enumerate() {
        let _ = write!(out, "<a href=\"#section-{}\">{}</a>", index + 1, Escaped(&section.title));
    }
    out + "</nav>\n"
}

fn section_html(index: usize, section: &Section, palette: &mut Palette) -> Result<String, ReportError> {
    let mut out = format!(
        "<section id=\"section-{number}\" aria-labelledby=\"heading-{number}\"><h2 id=\"heading-{number}\">{}</h2>",
        Escaped(&section.title),
        number = index + 1,
    );
    if !section.lead.is_empty() {
        let _ = write!(out, "<p class=\"lead\">{}</p>", Escaped(&section.lead));
    }
    out += &match &section.content {
        Content::Text => String::new(),
        Content::Figures(figures) => figures_html(figures),
        Content::Table(t) => table::html(t),
        Content::Configuration(groups) => configuration(groups),
        Content::Charts(c) => charts(c, palette)?,
        Content::Episodes(episodes) => player::html(index + 1, episodes)?,
    };
    Ok(out + "</section>\n")
}

fn figures_html(figures: &[Figure]) -> String {
    let mut out = String::from("<dl class=\"figures\">");
    for figure in figures {
        let unit =
            if figure.unit.is_empty() { String::new() } else { format!(" <small>{}</small>", Escaped(&figure.unit)) };
        let note = if figure.note.is_empty() { String::new() } else { format!("<dd>{}</dd>", Escaped(&figure.note)) };
        let value = figure.value.html();
        let _ = write!(out, "<div><dt>{}</dt><dd>{value}{unit}</dd>{note}</div>", Escaped(&figure.label));
    }
    out + "</dl>"
}

fn configuration(groups: &[Group]) -> String {
    let mut out = String::from("<div class=\"configuration\">");
    for group in groups {
        let _ = write!(out, "<div><h3>{}</h3><dl>", Escaped(&group.name));
        for (name, value) in &group.entries {
            let _ = write!(out, "<div><dt>{}</dt><dd>{}</dd></div>", Escaped(name), Escaped(value));
        }
        out += "</dl></div>";
    }
    out + "</div>"
}
