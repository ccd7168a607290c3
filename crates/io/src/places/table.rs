//! Reads text tables of places.

use std::borrow::Cow;

use super::columns::{Columns, Named, finite};
use super::content::{CurveKind, FileCurve, FileCurves, Vertex};
use super::records::{Record, Records, separator_of};
use geosweep_surface::shown::excerpt;

/// Reads a table.
pub(super) fn read(text: &str) -> Result<FileCurves, String> {
    let (text, declared) = declared_separator(text);
    let (text, comment) = without_comments(text);
    let Some(first_line) = text.lines().find(|line| !line.trim().is_empty()) else {
        return Ok(FileCurves::default());
    };
    let separator = declared.or_else(|| separator_of(first_line));
    let mut records = Records::new(&text, separator);
    let Some(first) = records.next()? else { return Ok(FileCurves::default()) };
    let (columns, mut pending, is_sure) = if is_header(&first) {
        let columns = Columns::new(first.fields.clone())?.ok_or_else(|| no_places(&first))?;
        (columns, None, true)
    } else {
        let mut first = without_comment(first);
        while first.fields.len() > 2 && first.fields.last().is_some_and(String::is_empty) {
            first.fields.pop();
        }
        let named = comment.and_then(|line| named_by_comment(line, first.fields.len()));
        match named.transpose()? {
            Some(columns) => (columns, Some(first), true),
            None => (unnamed(&first)?, Some(first), false),
        }
    };

    let mut rows = Rows { columns: &columns, is_named: None, decimal: None };
    let mut read = Vec::new();
    while let Some(record) =
        pending.take().map_or_else(|| records.next(), |first| Ok(Some(first)))?
    {
        let line = record.line;
        let row = rows.read(record).map_err(|reason| format!("line {line}: {reason}"))?;
        read.push(row);
    }
    if columns.start.is_some() && !is_sure {
        check_no_index(&read)?;
    }
    let curve = |rows: &[Row]| {
        let is_closed = rows.first().is_some_and(|row| row.is_closed);
        FileCurve {
            kind: if is_closed { CurveKind::Closed } else { CurveKind::Any },
            vertices: rows.iter().map(|row| row.vertex).collect(),
        }
    };
    Ok(FileCurves {
        curves: read.chunk_by(|a, b| a.curve == b.curve).map(curve).collect(),
        unused: columns.unused()?,
        has_starts: columns.start.is_some(),
        coordinates: columns.coordinates,
        numbered: "line",
        empty: 0,
    })
}

/// Splits off a line such as `sep=;`, by which Excel declares the separator. Returns the remaining text and
/// the separator.
fn declared_separator(text: &str) -> (&str, Option<u8>) {
    let (first, rest) = text.split_once('\n').unwrap_or((text, ""));
    let first = first.trim().trim_matches('"').to_ascii_lowercase();
    match first.strip_prefix("sep=").map(str::as_bytes) {
        Some(&[separator]) => (rest, Some(separator)),
        _ => (text, None),
    }
}

/// Returns the text with empty lines in place of comments, and the last comment before the content.
fn without_comments(text: &str) -> (Cow<'_, str>, Option<&str>) {
    let is_comment = |line: &&str| line.trim_start().starts_with('#');
    if !text.lines().any(|line| is_comment(&line)) {
        return (text.into(), None);
    }
    let head = text.lines().take_while(|line| line.trim().is_empty() || is_comment(line));
    let last = head.filter(is_comment).last();
    let kept = text.split_inclusive('\n').map(|line| if is_comment(&line) { "\n" } else { line });
    (kept.collect::<String>().into(), last.map(|line| line.trim_start().trim_start_matches('#')))
}

/// Returns a record without a comment after its fields.
fn without_comment(mut record: Record) -> Record {
    if let Some(at) = record.fields.iter().position(|field| field.contains('#')) {
        record.fields.truncate(at + 1);
        let before = record.fields[at].split('#').next().unwrap_or_default().trim().to_owned();
        match before.is_empty() {
            true => drop(record.fields.pop()),
            false => record.fields[at] = before,
        }
    }
    record
}

