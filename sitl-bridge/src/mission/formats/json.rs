//! JSON texts, one or several, and what is said when they are broken.

use crate::mission::fault::{Fault, broken};
use serde_json::error::Category;
use serde_json::{Deserializer, Value};

/// One JSON value of a file.
#[derive(Debug)]
pub(super) struct Record {
    /// Where it begins, from 1.
    pub line: usize,
    pub value: Value,
}

/// All values of a text: one, or a sequence. Record separators are white space.
pub(super) fn values(text: &str) -> Result<Vec<Record>, Fault> {
    let plain;
    let text = if text.contains('\u{1e}') {
        plain = text.replace('\u{1e}', " ");
        plain.as_str()
    } else {
        text
    };
    let mut records = Vec::new();
    let (mut line, mut counted) = (1, 0);
    let mut stream = Deserializer::from_str(text).into_iter::<Value>();
    loop {
        let from = stream.byte_offset();
        let begins = from + text[from..].len() - text[from..].trim_start().len();
        line += text[counted..begins].matches('\n').count();
        counted = begins;
        match stream.next() {
            None => return Ok(records),
            Some(Ok(value)) => records.push(Record { line, value }),
            Some(Err(error)) => return Err(broken(explain(&error, text))),
        }
    }
}

/// A syntax error with what the user can do.
fn explain(error: &serde_json::Error, text: &str) -> String {
    let line = text.lines().nth(error.line().saturating_sub(1)).unwrap_or_default();
    let column = error.column().saturating_sub(1).min(line.len());
    // What stands there, from a word's beginning.
    let is_word = |b: u8| b.is_ascii_alphabetic() || b == b'-' || b == b'+';
    let start = line.as_bytes()[..column].iter().rposition(|&b| !is_word(b)).map_or(0, |at| at + 1);
    let there = line.get(start..).unwrap_or_default();
    let hint = if error.classify() == Category::Eof {
        "; the file ends too early: was it cut off?"
    } else if ["NaN", "nan", "Infinity", "inf", "-Infinity", "-NaN", "-nan", "-inf"]
        .iter()
        .any(|n| there.starts_with(n))
    {
        "; JSON has no NaN and no infinity: a number is missing there, so remove the feature or give it a place"
    } else if there.starts_with('\'') || line.get(column..).is_some_and(|rest| rest.starts_with('\'')) {
        "; JSON writes its texts in double quotes"
    } else if there.starts_with(['/', '#']) {
        "; JSON has no comments: remove it"
    } else if error.to_string().starts_with("trailing comma") {
        "; remove the comma before the closing bracket"
    } else if there.starts_with("None") || there.starts_with("True") || there.starts_with("False") {
        "; that is Python: write null, true or false"
    } else if there.starts_with(['.', '+']) || error.to_string().starts_with("invalid number") {
        "; numbers are written 0.5, without a plus sign and with a digit on each side of the point"
    } else {
        ""
    };
    format!("{error}{hint}")
}

/// A value in words.
pub(super) fn named(value: &Value) -> String {
    match value {
        Value::Null => "null".into(),
        Value::Bool(value) => value.to_string(),
        Value::Number(number) => format!("the number {number}"),
        Value::String(text) => {
            let short: String = text.chars().take(20).collect();
            if short.len() < text.len() { format!("the text \"{short}…\"") } else { format!("the text \"{text}\"") }
        }
        Value::Array(_) => "an array".into(),
        Value::Object(_) => "an object".into(),
    }
}
