//! Splits a text table into records of fields, quoted or not, divided by separators or blanks.

use std::io::{Chain, Read};

use csv::{ReaderBuilder, StringRecord, Trim};

/// A reader of records, line by line.
pub(super) struct Records<'a> {
    text: &'a str,
    source: Source<'a>,
}

enum Source<'a> {
    /// The text, followed by [`END`].
    Separated(Box<csv::Reader<Chain<&'a [u8], &'static [u8]>>>),
    Blanks(std::iter::Enumerate<std::str::Lines<'a>>),
}

/// A line after a text, which is a record of its own unless the text ends inside quotes.
const END: &[u8] = b"\nend";

/// The fields of one record.
#[derive(Default)]
pub(super) struct Record {
    pub fields: Vec<String>,
    /// Number of the record's first line, from 1.
    pub line: usize,
    /// Whether the first field is quoted, as R quotes the names of rows.
    pub is_named: bool,
}

impl<'a> Records<'a> {
    /// Makes a reader of records whose fields are divided by `separator`, or by blanks if it is `None`.
    pub fn new(text: &'a str, separator: Option<u8>) -> Self {
        let source = match separator {
            Some(separator) => Source::Separated(Box::new(
                ReaderBuilder::new()
                    .delimiter(separator)
                    .has_headers(false)
                    .flexible(true)
                    .trim(Trim::All)
                    .from_reader(text.as_bytes().chain(END)),
            )),
            None => Source::Blanks(text.lines().enumerate()),
        };
        Self { text, source }
    }

    /// Returns the next record that has a non-empty field.
    pub fn next(&mut self) -> Result<Option<Record>, String> {
        loop {
            let Some(record) = self.any()? else { return Ok(None) };
            if record.fields.iter().any(|field| !field.is_empty()) {
                return Ok(Some(record));
            }
        }
    }

    fn any(&mut self) -> Result<Option<Record>, String> {
        let reader = match &mut self.source {
            Source::Blanks(lines) => {
                return Ok(lines.next().map(|(index, line)| Record {
                    fields: between_blanks(line),
                    line: index + 1,
                    is_named: line.trim_start().starts_with('"'),
                }));
            }
            Source::Separated(reader) => reader,
        };
        let mut record = StringRecord::new();
        // An error cannot occur here, since the text is valid UTF-8.
        if !reader.read_record(&mut record).map_err(|error| error.to_string())? {
            return Ok(None);
        }
        let (start, first_line) = record.position().map_or((0, 1), |at| (at.byte(), at.line()));
        let (end, size) = (reader.position().byte() as usize, self.text.len());
        let raw = &self.text[size.min(start as usize)..size.min(end)];
        // The position is the end of the previous record. The reader skips empty lines between that place and
        // this record.
        let begin = raw.trim_start_matches(['\r', '\n']);
        let passed = raw[..raw.len() - begin.len()].matches('\n').count();
        let line = first_line as usize + passed;
        if end == size + END.len() {
            return match begin.trim().is_empty() {
                true => Ok(None),
                false => Err(format!("line {line}: a quoted field has no end; close it by a `\"`")),
            };
        }
        let fields = record.iter().map(unquoted).collect();
        Ok(Some(Record { fields, line, is_named: begin.trim_start().starts_with('"') }))
    }
}

/// Removes the quotes that the csv crate keeps in a field because a blank precedes them.
fn unquoted(field: &str) -> String {
    let inside = field.strip_prefix('"').and_then(|field| field.strip_suffix('"'));
    inside.unwrap_or(field).to_owned()
}

/// Splits a line into fields divided by blanks.
fn between_blanks(line: &str) -> Vec<String> {
    let mut fields = Vec::new();
    let mut rest = line.trim_start();
    while !rest.is_empty() {
        let quoted = rest.strip_prefix('"').and_then(|inside| inside.split_once('"'));
        let (field, after) = match quoted {
            Some(found) => found,
            None => rest.split_at(rest.find(char::is_whitespace).unwrap_or(rest.len())),
        };
        fields.push(field.to_owned());
        rest = after.trim_start();
    }
    fields
}

/// Returns the separator between the fields of a line, or `None` for blanks.
pub(super) fn separator_of(line: &str) -> Option<u8> {
    let mut is_quoted = false;
    let outside: String = line
        .chars()
        .filter(|&c| {
            is_quoted ^= c == '"';
            !is_quoted
        })
        .collect();
    let has = |c: char| outside.contains(c);
    // A tab after a comma counts as a blank.
    let tabs = has('\t') && !outside.split('\t').any(|field| field.trim_end().ends_with(','));
    match () {
        () if has(';') => Some(b';'),
        () if tabs && outside.trim().contains('\t') => Some(b'\t'),
        () if has(',') => Some(b','),
        () => None,
    }
}
