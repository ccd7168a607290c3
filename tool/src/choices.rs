//! Parses the library's choices as options, by their own names, with a line of help for each.

use std::fmt::Display;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use geosweep::Wavefront;

/// A choice that may be left open. The alias hides the `Option` from clap, which takes a plain one as an argument that
/// may be omitted.
pub type Choice<T> = Option<T>;

/// Additional names, each with the name that it stands for: the former name of circular fronts, and a common name
/// of the Vulkan engine.
const ALIASES: [(&str, &str); 2] = [("point", "circular"), ("gpu", "vulkan")];

/// Parses one of several values by the name that the library prints, or by its alias. A hyphen stands for a
/// space. Each value has a line of help, which may be empty.
pub fn one_of<T>(table: &[(T, &'static str)]) -> impl TypedValueParser<Value = T> + use<T>
where
    T: Clone + Display + Send + Sync + 'static,
{
    parser(table.iter().map(named).collect())
}

/// Parses one of several values, or `auto`, which leaves the choice open.
pub fn auto_or<T>(
    help: &'static str,
    table: &[(T, &'static str)],
) -> impl TypedValueParser<Value = Choice<T>> + use<T>
where
    T: Clone + Display + Send + Sync + 'static,
{
    let auto = ("auto".into(), help, None);
    let named = |entry| some(named(entry));
    parser(std::iter::once(auto).chain(table.iter().map(named)).collect())
}

/// Parses one of several values, or a given name that leaves the choice open.
pub fn one_of_or<T>(
    table: &[(T, &'static str)],
    (name, help): (&'static str, &'static str),
) -> impl TypedValueParser<Value = Choice<T>> + use<T>
where
    T: Clone + Display + Send + Sync + 'static,
{
    let open = (name.into(), help, None);
    let named = |entry| some(named(entry));
    parser(table.iter().map(named).chain([open]).collect())
}

/// The name of a value, its line of help, and the value.
type Entry<T> = (String, &'static str, T);

fn named<T: Clone + Display>((value, help): &(T, &'static str)) -> Entry<T> {
    (value.to_string().replace(' ', "-"), help, value.clone())
}

fn some<T>((name, help, value): Entry<T>) -> Entry<Choice<T>> {
    (name, help, Some(value))
}

fn parser<T>(entries: Vec<Entry<T>>) -> impl TypedValueParser<Value = T>
where
    T: Clone + Send + Sync + 'static,
{
    let possible = |(name, help, _): &Entry<T>| {
        let aliases = ALIASES.iter().filter(|(_, meant)| meant == name).map(|(alias, _)| alias);
        let value = PossibleValue::new(name.clone()).aliases(aliases);
        if help.is_empty() { value } else { value.help(*help) }
    };
    let names = PossibleValuesParser::new(entries.iter().map(possible));
    names.map(move |name| {
        let meant = ALIASES.iter().find(|(alias, _)| *alias == name).map(|(_, meant)| *meant);
        let entry = entries.iter().find(|entry| entry.0 == meant.unwrap_or(&name));
        entry.expect("only these names are possible").2.clone()
    })
}

/// Returns the names of all wavefronts, for help texts.
pub fn wavefront_names() -> String {
    Wavefront::ALL.map(Wavefront::name).join(", ")
}

#[cfg(test)]
mod tests {
    use std::ffi::OsStr;

    use geosweep::vulkan::PairwiseSchedule;

    use super::*;

    #[test]
    fn names_are_the_librarys_and_helps_are_ours() {
        let command = clap::Command::new("test");
        let table = PairwiseSchedule::ALL.map(|schedule| (schedule, "where maps lie"));
        let parser = auto_or("where they fit", &table);
        let parse = |text| parser.parse_ref(&command, None, OsStr::new(text)).ok();
        assert_eq!(parse("auto"), Some(None));
        assert_eq!(parse("shared-memory"), Some(Some(PairwiseSchedule::SharedMemory)));
        assert_eq!(parse("layers"), None);
        let possible: Vec<_> = parser.possible_values().unwrap().collect();
        let names: Vec<_> = possible.iter().map(PossibleValue::get_name).collect();
        assert_eq!(names, ["auto", "shared-memory", "images"]);
        assert!(possible.iter().all(|value| value.get_help().is_some()));
    }
}
