//! Numbers of a report as text: quantised, the differences sorted into planes of bytes, deflated,
//! in base64.

use miniz_oxide::deflate::compress_to_vec;
use serde::Serialize;

/// Stands for a value that is not finite.
pub const MISSING: i16 = i16::MIN;
/// Effort of the compression, of ten.
const EFFORT: u8 = 9;

/// How the integers of an array lie in its blob, little endian.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Coding {
    /// One after the other.
    Plain,
    /// Component by component the difference from the one before, zigzag; the lowest bytes of all
    /// first, the highest last.
    DeltaPlanes,
}

/// Type of the numbers of an array.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// Integer of 16 bits.
    I16,
    /// Natural number of 32 bits.
    U32,
    /// Floating point number of 32 bits.
    F32,
    /// Byte.
    U8,
}

/// Where an array lies; its values are `offset_value + scale * number`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Array {
    /// Name of the blob.
    pub blob: String,
    /// First byte.
    pub offset: usize,
    /// Numbers in all.
    pub count: usize,
    /// Their type.
    #[serde(rename = "type")]
    pub kind: Kind,
    /// How many numbers each row has.
    pub components: usize,
    /// Value of a unit.
    pub scale: f64,
    /// Value of zero.
    pub zero: f64,
    /// How they lie there.
    pub coding: Coding,
}

impl Array {
    /// Values as a reader gets them back from an array of integers of 16 bits.
    pub fn rounded(&self, values: &[f64]) -> Vec<f64> {
        let step = |x: &f64| if self.scale > 0.0 { ((x - self.zero) / self.scale).round() } else { 0.0 };
        values.iter().map(|x| self.zero + self.scale * step(x)).collect()
    }
}

/// Bytes of arrays that are decoded together.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Blob {
    /// Name.
    pub name: String,
    bytes: Vec<u8>,
}

impl Blob {
    /// An empty one.
    pub fn new(name: String) -> Self {
        Self { name, bytes: Vec::new() }
    }

    /// Appends values, `components` a row, as multiples of a step of which `2^(bits - 1) - 1` reach
    /// the largest of them; up to 16 bits.
    pub fn quantised(&mut self, values: &[f64], components: usize, bits: u32) -> Array {
        let largest = values.iter().filter(|x| x.is_finite()).fold(0.0_f64, |most, x| most.max(x.abs()));
        self.steps(values, components, (0.0, largest), bits)
    }

    /// Appends `values` in steps about the middle of their range: more exact than from zero where
    /// they change little.
    pub fn quantised_range(&mut self, values: &[f64], bits: u32) -> Array {
        let finite = values.iter().copied().filter(|x| x.is_finite());
        let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        let (zero, half) =
            if high >= low { (0.5 * low + 0.5 * high, 0.5 * high - 0.5 * low) } else { (0.0, 0.0) };
        self.steps(values, 1, (zero, half), bits)
    }

    fn steps(&mut self, values: &[f64], components: usize, (zero, half): (f64, f64), bits: u32) -> Array {
        let most = f64::from((1_i32 << (bits.clamp(2, 16) - 1)) - 1);
        let scale = if half > 0.0 { half / most } else { 0.0 };
        let step = |x: f64| match (x.is_finite(), scale > 0.0) {
            (false, _) => MISSING,
            (true, false) => 0,
            // The cast saturates; `most` is in its range.
            (true, true) => ((x - zero) / scale).round() as i16,
        };
        let numbers: Vec<i16> = values.iter().map(|x| step(*x)).collect();
        let coded = differences(&numbers, components, |a, b| {
            let d = a.wrapping_sub(b);
            ((d << 1) ^ (d >> 15)) as u16
        });
        let offset = self.planes(&coded, |n| n.to_le_bytes());
        let coding = Coding::DeltaPlanes;
        Array { scale, zero, ..self.array(offset, (values.len(), components), Kind::I16, coding) }
    }

    /// Appends values as multiples of a step of which 2^31 reach from the lowest to the highest,
    /// for instants of time.
    pub fn finely(&mut self, values: &[f64]) -> Array {
        let finite = values.iter().copied().filter(|x| x.is_finite());
        let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        let (zero, scale) =
            if high > low { (low, (high - low) / f64::from(1_u32 << 31)) } else { (low, 0.0) };
        let step = |x: &f64| if scale > 0.0 { ((x - zero) / scale).round() as u32 } else { 0 };
        let numbers: Vec<u32> = values.iter().map(step).collect();
        let zero = if zero.is_finite() { zero } else { 0.0 };
        Array { scale, zero, ..self.naturals(&numbers, 1) }
    }