/// Returns whether the first line names columns: it holds no number, or its fields include names of
/// coordinates.
fn is_header(record: &Record) -> bool {
    let mut fields = record.fields.iter().filter(|field| !field.is_empty());
    fields.all(|field| number(field).is_none())
        || matches!(Columns::new(record.fields.clone()), Ok(Some(_)) | Err(_))
}

/// Returns the columns that a comment names, if it names `count` columns and the coordinates of a place are
/// among them.
fn named_by_comment(comment: &str, count: usize) -> Option<Result<Columns, String>> {
    let names = Records::new(comment.trim(), separator_of(comment)).next().ok()??.fields;
    (names.len() == count).then(|| Columns::new(names).transpose()).flatten()
}

fn no_places(header: &Record) -> String {
    let line = header.fields.join(",");
    format!(
        "the header `{}` names no columns row and col, counted from 0 at the upper left point, nor x \
         and y in the surface's map coordinates; name them so, or leave the header out and give \
         lines of row,col",
        excerpt(&line)
    )
}

/// Returns the columns of lines without names.
fn unnamed(first: &Record) -> Result<Columns, String> {
    let Record { fields, line, is_named } = first;
    let shown = fields.join(",");
    let refused = |why: String| Err(format!("line {line}: `{}` {why}", excerpt(&shown)));
    match fields.len() {
        2 => Ok(Columns::unnamed(2)),
        3 if *is_named || fields[0].is_empty() => refused(
            "seems to begin with the name of a row; name the columns in a first line: name,row,col"
                .into(),
        ),
        3 => Ok(Columns::unnamed(3)),
        1 => refused("is not of the form row,col".into()),
        count => refused(format!(
            "has {count} fields; name them in a first line, with row and col among the names"
        )),
    }
}

/// Returns an error if the first of three columns without names may be an index, which some programs write
/// before the other columns.
fn check_no_index(rows: &[Row]) -> Result<(), String> {
    let counts_from = |start: usize| {
        let mut counted = rows.iter().zip(start..);
        counted.all(|(row, number)| row.vertex.place[0] == number as f64)
    };
    match counts_from(0) || counts_from(1) {
        false => Ok(()),
        true => {
            Err("has three columns without names, of which the first may be a running number: \
                     name them in a first line, as row,col,t0 or index,row,col"
                .into())
        }
    }
}

/// A line of a table.
struct Row {
    vertex: Vertex,
    /// Name of the line's curve.
    curve: Option<String>,
    is_closed: bool,
}

/// A reader of the lines below a header.
struct Rows<'a> {
    columns: &'a Columns,
    /// Whether lines begin with a name for which the header has no column, as in R's tables.
    is_named: Option<bool>,
    /// The decimal mark, once one has been found.
    decimal: Option<char>,
}

