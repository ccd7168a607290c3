//! Decodes bytes to text, in the encodings that spreadsheets write.

/// Decodes UTF-8, UTF-16 with a byte order mark, or otherwise an 8-bit code page. Only names of columns and places
/// contain characters beyond ASCII. Such characters may be decoded wrongly, but different characters stay different.
pub(super) fn decode(bytes: Vec<u8>) -> Result<String, String> {
    let utf16 = |bytes: &[u8], from: fn([u8; 2]) -> u16| {
        let units = bytes.as_chunks().0.iter().map(|unit| from(*unit));
        char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect()
    };
    let text = match &bytes[..] {
        [0xff, 0xfe, rest @ ..] => utf16(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => utf16(rest, u16::from_be_bytes),
        _ => String::from_utf8(bytes).unwrap_or_else(|error| {
            error.as_bytes().iter().map(|&byte| char::from(byte)).collect()
        }),
    };
    // Text contains no zero byte. Binary files nearly always do.
    if text.contains('\0') {
        return Err("is no text; give lines of row,col, GeoJSON or an .npy".into());
    }
    Ok(text.strip_prefix('\u{feff}').map_or(text.clone(), str::to_owned))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn encodings_of_a_text_are_read_as_the_same(text in "[a-zäöü,;\n0-9]{1,40}") {
            let utf16 = |mark: &[u8], to: fn(u16) -> [u8; 2]| {
                mark.iter().copied().chain(text.encode_utf16().flat_map(to)).collect::<Vec<_>>()
            };
            let marked = format!("\u{feff}{text}").into_bytes();
            let latin: Vec<u8> = text.chars().map(|c| c as u32 as u8).collect();
            for bytes in [
                text.clone().into_bytes(),
                marked,
                latin,
                utf16(&[0xff, 0xfe], u16::to_le_bytes),
                utf16(&[0xfe, 0xff], u16::to_be_bytes),
            ] {
                prop_assert_eq!(decode(bytes), Ok(text.clone()));
            }
        }
    }

    #[test]
    fn bytes_that_are_no_text_are_refused() {
        assert!(decode(vec![0x50, 0x4b, 3, 4, 0, 0]).unwrap_err().contains("no text"));
    }
}
