//! Reads the container of a TIFF file: header, directories (IFDs) and the values of their fields.
//!
//! The decoder of the crate `tiff` (0.11.3) refuses 18 of the 48 variants in `tests/maps/gdal`: signed numbers where 0
//! is white, numbers of 9 to 31 bits, and a deflate stream that GDAL reads. It inverts other numbers where 0 is white.
//! A file whose first picture it refuses cannot be opened at all. So files are decoded here, and only types of that
//! crate are used, for the values of fields. This module allocates no more bytes than the file has.

use std::collections::HashSet;

use ::tiff::tags::Tag;

/// A TIFF file in memory.
#[derive(Clone, Copy)]
pub struct File<'a> {
    bytes: &'a [u8],
    big_endian: bool,
    /// Whether offsets have 64 bits (BigTIFF).
    wide: bool,
}

/// A directory: one picture of the file, with its fields.
pub struct Directory<'a> {
    file: File<'a>,
    fields: Vec<Field>,
}

/// A field of a directory. Its values lie at the offset `at`.
struct Field {
    tag: u16,
    kind: u16,
    count: u64,
    at: usize,
}

const CUT_SHORT: &str = "is not a usable TIFF file: a directory is cut short or damaged";

impl<'a> File<'a> {
    /// Reads the header. Returns the file and the offset of its first directory.
    pub fn open(bytes: &'a [u8]) -> Result<(Self, u64), String> {
        let no_tiff = || "is not a usable TIFF file: its first bytes differ".to_string();
        let big_endian = match bytes.get(..2) {
            Some(b"II") => false,
            Some(b"MM") => true,
            _ => return Err(no_tiff()),
        };
        let file = Self { bytes, big_endian, wide: false };
        match file.unsigned(2, 2) {
            Some(42) => Ok((file, file.unsigned(4, 4).ok_or_else(no_tiff)?)),
            // BigTIFF: the size of offsets, 8, and a zero come before the offset.
            Some(43) if file.unsigned(4, 4) == Some(file.header_of_big()) => {
                Ok((Self { wide: true, ..file }, file.unsigned(8, 8).ok_or_else(no_tiff)?))
            }
            _ => Err(no_tiff()),
        }
    }

    fn header_of_big(&self) -> u64 {
        if self.big_endian { 8 << 16 } else { 8 }
    }

    /// Returns whether numbers are stored with their most significant byte first.
    pub fn is_big_endian(&self) -> bool {
        self.big_endian
    }

    /// Returns a part of the file, if it exists.
    pub fn slice(&self, offset: u64, length: u64) -> Option<&'a [u8]> {
        let start = usize::try_from(offset).ok()?;
        let end = start.checked_add(usize::try_from(length).ok()?)?;
        self.bytes.get(start..end)
    }

    /// Returns all directories of the chain that begins at an offset.
    pub fn directories(self, first: u64) -> Result<Vec<Directory<'a>>, String> {
        let (mut directories, mut next) = (Vec::new(), first);
        let mut seen = HashSet::new();
        while next != 0 {
            if !seen.insert(next) {
                return Err("is not a usable TIFF file: its directories form a circle".into());
            }
            let (directory, after) = self.directory(next).ok_or(CUT_SHORT)?;
            directories.push(directory);
            next = after;
        }
        Ok(directories)
    }

    /// Returns the directory at an offset, and the offset of the next one.
    fn directory(self, offset: u64) -> Option<(Directory<'a>, u64)> {
        let (count_size, offset_size) = if self.wide { (8, 8) } else { (2, 4) };
        let field_size = 4 + 2 * offset_size;
        let start = usize::try_from(offset).ok()?;
        let count = usize::try_from(self.unsigned(start, count_size)?).ok()?;
        let fields_at = start.checked_add(count_size)?;
        let end = fields_at.checked_add(count.checked_mul(field_size)?)?;
        let next = self.unsigned(end, offset_size)?;
        let fields = (0..count).map(|index| self.field(fields_at + index * field_size));
        let fields = fields.collect::<Option<_>>()?;
        Some((Directory { file: self, fields }, next))
    }

    fn field(&self, at: usize) -> Option<Field> {
        let offset_size = if self.wide { 8 } else { 4 };
        let (tag, kind) = (self.unsigned(at, 2)? as u16, self.unsigned(at + 2, 2)? as u16);
        let count = self.unsigned(at + 4, offset_size)?;
        let value = at + 4 + offset_size;
        let size = count.checked_mul(type_size(kind) as u64);
        let at = match size {
            Some(size) if size <= offset_size as u64 => value,
            // The offset is too large for this machine. This is an error only if the value is requested.
            _ => usize::try_from(self.unsigned(value, offset_size)?).unwrap_or(usize::MAX),
        };
        Some(Field { tag, kind, count, at })
    }

    fn unsigned(&self, at: usize, size: usize) -> Option<u64> {
        let bytes = self.bytes.get(at..at.checked_add(size)?)?;
        let shift = |number: u64, byte: &u8| number << 8 | u64::from(*byte);
        Some(match self.big_endian {
            true => bytes.iter().fold(0, shift),
            false => bytes.iter().rev().fold(0, shift),
        })
    }
}

