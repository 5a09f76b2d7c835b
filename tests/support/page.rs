//! Reads what scripts of a report read: the head, and arrays in base64 of raw deflate.

use std::collections::HashMap;

use miniz_oxide::inflate::decompress_to_vec;
use serde_json::Value;

/// A report taken apart.
pub struct ReportPage {
    /// The whole page.
    pub text: String,
    /// What its scripts read.
    pub head: Value,
    blobs: HashMap<String, Vec<u8>>,
}

impl ReportPage {
    /// Takes `text` apart.
    pub fn new(text: String) -> Self {
        let head = between(&text, "<script type=\"application/json\" id=\"head\">");
        let head = serde_json::from_str(head).expect("the head is JSON");
        let mark = "<script type=\"text/plain\" id=\"blob-";
        let blobs = text.split(mark).skip(1).map(|part| {
            let (name, rest) = part.split_once("\">").expect("a name");
            let coded = rest.split_once("</script>").expect("an end").0;
            (name.to_owned(), decompress_to_vec(&bytes(coded)).expect("raw deflate"))
        });
        let blobs = blobs.collect();
        Self { head, blobs, text }
    }

    /// Values of an array, in the order of its rows.
    pub fn values(&self, array: &Value) -> Vec<f64> {
        let number = |key: &str| array[key].as_u64().expect("a number") as usize;
        let (offset, count, components) = (number("offset"), number("count"), number("components"));
        let kind = array["type"].as_str().expect("a type");
        let bytes = &self.blobs[array["blob"].as_str().expect("a name")][offset..];
        let (zero, scale) = (array["zero"].as_f64().expect("zero"), array["scale"].as_f64().expect("scale"));
        let numbers: Vec<f64> = match (kind, array["coding"].as_str()) {
            ("f32", Some("plain")) => {
                bytes.as_chunks::<4>().0[..count].iter().map(|b| f64::from(f32::from_le_bytes(*b))).collect()
            }
            ("u8", Some("plain")) => bytes[..count].iter().map(|b| f64::from(*b)).collect(),
            ("i16", Some("delta-planes")) => {
                let coded = |i: usize| u32::from(bytes[i]) | u32::from(bytes[count + i]) << 8;
                summed(count, components, coded, |sum| f64::from(sum as u16 as i16))
            }
            ("u32", Some("delta-planes")) => {
                let plane = |i: usize, p: usize| u32::from(bytes[p * count + i]) << (8 * p);
                let coded = |i: usize| (0..4).map(|p| plane(i, p)).sum();
                summed(count, components, coded, f64::from)
            }
            other => panic!("unknown coding {other:?}"),
        };
        numbers.iter().map(|n| zero + scale * n).collect()
    }

    /// Arrays one after the other.
    pub fn lists(&self, arrays: &Value) -> Vec<Vec<f64>> {
        let all = arrays.as_array().map(Vec::as_slice).unwrap_or_default();
        all.iter().map(|array| self.values(array)).collect()
    }
}

/// Rows of sums of differences that stand in `coded`, zigzag, component by component.
fn summed(
    count: usize,
    components: usize,
    coded: impl Fn(usize) -> u32,
    number: impl Fn(u32) -> f64,
) -> Vec<f64> {
    let mut out = vec![0.0; count];
    let rows = count / components;
    for component in 0..components {
        let mut sum = 0_u32;
        for row in 0..rows {
            let zigzag = coded(component * rows + row);
            sum = sum.wrapping_add((zigzag >> 1) ^ (zigzag & 1).wrapping_neg());
            out[row * components + component] = number(sum);
        }
    }
    out
}

/// Text from behind `mark` to the end of the script element.
fn between<'a>(text: &'a str, mark: &str) -> &'a str {
    let rest = text.split_once(mark).expect("the mark").1;
    rest.split_once("</script>").expect("an end").0
}

/// Bytes of base64.
fn bytes(text: &str) -> Vec<u8> {
    let value = |c: u8| match c {
        b'A'..=b'Z' => Some(c - b'A'),
        b'a'..=b'z' => Some(c - b'a' + 26),
        b'0'..=b'9' => Some(c - b'0' + 52),
        b'+' => Some(62),
        b'/' => Some(63),
        _ => None,
    };
    let (mut out, mut bits, mut n) = (Vec::new(), 0_u32, 0);
    for sixth in text.bytes().filter_map(value) {
        bits = bits << 6 | u32::from(sixth);
        n += 6;
        if n >= 8 {
            n -= 8;
            out.push((bits >> n) as u8);
        }
    }
    out
}
