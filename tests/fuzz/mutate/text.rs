//! Text: its numbers, its lines and the other characters.

use crate::bodies::dice::Dice;

const WORDS: &str = "0 -1 4 4.5 NaN inf -1e300 1e-320 4294967296 18446744073709551615 18446744073709551616 \
                     99999999999999999999999999999999 row col curve closed null [[[[[[[[ \u{feff} é";
const CHARACTERS: &[u8] = b",;\t \n\r#'\"{}[]():\0\xff\\";

pub fn mutate(bytes: &mut Vec<u8>, dice: &mut Dice) {
    if bytes.is_empty() {
        return;
    }
    let place = dice.below(bytes.len());
    let word = dice.one_of(&WORDS.split(' ').collect::<Vec<_>>()).bytes();
    match dice.below(6) {
        0 | 1 => {
            // Replaces the next number.
            let is_digit = |byte: &u8| byte.is_ascii_digit() || b".-+eE".contains(byte);
            let Some(start) = bytes[place..].iter().position(u8::is_ascii_digit) else { return };
            let start = place + start;
            let length = bytes[start..].iter().take_while(|byte| is_digit(byte)).count();
            bytes.splice(start..start + length, word);
        }
        2 => drop(bytes.splice(place..place, word)),
        3 => bytes.insert(place, dice.one_of(CHARACTERS)),
        4 => {
            let end = bytes[place..].iter().position(|&byte| byte == b'\n');
            let end = end.map_or(bytes.len(), |end| place + end + 1);
            drop(bytes.drain(place..end));
        }
        _ => {
            let end = (place + 1 + dice.below(64)).min(bytes.len());
            let part = bytes[place..end].repeat(dice.one_of(&[1, 2, 50]));
            bytes.splice(place..place, part);
        }
    }
}
