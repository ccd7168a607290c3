//! Names of options in the tool and in reports.

use crate::shown::excerpt;

/// Error for a text that is not the name of an option.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no {what} is called `{}`; there are {}", excerpt(text), names.join(", "))]
pub struct UnknownName {
    what: &'static str,
    text: String,
    names: Vec<&'static str>,
}

/// Finds the option with the name `text`, ignoring white space around the name.
pub fn by_name<T: Copy>(
    what: &'static str,
    text: &str,
    choices: &[T],
    name: impl Fn(T) -> &'static str,
) -> Result<T, UnknownName> {
    let text = text.trim();
    let found = choices.iter().find(|&&choice| name(choice) == text).copied();
    found.ok_or_else(|| {
        let names = choices.iter().map(|&choice| name(choice)).collect();
        UnknownName { what, text: text.to_owned(), names }
    })
}
