//! Tables of figures with their errors.

use std::fmt::Write;

use serde::{Deserialize, Serialize};

use super::escape::Escaped;
use super::number::number;

/// Rows by columns, such as policies by metrics.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Table {
    /// Head of the column of row names: `Policy`.
    pub corner: String,
    /// The columns.
    pub columns: Vec<Column>,
    /// The rows. Cells that a row lacks are empty; those beyond the columns are not shown.
    pub rows: Vec<Row>,
    /// Under the table: worlds, seeds, meaning of the errors. Empty for none.
    pub caption: String,
}

/// One column.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Column {
    /// What it holds: `coverage`.
    pub name: String,
    /// Unit; empty for none.
    pub unit: String,
    /// Whether higher or lower values are better; the best one is marked.
    pub better: Better,
}

/// Whether higher or lower values are better.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Better {
    /// Neither: nothing is marked.
    #[default]
    Neither,
    /// The higher the better.
    Higher,
    /// The lower the better.
    Lower,
}

/// One row.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Whose figures: `GCN, int8`.
    pub name: String,
    /// Whether the row is what the report is about.
    pub emphasis: bool,
    /// One cell a column.
    pub cells: Vec<Cell>,
}

/// One cell.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Cell {
    /// Not measured.
    #[default]
    Empty,
    /// A figure.
    Value(Estimate),
    /// Words.
    Text(String),
}

/// A figure, with its error where there is one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The figure.
    pub mean: f64,
    /// Its standard error.
    pub standard_error: Option<f64>,
    /// Decimals to show.
    pub decimals: usize,
}

impl Estimate {
    /// A figure without an error.
    #[must_use]
    pub fn exact(mean: f64, decimals: usize) -> Self {
        Self { mean, standard_error: None, decimals }
    }

    /// Mean of `samples` and its standard error, s/√n (none for a single sample; NaN,
    /// shown as a dash, for no samples).
    #[must_use]
    pub fn of(samples: &[f64], decimals: usize) -> Self {
        let n = samples.len() as f64;
        let mean = samples.iter().sum::<f64>() / n;
        let spread = samples.iter().map(|v| (v - mean).powi(2)).sum::<f64>();
        let standard_error = (samples.len() > 1).then(|| (spread / (n - 1.0) / n).sqrt());
        Self { mean, standard_error, decimals }
    }

    pub(super) fn html(&self) -> String {
        let mean = number(self.mean, self.decimals);
        match self.standard_error.filter(|_| self.mean.is_finite()) {
            Some(error) => {
                format!("{mean} <small>± {}</small>", number(error, decimals_of_error(error, self.decimals)))
            }
            None => mean,
        }
    }
}

/// The figure's decimals, or as many as a small error needs to differ from 0.
fn decimals_of_error(error: f64, decimals: usize) -> usize {
    if error > 0.0 && error.is_finite() {
        decimals.max((-error.log10().floor()).clamp(0.0, 6.0) as usize)
    } else {
        decimals
    }
}

/// The table as HTML. ARIA roles are written out because style sheets that lay the rows out as cards, for phones,
/// remove the table's own roles.
pub(super) fn html(table: &Table) -> String {
    // Many columns become cards on a tablet already.
    let wide = if table.columns.len() > 7 { " wide" } else { "" };
    let mut out = format!("<div class=\"table{wide}\">");
    out.push_str("<table role=\"table\"><thead role=\"rowgroup\"><tr role=\"row\">");
    let _ = write!(out, "<th role=\"columnheader\" scope=\"col\">{}</th>", Escaped(&table.corner));
    for column in &table.columns {
        let unit =
            if column.unit.is_empty() { String::new() } else { format!(" <small>{}</small>", Escaped(&column.unit)) };
        let _ = write!(out, "<th role=\"columnheader\" scope=\"col\">{}{unit}</th>", Escaped(&column.name));
    }
    out += "</tr></thead><tbody role=\"rowgroup\">";
    let best: Vec<_> = (0..table.columns.len()).map(|c| best(table, c)).collect();
    for row in &table.rows {
        let emphasis = if row.emphasis { " class=\"emphasis\"" } else { "" };
        let _ =
            write!(out, "<tr role=\"row\"{emphasis}><th role=\"rowheader\" scope=\"row\">{}</th>", Escaped(&row.name));
        for (c, column) in table.columns.iter().enumerate() {
            let (class, content) = match row.cells.get(c) {
                None | Some(Cell::Empty) => (" class=\"empty\"", "–".into()),
                Some(Cell::Text(text)) => ("", Escaped(text).to_string()),
                Some(Cell::Value(value)) if shown(value).is_some() && best[c] == shown(value) => {
                    (" class=\"best\"", value.html() + "<span class=\"hidden\"> (best)</span>")
                }
                Some(Cell::Value(value)) => ("", value.html()),
            };
            let name = format!("{} {}", column.name, column.unit);
            let name = Escaped(name.trim_end());
            let _ = write!(out, "<td role=\"cell\" data-label=\"{name}\"{class}><span>{content}</span></td>");
        }
        out += "</tr>";
    }
    out += "</tbody></table></div>";
    if !table.caption.is_empty() {
        let _ = write!(out, "<p class=\"caption\">{}</p>", Escaped(&table.caption));
    }
    out
}

/// The best figure of a column as it is shown (equal texts are equally good); none
/// when there is nothing to choose between.
fn best(table: &Table, column: usize) -> Option<f64> {
    let sign = match table.columns.get(column)?.better {
        Better::Neither => return None,
        Better::Higher => 1.0,
        Better::Lower => -1.0,
    };
    let values = table.rows.iter().filter_map(|row| match row.cells.get(column) {
        Some(Cell::Value(value)) => shown(value),
        _ => None,
    });
    let values: Vec<f64> = values.collect();
    let best = values.iter().copied().max_by(|a, b| (sign * a).total_cmp(&(sign * b)))?;
    (values.len() > 1 && values.iter().any(|v| *v != best)).then_some(best)
}

/// The figure as it is shown, that is rounded.
fn shown(value: &Estimate) -> Option<f64> {
    let scale = 10f64.powi(i32::try_from(value.decimals).unwrap_or(0));
    value.mean.is_finite().then(|| (value.mean * scale).round() / scale)
}
