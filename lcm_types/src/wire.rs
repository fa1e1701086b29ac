//! Values to bytes and back: big-endian, strings with length and NUL, arrays without padding.
//!
//! The generated types and [`value`](crate::value) stand on this; programs use
//! [`Message`](crate::Message).

use crate::Error;

/// Rows that take no byte on the wire (`x[n][m]` with m = 0) and yet are allowed in one message.
/// [-]
pub const MAX_EMPTY_ROWS: usize = 4096;

/// Something with a place in a message.
pub trait Wire: Sized {
    /// Fewest bytes a value takes. \[B\]
    const MIN_SIZE: usize;

    /// Appends the value.
    ///
    /// # Errors
    /// [`Error::Count`] and [`Error::Nul`].
    fn write(&self, w: &mut Writer<'_>) -> Result<(), Error>;

    /// Takes the value off the front.
    ///
    /// # Errors
    /// Any of the decoding variants of [`Error`] but fingerprint, trailing bytes and CRC.
    fn read(r: &mut Reader<'_>) -> Result<Self, Error>;
}

/// Appends values to a buffer.
#[derive(Debug)]
pub struct Writer<'a> {
    out: &'a mut Vec<u8>,
    /// Full name of the field being written, for errors.
    pub field: &'static str,
}

impl<'a> Writer<'a> {
    /// Appends to `out`.
    pub fn new(out: &'a mut Vec<u8>) -> Self {
        Self { out, field: "" }
    }

    /// Appends bytes as they are.
    pub fn bytes(&mut self, bytes: &[u8]) {
        self.out.extend_from_slice(bytes);
    }

    /// Appends a string: its length with the NUL, its bytes, the NUL.
    ///
    /// # Errors
    /// [`Error::Nul`] for a NUL inside, [`Error::Count`] beyond 2 GiB.
    pub fn string(&mut self, text: &str) -> Result<(), Error> {
        if text.as_bytes().contains(&0) {
            return Err(Error::Nul { field: self.field.into(), offset: self.out.len() });
        }
        let Ok(length) = i32::try_from(text.len() + 1) else {
            let expected = i64::from(i32::MAX);
            return Err(Error::Count { field: self.field.into(), found: text.len(), expected });
        };
        self.bytes(&length.to_be_bytes());
        self.bytes(text.as_bytes());
        self.bytes(&[0]);
        Ok(())
    }

    /// Checks the number of elements of an array against its length field.
    ///
    /// # Errors
    /// [`Error::Count`] if they differ.
    pub fn count(&self, expected: i64, found: usize) -> Result<(), Error> {
        if i64::try_from(found) == Ok(expected) {
            return Ok(());
        }
        Err(Error::Count { field: self.field.into(), found, expected })
    }
}

/// Takes values off the front of a message.
#[derive(Debug, Clone)]
pub struct Reader<'a> {
    all: &'a [u8],
    offset: usize,
    empty_rows: usize,
    /// Full name of the field being read, for errors.
    pub field: &'static str,
}

impl<'a> Reader<'a> {
    /// Reads `bytes` from the start; `field` names what comes first.
    #[must_use]
    pub fn new(bytes: &'a [u8], field: &'static str) -> Self {
        Self { all: bytes, offset: 0, empty_rows: MAX_EMPTY_ROWS, field }
    }

    /// Bytes not yet taken. \[B\]
    #[must_use]
    pub fn left(&self) -> usize {
        self.all.len() - self.offset
    }