impl Rows<'_> {
    fn read(&mut self, mut record: Record) -> Result<Row, String> {
        let columns = self.columns;
        let count = columns.names.len();
        let is_named = record.is_named && record.fields.len() == count + 1;
        if *self.is_named.get_or_insert(is_named) && is_named {
            record.fields.remove(0);
        }
        if record.fields.len() != count {
            record = without_comment(record);
        }
        // Two numbers may be divided by any separator, which may differ from line to line.
        if record.fields.len() != count && count == 2 {
            let line = record.fields.join(" ");
            let loose = line.split(|c: char| c.is_whitespace() || c == ',' || c == ';');
            let loose: Vec<_> =
                loose.filter(|field| !field.is_empty()).map(str::to_owned).collect();
            if loose.len() == count {
                record.fields = loose;
            }
        }
        while record.fields.len() > count && record.fields.last().is_some_and(String::is_empty) {
            record.fields.pop();
        }
        let fields = &record.fields;
        if fields.len() != count {
            let (shown, found) = (fields.join(","), fields.len());
            return Err(format!(
                "`{}` has {found} fields, where there are {count} columns: {}",
                excerpt(&shown),
                excerpt(&columns.names.join(","))
            ));
        }
        let place = [
            self.number(&fields[columns.place[0]], columns.place[0])?,
            self.number(&fields[columns.place[1]], columns.place[1])?,
        ];
        let start = columns.start.map(|start| self.number(&fields[start], start)).transpose()?;
        let is_one =
            |closed: usize| matches!(fields[closed].as_str(), "1" | "true" | "TRUE" | "True");
        Ok(Row {
            vertex: Vertex { place, start: start.unwrap_or(0.0), number: record.line, value: None },
            curve: columns.curve.map(|curve| fields[curve].clone()),
            is_closed: columns.closed.is_some_and(is_one),
        })
    }

    /// Returns the number in a column.
    fn number(&mut self, field: &str, column: usize) -> Result<f64, String> {
        let named = Named("column", &self.columns.names[column]);
        let text = field.split('#').next().unwrap_or_default().trim();
        if text.is_empty() {
            return Err(format!("the field {named} is empty; give a number"));
        }
        let (number, decimal) =
            number(text).ok_or_else(|| format!("`{}` {named} is not a number", excerpt(text)))?;
        if let Some(decimal) = decimal
            && *self.decimal.get_or_insert(decimal) != decimal
        {
            return Err(format!(
                "`{}` {named} has a decimal {}, where numbers before it have a decimal {}; write all \
                 in one way",
                excerpt(text),
                mark(decimal),
                mark(self.decimal.unwrap_or('.'))
            ));
        }
        finite(number, text, &named)
    }
}

fn mark(decimal: char) -> &'static str {
    if decimal == ',' { "comma" } else { "point" }
}

/// Parses a number. Returns it with its decimal mark, if it has one.
fn number(text: &str) -> Option<(f64, Option<char>)> {
    if let Ok(number) = text.parse() {
        return Some((number, text.contains('.').then_some('.')));
    }
    let (whole, behind) = text.split_once(',')?;
    let is_whole = whole.trim_start_matches(['+', '-']).bytes().all(|byte| byte.is_ascii_digit());
    let number = format!("{whole}.{behind}").parse().ok()?;
    is_whole.then_some((number, Some(',')))
}

#[cfg(test)]
mod tests {
    use super::super::content::Coordinates;
    use super::super::frame::MapCoordinates;
    use super::*;

    type Place = ([f64; 2], f64);

    fn places(text: &str) -> Result<Vec<Vec<Place>>, String> {
        let curve = |curve: &FileCurve| curve.vertices.iter().map(|v| (v.place, v.start)).collect();
        read(text).map(|file| file.curves.iter().map(curve).collect())
    }

    fn starting_at_0(curves: &[&[[f64; 2]]]) -> Vec<Vec<Place>> {
        let curve = |curve: &&[[f64; 2]]| curve.iter().map(|&place| (place, 0.0)).collect();
        curves.iter().map(curve).collect()
    }

