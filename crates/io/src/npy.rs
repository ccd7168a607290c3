//! Reads and writes NumPy's `.npy` arrays, versions 1 to 3 of the format.
//!
//! The header is a Python dictionary of exactly three entries. Searching for these three keys suffices. The search does
//! not recurse, and the memory for the header is in proportion to the bytes that the file has.

use std::io::{self, Read, Write};

use half::f16;

use super::limits::check_memory;
use geosweep_surface::shown::excerpt;

const MAGIC: &[u8] = b"\x93NUMPY";

/// An array of numbers. It is in C order, whatever the order of the file.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct NpyArray {
    pub shape: Vec<usize>,
    pub dtype: Dtype,
    pub values: Vec<f64>,
}

/// The type of an array's elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Dtype {
    /// NumPy's letter: `b`, `i`, `u` or `f`.
    pub kind: u8,
    pub bytes: usize,
    big_endian: bool,
}

/// The description of an array at the beginning of its file.
pub(super) struct Header {
    pub dtype: Dtype,
    pub fortran_order: bool,
    pub shape: Vec<usize>,
}

impl NpyArray {
    /// Decodes a whole file.
    pub fn decode(bytes: &[u8]) -> Result<Self, String> {
        let mut data = bytes;
        let header = Header::read(&mut data)?;
        let data = &data[..header.check_size(data.len() as u64)?];
        let Header { dtype, fortran_order, shape } = header;
        // Reordering needs memory for a second copy.
        let copies = if fortran_order { 2 } else { 1 };
        check_memory::<f64>(copies * (data.len() / dtype.bytes))?;
        let values = dtype.decode(data);
        let values = if fortran_order { c_order(&shape, &values) } else { values };
        Ok(Self { shape, dtype, values })
    }
}

/// Maximum number of axes of a shape in a message.
const MOST_AXES: usize = 8;

/// Formats a shape as NumPy does, for example `(3, 4)`.
pub(super) fn shape_text(shape: &[usize]) -> String {
    let sizes: Vec<_> = shape.iter().take(MOST_AXES).map(usize::to_string).collect();
    let more = if shape.len() > MOST_AXES { ", ..." } else { "" };
    format!("({}{more})", sizes.join(", "))
}

impl Header {
    /// Reads a file up to its data.
    pub fn read(reader: &mut impl Read) -> Result<Self, String> {
        let mut magic = [0; MAGIC.len()];
        if reader.read_exact(&mut magic).is_err() || magic != MAGIC {
            return Err("is no NumPy .npy file: its first bytes differ".into());
        }
        let cut = |_| "the .npy header is cut short".to_string();
        let [major, _] = take(reader).map_err(cut)?;
        let length = match major {
            1 => take(reader).map(|bytes| u16::from_le_bytes(bytes).into()),
            2 | 3 => take(reader).map(u32::from_le_bytes),
            major => return Err(format!("version {major} of the .npy format is not known")),
        };
        let length = u64::from(length.map_err(cut)?);
        let mut text = Vec::new();
        reader.take(length).read_to_end(&mut text).map_err(cut)?;
        if (text.len() as u64) < length {
            return Err("the .npy header is cut short".into());
        }
        Self::parse(std::str::from_utf8(&text).map_err(|_| "the .npy header is no text")?)
    }

    /// Returns the number of bytes of the data, or an error if that is more than `there`, the number of bytes left in
    /// the file.
    pub fn check_size(&self, there: u64) -> Result<usize, String> {
        let count = self.shape.iter().try_fold(1usize, |count, &n| count.checked_mul(n));
        let needed = count.and_then(|count| count.checked_mul(self.dtype.bytes));
        needed.filter(|&needed| needed as u64 <= there).ok_or_else(|| {
            let needed = needed.map_or("too many".into(), |needed| needed.to_string());
            format!(
                "the data is cut short: shape {} of {}-byte numbers needs {needed} bytes, {there} are there",
                shape_text(&self.shape),
                self.dtype.bytes,
            )
        })
    }