    /// Appends natural numbers, `components` in each row.
    pub fn naturals(&mut self, numbers: &[u32], components: usize) -> Array {
        let coded = differences(numbers, components, |a, b| {
            let d = a.wrapping_sub(b) as i32;
            ((d << 1) ^ (d >> 31)) as u32
        });
        let offset = self.planes(&coded, |n| n.to_le_bytes());
        self.array(offset, (numbers.len(), components), Kind::U32, Coding::DeltaPlanes)
    }

    /// Appends values as floating point numbers of 32 bits.
    pub fn floats(&mut self, values: &[f64], components: usize) -> Array {
        let offset = self.bytes.len();
        self.bytes.extend(values.iter().flat_map(|x| (*x as f32).to_le_bytes()));
        self.array(offset, (values.len(), components), Kind::F32, Coding::Plain)
    }

    /// Appends values that are not negative as parts of the largest, a byte each.
    pub fn bytes(&mut self, values: &[f64]) -> Array {
        let largest = values.iter().filter(|x| x.is_finite()).fold(0.0_f64, |most, x| most.max(*x));
        let scale = largest / f64::from(u8::MAX);
        let step = |x: &f64| if scale > 0.0 && x.is_finite() { (x / scale).round() as u8 } else { 0 };
        let offset = self.bytes.len();
        self.bytes.extend(values.iter().map(step));
        Array { scale, ..self.array(offset, (values.len(), 1), Kind::U8, Coding::Plain) }
    }

    fn array(&self, offset: usize, (count, components): (usize, usize), kind: Kind, coding: Coding) -> Array {
        let blob = self.name.clone();
        Array { blob, offset, count, kind, components, scale: 1.0, zero: 0.0, coding }
    }

    fn planes<T: Copy, const N: usize>(&mut self, numbers: &[T], bytes: impl Fn(T) -> [u8; N]) -> usize {
        let offset = self.bytes.len();
        for plane in 0..N {
            self.bytes.extend(numbers.iter().map(|n| bytes(*n)[plane]));
        }
        offset
    }

    /// The blob as it stands in the report: raw deflate in base64.
    pub fn text(&self) -> String {
        base64(&compress_to_vec(&self.bytes, EFFORT))
    }
}

/// Numbers component by component, each as what `coded` makes of it and the one before.
fn differences<T: Copy + Default, U>(numbers: &[T], components: usize, coded: impl Fn(T, T) -> U) -> Vec<U> {
    let mut all = Vec::with_capacity(numbers.len());
    for component in 0..components.max(1) {
        let mut before = T::default();
        for &number in numbers.iter().skip(component).step_by(components.max(1)) {
            all.push(coded(number, before));
            before = number;
        }
    }
    all
}

/// Bytes in the alphabet of RFC 4648, padded.
pub fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let byte = |i: usize| three.get(i).map_or(0, |b| u32::from(*b));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for letter in 0..4 {
            let is_padding = letter > three.len();
            let index = (bits >> (18 - 6 * letter) & 63) as usize;
            text.push(if is_padding { '=' } else { char::from(LETTERS[index]) });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_that_of_rfc_4648() {
        for (plain, coded) in
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")]
        {
            assert_eq!(base64(plain.as_bytes()), coded);
        }
    }

    #[test]
    fn what_is_not_finite_is_missing_and_nothing_has_no_step() {
        let mut blob = Blob::new("b".into());
        let array = blob.quantised(&[f64::NAN, 1.0, -1.0, f64::INFINITY], 1, 16);
        assert_eq!((array.count, array.scale), (4, 1.0 / 32767.0));
        assert_eq!(blob.quantised(&[0.0; 3], 3, 12).scale.to_bits(), 0.0_f64.to_bits());
        assert_eq!(blob.quantised_range(&[5.0, 5.0], 16).zero.to_bits(), 5.0_f64.to_bits());
        assert_eq!(blob.quantised_range(&[], 16).count, 0);
    }
}
