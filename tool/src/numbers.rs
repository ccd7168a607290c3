//! Numbers in one argument.

/// A list of numbers.
#[derive(Clone, Debug)]
pub struct Numbers(pub Vec<f64>);

impl Numbers {
    pub fn parse(text: &str) -> Result<Self, String> {
        numbers(text).map(Self)
    }
}

/// Finite numbers with commas between them.
pub fn numbers(text: &str) -> Result<Vec<f64>, String> {
    let number = |text: &str| match text.trim().parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(format!("`{text}` is not a finite number")),
    };
    text.split(',').map(number).collect()
}

/// A place on the grid, which may be fractional.
pub fn place(text: &str) -> Result<[f64; 2], String> {
    let place = numbers(text)?.try_into();
    place.map_err(|_| "a place is a row and a column: R,C".into())
}