    fn parse(text: &str) -> Result<Self, String> {
        let value = |key: &str| {
            let quoted = [format!("'{key}'"), format!("\"{key}\"")];
            quoted
                .iter()
                .find_map(|quoted| text.split_once(quoted.as_str()))
                .and_then(|(_, rest)| rest.trim_start().strip_prefix(':'))
                .map(str::trim_start)
                .ok_or(format!("the .npy header has no entry '{key}'"))
        };
        let fortran_order = match value("fortran_order")? {
            text if text.starts_with("False") => false,
            text if text.starts_with("True") => true,
            _ => return Err("the .npy header's 'fortran_order' is neither True nor False".into()),
        };
        Ok(Self {
            dtype: Dtype::parse(value("descr")?)?,
            fortran_order,
            shape: parse_shape(value("shape")?)?,
        })
    }
}

fn take<const N: usize>(reader: &mut impl Read) -> io::Result<[u8; N]> {
    let mut bytes = [0; N];
    reader.read_exact(&mut bytes).map(|()| bytes)
}

fn parse_shape(text: &str) -> Result<Vec<usize>, String> {
    let inside = text.strip_prefix('(').and_then(|text| text.split_once(')'));
    let (sizes, _) = inside.ok_or("the .npy header's 'shape' is no tuple")?;
    let sizes = sizes.trim().trim_end_matches(',');
    if sizes.is_empty() {
        return Ok(Vec::new());
    }
    let size = |text: &str| text.trim().parse();
    sizes.split(',').map(size).collect::<Result<_, _>>().map_err(|_| {
        let sizes = excerpt(sizes);
        format!(
            "the .npy header's 'shape' ({sizes}) is not a list of sizes that this machine can address"
        )
    })
}

impl Dtype {
    /// Parses the quoted type string, such as `'<f8'`, with which `text` begins.
    fn parse(text: &str) -> Result<Self, String> {
        let quote = text.chars().next().filter(|c| matches!(c, '\'' | '"'));
        let inside = quote.and_then(|quote| text[1..].split_once(quote));
        let unknown = |name: &str| {
            let name = excerpt(name);
            format!(
                "elements of type {name} are not supported; \
                 use booleans, integers, float16, float32 or float64, e.g. array.astype('float32')"
            )
        };
        let (name, _) = inside.ok_or_else(|| unknown("structured"))?;
        let (order, kind, bytes) = match *name.as_bytes() {
            [order, kind, bytes] => (order, kind, bytes.wrapping_sub(b'0') as usize),
            _ => return Err(unknown(name)),
        };
        let known = match kind {
            b'b' => bytes == 1,
            b'i' | b'u' => matches!(bytes, 1 | 2 | 4 | 8),
            b'f' => matches!(bytes, 2 | 4 | 8),
            _ => false,
        };
        if !known || !b"<>|=".contains(&order) {
            return Err(unknown(name));
        }
        Ok(Self { kind, bytes, big_endian: order == b'>' })
    }

    /// Decodes bytes to numbers.
    pub fn decode(self, data: &[u8]) -> Vec<f64> {
        macro_rules! decode {
            ($type:ty) => {{
                let from =
                    if self.big_endian { <$type>::from_be_bytes } else { <$type>::from_le_bytes };
                let (numbers, _) = data.as_chunks();
                numbers.iter().map(|bytes| from(*bytes) as f64).collect()
            }};
        }
        match (self.kind, self.bytes) {
            (b'f', 2) => {
                let from = if self.big_endian { f16::from_be_bytes } else { f16::from_le_bytes };
                data.as_chunks().0.iter().map(|bytes| from(*bytes).to_f64()).collect()
            }
            (b'f', 4) => decode!(f32),
            (b'f', _) => decode!(f64),
            (b'i', 1) => decode!(i8),
            (b'i', 2) => decode!(i16),
            (b'i', 4) => decode!(i32),
            (b'i', _) => decode!(i64),
            (_, 1) => decode!(u8),
            (_, 2) => decode!(u16),
            (_, 4) => decode!(u32),
            _ => decode!(u64),
        }
    }
}