    /// Takes `count` bytes.
    ///
    /// # Errors
    /// [`Error::Short`].
    pub fn bytes(&mut self, count: usize) -> Result<&'a [u8], Error> {
        let end = self.offset.checked_add(count);
        let Some(taken) = end.and_then(|end| self.all.get(self.offset..end)) else {
            return Err(self.short(count));
        };
        self.offset += count;
        Ok(taken)
    }

    fn short(&self, needed: usize) -> Error {
        let (field, left) = (self.field.into(), self.left());
        Error::Short { field, offset: self.offset, needed, left }
    }

    /// Takes `N` bytes.
    ///
    /// # Errors
    /// [`Error::Short`].
    pub fn array<const N: usize>(&mut self) -> Result<[u8; N], Error> {
        let first = self.all.get(self.offset..).and_then(|rest| rest.first_chunk::<N>());
        let taken = *first.ok_or_else(|| self.short(N))?;
        self.offset += N;
        Ok(taken)
    }

    /// Takes the fingerprint a message begins with.
    ///
    /// # Errors
    /// [`Error::Short`].
    pub fn fingerprint(&mut self) -> Result<u64, Error> {
        self.array().map(u64::from_be_bytes)
    }

    /// Takes a string.
    ///
    /// # Errors
    /// [`Error::Short`], [`Error::Length`], [`Error::Nul`], [`Error::Utf8`].
    pub fn string(&mut self) -> Result<&'a str, Error> {
        let length = i32::from_be_bytes(self.array()?);
        let limit = self.left();
        let usable = usize::try_from(length).ok().filter(|n| (1..=limit).contains(n));
        let Some(size) = usable else {
            return Err(self.length(i64::from(length), limit));
        };
        let bytes = self.bytes(size)?;
        let field = || self.field.into();
        match bytes.split_last() {
            Some((0, text)) if !text.contains(&0) => std::str::from_utf8(text)
                .map_err(|_| Error::Utf8 { field: field(), offset: self.offset }),
            _ => Err(Error::Nul { field: field(), offset: self.offset }),
        }
    }

    fn length(&self, found: i64, limit: usize) -> Error {
        Error::Length { field: self.field.into(), offset: self.offset, found, limit }
    }

    /// Checks the number of rows of an array, of at least `row_size` bytes each, against the bytes
    /// left: what it returns is safe to reserve memory for.
    ///
    /// # Errors
    /// [`Error::Length`].
    pub fn row_count(&mut self, count: i64, row_size: usize) -> Result<usize, Error> {
        let limit = self.left().checked_div(row_size).unwrap_or(self.empty_rows);
        let usable = usize::try_from(count).ok().filter(|n| *n <= limit);
        let Some(rows) = usable else { return Err(self.length(count, limit)) };
        if row_size == 0 {
            self.empty_rows -= rows;
        }
        Ok(rows)
    }

    /// Takes an array of `count` rows, of at least `row_size` bytes each.
    ///
    /// # Errors
    /// [`Error::Length`], and what `row` returns.
    pub fn rows<T>(
        &mut self,
        count: i64,
        row_size: usize,
        mut row: impl FnMut(&mut Self) -> Result<T, Error>,
    ) -> Result<Vec<T>, Error> {
        let rows = self.row_count(count, row_size)?;
        let mut out = Vec::with_capacity(rows);
        for _ in 0..rows {
            out.push(row(self)?);
        }
        Ok(out)
    }

    /// Takes an array of `N` rows of varying length.
    ///
    /// # Errors
    /// What `row` returns.
    pub fn fixed_rows<T, const N: usize>(
        &mut self,
        mut row: impl FnMut(&mut Self) -> Result<T, Error>,
    ) -> Result<[T; N], Error>
    where
        [T; N]: Default,
    {
        let mut out = <[T; N]>::default();
        for place in &mut out {
            *place = row(self)?;
        }
        Ok(out)
    }
}

macro_rules! numbers {
    ($($number:ty),*) => {$(
        impl Wire for $number {
            const MIN_SIZE: usize = size_of::<Self>();

            fn write(&self, w: &mut Writer<'_>) -> Result<(), Error> {
                w.bytes(&self.to_be_bytes());
                Ok(())
            }

            fn read(r: &mut Reader<'_>) -> Result<Self, Error> {
                r.array().map(Self::from_be_bytes)
            }
        }
    )*};
}
numbers!(i8, i16, i32, i64, u8, f32, f64);

impl Wire for bool {
    const MIN_SIZE: usize = 1;

    fn write(&self, w: &mut Writer<'_>) -> Result<(), Error> {
        w.bytes(&[u8::from(*self)]);
        Ok(())
    }

    fn read(r: &mut Reader<'_>) -> Result<Self, Error> {
        match u8::read(r)? {
            0 => Ok(false),
            1 => Ok(true),
            found => Err(Error::Boolean { field: r.field.into(), offset: r.offset - 1, found }),
        }
    }
}

impl Wire for String {
    const MIN_SIZE: usize = 5;

    fn write(&self, w: &mut Writer<'_>) -> Result<(), Error> {
        w.string(self)
    }

    fn read(r: &mut Reader<'_>) -> Result<Self, Error> {
        r.string().map(str::to_owned)
    }
}

impl<T: Wire, const N: usize> Wire for [T; N]
where
    [T; N]: Default,
{
    const MIN_SIZE: usize = N * T::MIN_SIZE;

    fn write(&self, w: &mut Writer<'_>) -> Result<(), Error> {
        self.iter().try_for_each(|element| element.write(w))
    }

    fn read(r: &mut Reader<'_>) -> Result<Self, Error> {
        r.fixed_rows(T::read)
    }
}