/// Returns the number of bytes of a number of a field's type, or 0 for types that TIFF does not have.
fn type_size(kind: u16) -> usize {
    match kind {
        1 | 2 | 6 | 7 => 1,
        3 | 8 => 2,
        4 | 9 | 11 | 13 => 4,
        5 | 10 | 12 | 16..=18 => 8,
        _ => 0,
    }
}

impl<'a> Directory<'a> {
    /// Returns the values of a field as unsigned integers, or `None` if the directory lacks it.
    pub fn integers(&self, tag: Tag) -> Result<Option<Vec<u64>>, String> {
        self.values(tag, |file, kind, at, size| match kind {
            1 | 3 | 4 | 7 | 13 | 16 | 18 => file.unsigned(at, size),
            _ => None,
        })
    }

    /// Returns the first value of a field as an unsigned integer.
    pub fn integer(&self, tag: Tag) -> Result<Option<u64>, String> {
        Ok(self.integers(tag)?.and_then(|values| values.first().copied()))
    }

    /// Returns the values of a field as real numbers.
    pub fn reals(&self, tag: Tag) -> Result<Option<Vec<f64>>, String> {
        self.values(tag, |file, kind, at, size| {
            let bits = file.unsigned(at, size)?;
            match kind {
                11 => Some(f64::from(f32::from_bits(bits as u32))),
                12 => Some(f64::from_bits(bits)),
                1 | 3 | 4 | 13 | 16 | 18 => Some(bits as f64),
                _ => None,
            }
        })
    }

    /// Returns the text of a field up to its end mark.
    pub fn text(&self, tag: Tag) -> Result<Option<String>, String> {
        let Some(bytes) = self.bytes(tag)? else { return Ok(None) };
        let end = bytes.iter().position(|&byte| byte == 0).unwrap_or(bytes.len());
        Ok(Some(String::from_utf8_lossy(&bytes[..end]).into_owned()))
    }

    /// Returns the bytes of a field of text or of bytes.
    pub fn bytes(&self, tag: Tag) -> Result<Option<&'a [u8]>, String> {
        let Some(field) = self.find(tag) else { return Ok(None) };
        let bytes = match field.kind {
            1 | 2 | 7 => self.file.slice(field.at as u64, field.count),
            _ => None,
        };
        bytes.map(Some).ok_or_else(|| damaged(tag))
    }

    pub fn has(&self, tag: Tag) -> bool {
        self.find(tag).is_some()
    }

    fn find(&self, tag: Tag) -> Option<&Field> {
        self.fields.iter().find(|field| field.tag == tag.to_u16())
    }

    fn values<T>(
        &self,
        tag: Tag,
        value: impl Fn(&File, u16, usize, usize) -> Option<T>,
    ) -> Result<Option<Vec<T>>, String> {
        let Some(&Field { kind, count, at, .. }) = self.find(tag) else { return Ok(None) };
        let size = type_size(kind);
        let read = || {
            // This checks that the file contains all bytes of the field before memory is allocated for them.
            self.file.slice(at as u64, count.checked_mul(size as u64)?).filter(|_| size > 0)?;
            (0..count as usize)
                .map(|index| value(&self.file, kind, at + index * size, size))
                .collect::<Option<Vec<T>>>()
        };
        read().map(Some).ok_or_else(|| damaged(tag))
    }
}

fn damaged(tag: Tag) -> String {
    format!("is not a usable TIFF file: the field {tag:?} is cut short or of a wrong type")
}