/// Converts an array from Fortran order, in which the first index runs fastest, to C order, in which the last one does.
fn c_order(shape: &[usize], values: &[f64]) -> Vec<f64> {
    let fortran_index = |mut index: usize| {
        // Division of the C index by the sizes, from the last axis to the first, leaves the index along each axis as
        // remainder. The stride of an axis in Fortran order is the product of the sizes before it.
        let mut stride = values.len();
        shape.iter().rev().fold(0, |sum, &size| {
            let along = index % size;
            index /= size;
            stride /= size;
            sum + along * stride
        })
    };
    (0..values.len()).map(|index| values[fortran_index(index)]).collect()
}

/// Writes an array in C order, in the machine's byte order.
///
/// # Errors
/// The errors of the writer.
pub fn write_npy<T: NpyElement>(
    writer: &mut impl Write,
    shape: &[usize],
    values: &[T],
) -> io::Result<()> {
    debug_assert_eq!(shape.iter().product::<usize>(), values.len());
    writer.write_all(&header(T::DESCR, shape))?;
    writer.write_all(bytemuck::cast_slice(values))
}

/// Returns the header of an array in C order.
pub(super) fn header(descr: &str, shape: &[usize]) -> Vec<u8> {
    let shape = match *shape {
        [size] => format!("({size},)"),
        _ => shape_text(shape),
    };
    let dict = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}");
    // NumPy aligns the data to 64 bytes.
    let unpadded = MAGIC.len() + 4 + dict.len() + 1;
    let padding = " ".repeat(unpadded.next_multiple_of(64) - unpadded);
    let text = format!("{dict}{padding}\n");
    let length = u16::try_from(text.len()).expect("a few sizes are short");
    [MAGIC, &[1, 0], &length.to_le_bytes(), text.as_bytes()].concat()
}

/// A type of numbers that [`write_npy`] supports.
pub trait NpyElement: bytemuck::Pod {
    /// NumPy's type string.
    const DESCR: &'static str;
}

impl NpyElement for f32 {
    const DESCR: &'static str = if cfg!(target_endian = "little") { "<f4" } else { ">f4" };
}

impl NpyElement for i32 {
    const DESCR: &'static str = if cfg!(target_endian = "little") { "<i4" } else { ">i4" };
}

impl NpyElement for i64 {
    const DESCR: &'static str = if cfg!(target_endian = "little") { "<i8" } else { ">i8" };
}

impl NpyElement for f64 {
    const DESCR: &'static str = if cfg!(target_endian = "little") { "<f8" } else { ">f8" };
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(header: &str, data: &[u8]) -> Vec<u8> {
        let mut bytes = [MAGIC, &[1, 0], &(header.len() as u16).to_le_bytes()].concat();
        bytes.extend_from_slice(header.as_bytes());
        bytes.extend_from_slice(data);
        bytes
    }

    #[test]
    fn fortran_order_and_big_endian_are_understood() {
        let header = r#"{"shape": (2, 3), "fortran_order": True, "descr": ">i2"}"#;
        // The columns come one after the other.
        let data: Vec<u8> =
            [11i16, 21, 12, 22, 13, -23].iter().flat_map(|v| v.to_be_bytes()).collect();
        let array = NpyArray::decode(&file(header, &data)).unwrap();
        assert_eq!(array.values, [11.0, 12.0, 13.0, 21.0, 22.0, -23.0]);
    }

    #[test]
    fn headers_that_lie_are_refused() {
        let refused = |header: &str| NpyArray::decode(&file(header, &[0; 64])).unwrap_err();
        let descr = |descr: &str| {
            refused(&format!("{{'descr': {descr}, 'fortran_order': False, 'shape': (1,)}}"))
        };
        assert!(descr("'|O'").contains("|O"));
        assert!(descr("[('a', '<f8')]").contains("not supported"));
        assert!(descr("'<f3'").contains("<f3"));
        assert!(descr("'<f8").contains("not supported"));
        let shape = |shape: &str| {
            refused(&format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}}}"))
        };
        assert!(shape("(4294967296, 4294967296, 4294967296)").contains("cut short"));
        assert!(shape("(3, 3)").contains("needs 72 bytes, 64 are there"));
        assert!(shape("(-1,)").contains("shape"));
        assert!(shape("3").contains("shape"));
        assert!(refused("{}").contains("fortran_order"));
    }
}