    /// Returns a table of rows, columns, start values and names of places, in one of the styles in which programs write
    /// tables, and its content. Returns `None` if fields would be ambiguous.
    fn table(separator: &str, index: Option<&str>, way: usize) -> Option<(String, Vec<Place>)> {
        let [decimal_comma, quotes_names, quotes_values, dos, ends, quarters] =
            std::array::from_fn(|bit| way >> bit & 1 == 1);
        let (blank, comma) = (separator == " ", separator.starts_with(','));
        if decimal_comma && comma && !quotes_values
            || separator == ", " && (quotes_names || quotes_values)
            || blank && index.is_some_and(|name| name != "\"\"")
        {
            return None;
        }
        let quoted = |text: String, is: bool| if is { format!("\"{text}\"") } else { text };
        let starts = ["t0", "start", "Time", "Initial", "start_value", "T0 (s)"];
        let start = if blank && !quotes_names { "t0" } else { starts[way % 6] };
        let mut columns = ["row", "col", start, "name_of_place"];
        columns.rotate_left(way % 4);
        columns[..2].rotate_left(way % 3 % 2);
        let number = |value: f64| {
            let text = value.to_string();
            quoted(if decimal_comma { text.replace('.', ",") } else { text }, quotes_values)
        };
        let names = columns.map(|name| quoted(name.into(), quotes_names));
        let mut lines = vec![index.map(str::to_owned).into_iter().chain(names).collect::<Vec<_>>()];
        let mut said = Vec::new();
        for line in 0..1 + way % 7 {
            let [row, col, start] = [3 * line, 5 * way, line * way]
                .map(|number| (number % 99) as f64 - 49.0)
                .map(|number| if quarters { 0.25 * number } else { number });
            let values = columns.map(|name| match name {
                "row" => number(row),
                "col" => number(col),
                "name_of_place" => number(7.0),
                _ => number(start),
            });
            lines.push(index.map(|_| line.to_string()).into_iter().chain(values).collect());
            said.push(([row, col], start));
        }
        let end = if dos { "\r\n" } else { "\n" };
        let lines: Vec<_> = lines.iter().map(|fields| fields.join(separator)).collect();
        Some((lines.join(end) + if ends { end } else { "" }, said))
    }

    /// Places and start values are found by the names of columns.
    #[test]
    fn tables_of_any_program_are_read() {
        for separator in [",", ";", "\t", " ", ", "] {
            for index in [None, Some(""), Some("\"\""), Some("Unnamed: 0")] {
                for (text, said) in (0..256).filter_map(|way| table(separator, index, way)) {
                    assert_eq!(places(&text), Ok(vec![said]), "{text}");
                    assert_eq!(read(&text).unwrap().unused, ["name_of_place"]);
                }
            }
        }
    }

    #[test]
    fn lines_without_names_are_read_leniently_and_errors_name_the_line() {
        let expected = starting_at_0(&[&[[1.0, 2.5], [3.0, -4.0]]]);
        for text in [
            "1,2.5\n3,-4\n",
            "row;col\n1; 2.5\n\n3;-4",
            "# curve\r\n1 2.5 # a\r\n3\t-4",
            "1;2,5\n3;-4\n",
            "1\t2,5\r\n3\t-4\r\n",
            "sep=;\n1;2,5\n3;-4",
            "1,2.5,\n3,-4,\n",
            "row,col\n1;2.5\n3 -4\n",
            "1,2.5 # a, b\n3,-4",
            "# row,col\n1,2.5\n3,-4\n",
            "# col row\n2.5 1\n-4 3\n",
        ] {
            assert_eq!(places(text), Ok(expected.clone()), "{text:?}");
        }
        for (text, line) in [
            ("1,2\n3\n", "line 2"),
            ("1,2\nx,y", "line 2"),
            ("1,2,3,4", "line 1"),
            ("row,col,x\n1,2\n", "line 2"),
            ("row,col\n1,2\nrow,col\n", "line 3"),
            ("row,col\n\n1,2\n\n1,nan\n", "line 5"),
            ("row,col,t0\n1,2,\n", "line 2"),
            ("row;col\n1,5;2\n1;2.5\n", "line 3"),
            ("row,col,name\n1,2,a\n1,2,\"a\n1,3,b\n", "line 3"),
            (",0,1\n0,5,2\n", "line 1"),
            ("\"1\",5,2\n", "line 1"),
        ] {
            let reason = places(text).unwrap_err();
            assert!(reason.contains(line), "{text:?}: {reason}");
        }
    }

