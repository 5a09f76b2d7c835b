//! Pictures as they are written.

use std::path::Path;

/// An array of a VTU file.
pub fn array(file: &Path, name: &str) -> Vec<f64> {
    let bytes = std::fs::read(file).expect("a file");
    let marker = b"encoding=\"raw\">\n_";
    let start = bytes.windows(marker.len()).position(|w| w == marker).expect("appended data") + marker.len();
    let text = String::from_utf8_lossy(&bytes[..start]).into_owned();
    let tag = text.lines().find(|l| l.contains(&format!("Name=\"{name}\""))).expect("the array");
    let offset = tag.split("offset=\"").nth(1).and_then(|t| t.split('"').next()).expect("an offset");
    let at = start + offset.parse::<usize>().expect("a number");
    let length = u64::from_le_bytes(bytes[at..at + 8].try_into().expect("eight bytes")) as usize;
    let data = &bytes[at + 8..at + 8 + length];
    match tag.split("type=\"").nth(1).and_then(|t| t.split('"').next()).expect("a type") {
        "Float64" => data.chunks(8).map(|c| f64::from_le_bytes(c.try_into().expect("8"))).collect(),
        "Float32" => {
            data.chunks(4).map(|c| f64::from(f32::from_le_bytes(c.try_into().expect("4")))).collect()
        }
        "Int64" => data.chunks(8).map(|c| i64::from_le_bytes(c.try_into().expect("8")) as f64).collect(),
        _ => data.iter().map(|b| f64::from(*b)).collect(),
    }
}
