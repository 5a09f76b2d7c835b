//! Histories as CSV and as JSON.

use std::fmt::Write as _;

use serde_json::{Map, Value, json};

use super::series::{PointInstant, PointSeries};
use crate::postprocessing::replay::states::BodyMotion;
use crate::results::stress::tensor_labels;

/// A quantity of a point: name, unit, names of its components, its values.
struct Quantity {
    name: &'static str,
    unit: &'static str,
    components: Vec<&'static str>,
    /// Whether only points with strain and stress have it.
    is_gauge: bool,
    values: fn(&PointInstant) -> Vec<f64>,
}

fn quantities(is_axisymmetric: bool) -> Vec<Quantity> {
    let vector = |name, unit, values: fn(&PointInstant) -> Vec<f64>| Quantity {
        name,
        unit,
        components: vec!["x", "y", "z"],
        is_gauge: false,
        values,
    };
    let tensor = |name, unit, values: fn(&PointInstant) -> Vec<f64>| Quantity {
        name,
        unit,
        components: tensor_labels(is_axisymmetric).to_vec(),
        is_gauge: true,
        values,
    };
    vec![
        vector("position", "m", |p| p.position.as_slice().to_vec()),
        vector("displacement", "m", |p| p.displacement.as_slice().to_vec()),
        vector("velocity", "m/s", |p| p.velocity.as_slice().to_vec()),
        vector("deformation", "m", |p| p.deformation.as_slice().to_vec()),
        tensor("stress", "Pa", |p| p.state.stress.to_vec()),
        Quantity {
            name: "von_mises",
            unit: "Pa",
            components: vec![""],
            is_gauge: true,
            values: |p| vec![p.state.von_mises()],
        },
        tensor("strain", "–", |p| p.state.strain.to_vec()),
    ]
}

/// Component without a name: a direction that the model does not have.
const NONE: &str = "-";

/// Points as CSV: a row per instant and point, a header that names the columns, SI units.
pub fn points_csv(time: &[f64], points: &[PointSeries], is_axisymmetric: bool) -> String {
    let has_gauge = points.iter().any(|point| point.has_gauge);
    let quantities: Vec<Quantity> =
        quantities(is_axisymmetric).into_iter().filter(|q| has_gauge || !q.is_gauge).collect();
    let mut out = String::from("point,time");
    for quantity in &quantities {
        for component in quantity.components.iter().filter(|c| **c != NONE) {
            let join = if component.is_empty() { "" } else { "_" };
            let _ = write!(out, ",{}{join}{component}", quantity.name);
        }
    }
    out.push('\n');
    for point in points {
        for (t, instant) in time.iter().zip(&point.instants) {
            let _ = write!(out, "{},{t:?}", point.label);
            for quantity in &quantities {
                let values = (quantity.values)(instant);
                for (_, value) in quantity.components.iter().zip(values).filter(|(c, _)| **c != NONE) {
                    if quantity.is_gauge && !point.has_gauge {
                        out.push(',');
                    } else {
                        let _ = write!(out, ",{value:?}");
                    }
                }
            }
            out.push('\n');
        }
    }
    out
}

/// Points as JSON: times, units and names of components once, for each point its histories.
pub fn points_json(body: &str, time: &[f64], points: &[PointSeries], is_axisymmetric: bool) -> Value {
    let quantities = quantities(is_axisymmetric);
    let mut units = Map::from_iter([("time".to_owned(), json!("s")), ("place".to_owned(), json!("m"))]);
    units.extend(quantities.iter().map(|q| (q.name.to_owned(), json!(q.unit))));
    let of_point = |point: &PointSeries| {
        let mut object = Map::new();
        object.insert("name".into(), json!(point.label));
        object.insert("place".into(), json!(point.place));
        for quantity in quantities.iter().filter(|q| point.has_gauge || !q.is_gauge) {
            let rows: Vec<Value> = point
                .instants
                .iter()
                .map(|instant| match (quantity.values)(instant).as_slice() {
                    [one] => json!(one),
                    many => json!(many),
                })
                .collect();
            object.insert(quantity.name.to_owned(), Value::Array(rows));
        }
        Value::Object(object)
    };
    let points: Vec<Value> = points.iter().map(of_point).collect();
    let components = tensor_labels(is_axisymmetric);
    json!({ "body": body, "units": units, "tensor_components": components, "time": time, "points": points })
}

/// Elastic coordinates of a body as CSV: time, coordinates `q1`, `q2`, …, rates `v1`, `v2`, ….
pub fn modes_csv(time: &[f64], rows: std::ops::Range<usize>, motion: &BodyMotion) -> String {
    let n = motion.eigenfrequencies.len();
    let mut out = String::from("time");
    for letter in ["q", "v"] {
        for k in 1..=n {
            let _ = write!(out, ",{letter}{k}");
        }
    }
    out.push('\n');
    for i in rows {
        let _ = write!(out, "{:?}", time[i]);
        for x in motion.elastic(i).iter().chain(motion.rates(i)) {
            let _ = write!(out, ",{x:?}");
        }
        out.push('\n');
    }
    out
}

/// The same as JSON, with the eigenfrequencies.
pub fn modes_json(body: &str, time: &[f64], rows: std::ops::Range<usize>, motion: &BodyMotion) -> Value {
    let list = |of: &dyn Fn(usize) -> Vec<f64>| rows.clone().map(|i| json!(of(i))).collect::<Vec<Value>>();
    json!({
        "body": body,
        "units": {
            "time": "s", "eigenfrequencies": "Hz", "elastic_coordinates": "m kg^0.5", "elastic_velocities": "m kg^0.5/s",
        },
        "eigenfrequencies": motion.eigenfrequencies,
        "time": &time[rows.clone()],
        "elastic_coordinates": list(&|i| motion.elastic(i).to_vec()),
        "elastic_velocities": list(&|i| motion.rates(i).to_vec()),
    })
}