    #[test]
    fn three_numbers_are_a_place_and_its_start_value_if_the_first_is_no_index() {
        let expected = vec![vec![([5.0, 2.0], 1.5), ([5.0, 10.0], 7.0)]];
        assert_eq!(places("5,2,1.5\n5,10,7\n"), Ok(expected.clone()));
        assert_eq!(places("# row,col,t0\n5,2,1.5\n5,10,7\n"), Ok(expected));
        for text in ["0,5,2\n1,5,10\n", "1 5 2\n2 5 10\n", "0,5,2"] {
            let reason = places(text).unwrap_err();
            assert!(reason.contains("running number"), "{reason}");
        }
        // A header decides, even one in a comment.
        assert_eq!(places("# row,col,t0\n0,5,2\n"), Ok(vec![vec![([0.0, 5.0], 2.0)]]));
    }

    #[test]
    fn headers_say_which_columns_count() {
        let expected = starting_at_0(&[&[[1.0, 2.5], [3.0, -4.0]]]);
        for text in [
            "col,row\n2.5,1\n-4,3\n",
            "COL Row\n2.5 1\n-4 3",
            "name,row,col,x\na,1,2.5,\n\n,3,-4,7",
            "x\ty\tcol\trow\n\t\t2.5\t1\n8\t9\t-4\t3",
            "row,column\n1,2.5\n3,-4\n",
            // R's write.table does not name the column of row names.
            "\"row\" \"col\"\n\"1\" 1 2.5\n\"2\" 3 -4\n",
            "\"row\",\"col\"\n\"a\",1,2.5\n\"b\",3,-4\n",
            "row,col,site\n1,2.5,\"a, #1\"\n3,-4,b #2\n",
            "row,col,note\n1,2.5,\"two\nlines\"\n3,-4,\n",
            "row;col;;\n1;2.5;;\n;;;\n3;-4;;\n",
        ] {
            assert_eq!(places(text), Ok(expected.clone()), "{text:?}");
        }
        let divided = starting_at_0(&[&[[1.0, 2.0], [3.0, 4.0]], &[[5.0, 6.0]]]);
        assert_eq!(places("curve,row,col\n0,1,2\n0,3,4\n1,5,6"), Ok(divided));
        let closed = read("closed,row,col\n1,1,2\n1,3,4").unwrap();
        assert_eq!(closed.curves[0].kind, CurveKind::Closed);
        for header in ["a,b", "row;lat", "row,x", "row", "V1,V2"] {
            let error = places(&format!("{header}\n1,2\n")).unwrap_err();
            assert!(error.contains("row and col"), "{error}");
        }
        for (header, kind) in [
            ("x,y", MapCoordinates::Surface),
            ("Easting;Northing", MapCoordinates::Projected),
            ("lat lon", MapCoordinates::Geographic),
        ] {
            let found = read(&format!("{header}\n1{}2\n", &header[header.len() / 2..][..0])).err();
            assert!(found.is_some(), "one field is too few");
            let separator = header.chars().find(|c| !c.is_alphanumeric()).unwrap();
            let found = read(&format!("{header}\n1{separator}2\n")).unwrap();
            assert_eq!(found.coordinates, Coordinates::Map(kind), "{header}");
        }
    }

    #[test]
    fn columns_that_could_change_distances_are_not_passed_over() {
        for (header, part) in [
            ("row,col,t0,time", "mean the same"),
            ("row,col,col", "mean the same"),
            ("x,y,lon", "x,y,lon"),
            ("row,col,weight", "weight"),
            ("row,col,start_date", "start_date"),
            ("row,col,Delay (s)", "Delay"),
        ] {
            let line = header.split(',').map(|_| "1").collect::<Vec<_>>().join(",");
            match places(&format!("{header}\n{line}\n")) {
                Err(error) => assert!(error.contains(part), "{error}"),
                Ok(_) => assert_eq!(header, "x,y,lon", "half a pair is a column like any other"),
            }
        }
        let error = places("x,y,lon,lat\n1,2,3,4\n").unwrap_err();
        assert!(error.contains("leave one pair out"), "{error}");
    }
}
