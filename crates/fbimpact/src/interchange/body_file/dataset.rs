//! Datasets and attributes with errors that name them.

use ffr_dynamics::DynamicsError;
use hdf5::types::{TypeDescriptor, VarLenAscii, VarLenUnicode};
use hdf5::{Dataset, Group, H5Type, Location};
use nalgebra::Vector3;
use ndarray::ArrayD;
use result_files::file::hdf5_integrity;

use super::fault::BodyFault;

/// Lengths of a dataset: fixed, or whatever the file has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extent {
    /// Exactly this many.
    Exactly(usize),
    /// Any number; the letter stands for it in messages.
    Any(&'static str),
}

/// Numbers in the order of rows, and the lengths of all directions.
pub type Reals = (Vec<f64>, Vec<usize>);

/// A group with its path.
pub struct Node {
    pub group: Group,
    pub path: String,
}

impl Node {
    pub fn child(&self, name: &str) -> String {
        format!("{}/{name}", self.path.trim_end_matches('/'))
    }

    /// The group `name`, if there is one.
    pub fn find(&self, name: &str) -> Result<Option<Node>, BodyFault> {
        if !self.group.link_exists(name) {
            return Ok(None);
        }
        let path = self.child(name);
        match self.group.group(name) {
            Ok(group) => Ok(Some(Node { group, path })),
            Err(_) => {
                Err(BodyFault::Missing { what: "group", path, expected: "a group, found a dataset".into() })
            }
        }
    }

    pub fn group(&self, name: &str, expected: &str) -> Result<Node, BodyFault> {
        let path = self.child(name);
        let missing = || BodyFault::Missing { what: "group", path, expected: expected.into() };
        self.find(name)?.ok_or_else(missing)
    }

    /// Groups in this one, by name, sorted.
    pub fn groups(&self) -> Result<Vec<(String, Node)>, BodyFault> {
        let mut names = self.group.member_names()?;
        names.sort();
        names.into_iter().map(|name| self.group(&name, "a group").map(|node| (name, node))).collect()
    }

    /// Numbers of the dataset `name` in the order of its rows, and its shape; `None` if it is
    /// missing.
    pub fn find_reals(&self, name: &str, shape: &[Extent]) -> Result<Option<Reals>, BodyFault> {
        let Some((dataset, found)) = self.dataset(name, shape)? else { return Ok(None) };
        let path = self.child(name);
        let is_number = |t: &TypeDescriptor| {
            matches!(t, TypeDescriptor::Float(_) | TypeDescriptor::Integer(_) | TypeDescriptor::Unsigned(_))
        };
        check_type(&dataset, &path, "floating-point numbers", is_number)?;
        let values = hdf5_integrity::rows::<f64>(&dataset)?;
        if let Some(at) = values.iter().position(|v| !v.is_finite()) {
            let found = format!("{} at position {:?}", values[at], multi_index(at, &found));
            return Err(BodyFault::Numbers { path, found, allowed: "all numbers must be finite".into() });
        }
        Ok(Some((values, found)))
    }

    pub fn reals(&self, name: &str, shape: &[Extent]) -> Result<Reals, BodyFault> {
        self.find_reals(name, shape)?.ok_or_else(|| self.missing(name, shape))
    }

    pub fn real(&self, name: &str) -> Result<f64, BodyFault> {
        Ok(self.reals(name, &[])?.0[0])
    }

    /// Vectors with three components, one per row.
    pub fn vectors(&self, name: &str, n: usize) -> Result<Vec<Vector3<f64>>, BodyFault> {
        let (values, _) = self.reals(name, &[Extent::Exactly(n), Extent::Exactly(3)])?;
        Ok(values.chunks_exact(3).map(Vector3::from_column_slice).collect())
    }

    /// Indices from 0 to `last`.
    pub fn indices(&self, name: &str, shape: &[Extent], last: usize) -> Result<Vec<u32>, BodyFault> {
        let Some((dataset, _)) = self.dataset(name, shape)? else { return Err(self.missing(name, shape)) };
        let path = self.child(name);
        let is_whole =
            |t: &TypeDescriptor| matches!(t, TypeDescriptor::Integer(_) | TypeDescriptor::Unsigned(_));
        check_type(&dataset, &path, "integers", is_whole)?;
        let last = last.min(u32::MAX as usize) as i64;
        let values = hdf5_integrity::rows::<i64>(&dataset)?;
        if let Some(position) = values.iter().position(|v| *v < 0 || *v > last) {
            return Err(BodyFault::index(path, position, values[position], last));
        }
        Ok(values.into_iter().map(|v| v as u32).collect())
    }

    fn missing(&self, name: &str, shape: &[Extent]) -> BodyFault {
        BodyFault::Missing {
            what: "dataset",
            path: self.child(name),
            expected: format!("shape {}", text(shape)),
        }
    }

    fn dataset(&self, name: &str, shape: &[Extent]) -> Result<Option<(Dataset, Vec<usize>)>, BodyFault> {
        if !self.group.link_exists(name) {
            return Ok(None);
        }
        let path = self.child(name);
        let Ok(dataset) = self.group.dataset(name) else {
            let expected = format!("a dataset of shape {}, found a group", text(shape));
            return Err(BodyFault::Missing { what: "dataset", path, expected });
        };
        let found = dataset.shape();
        let fits = found.len() == shape.len()
            && found.iter().zip(shape).all(|(n, e)| matches!(e, Extent::Any(_)) || *e == Extent::Exactly(*n));
        if !fits {
            return Err(BodyFault::Shape { path, expected: text(shape), found });
        }
        Ok(Some((dataset, found)))
    }

    /// A text attribute of the group; `None` if it is missing.
    pub fn find_text(&self, name: &str) -> Result<Option<String>, BodyFault> {
        let Ok(attribute) = self.group.attr(name) else { return Ok(None) };
        let unicode = attribute.read_scalar::<VarLenUnicode>().map(|t| t.as_str().to_string());
        let text =
            unicode.or_else(|_| attribute.read_scalar::<VarLenAscii>().map(|t| t.as_str().to_string()));
        text.map(Some).map_err(|_| BodyFault::Attribute {
            at: self.path.clone(),
            name: name.into(),
            expected: "a string of variable length".into(),
            found: "something else".into(),
        })
    }

    /// The position of a text attribute among `choices`.
    pub fn choice(&self, name: &str, choices: &[&str]) -> Result<usize, BodyFault> {
        let found = self.find_text(name)?;
        let at = found.as_ref().and_then(|f| choices.iter().position(|c| c == f));
        at.ok_or_else(|| BodyFault::Attribute {
            at: self.path.clone(),
            name: name.into(),
            expected: choices.iter().map(|c| format!("\"{c}\"")).collect::<Vec<_>>().join(" or "),
            found: found.map_or("missing".into(), |f| format!("\"{f}\"")),
        })
    }

    /// Writes numbers in the order of rows.
    pub fn write<T: H5Type>(
        &self,
        name: &str,
        shape: &[usize],
        values: Vec<T>,
        unit: &str,
        description: &str,
    ) -> Result<(), BodyFault> {
        let array = ArrayD::from_shape_vec(shape, values).map_err(|e| hdf5::Error::from(e.to_string()))?;
        let dataset = self.group.new_dataset::<T>().shape(shape).create(name)?;
        if !array.is_empty() {
            dataset.write(array.view())?;
        }
        text_attribute(&dataset, "unit", unit)?;
        text_attribute(&dataset, "description", description)
    }

    pub fn create(&self, name: &str) -> Result<Node, BodyFault> {
        if name.is_empty() || name.contains(['/', '\0']) || name == "." || name == ".." {
            return Err(BodyFault::Name { name: name.into() });
        }
        Ok(Node { group: self.group.create_group(name)?, path: self.child(name) })
    }

    pub fn text(&self, name: &str, value: &str) -> Result<(), BodyFault> {
        text_attribute(&self.group, name, value)
    }

    /// Names the place of an error of the model.
    pub fn fault(&self, source: DynamicsError) -> BodyFault {
        BodyFault::Data { at: self.path.clone(), source }
    }
}

fn text_attribute(target: &Location, name: &str, value: &str) -> Result<(), BodyFault> {
    let value: VarLenUnicode =
        value.replace('\0', "").parse().map_err(|e| hdf5::Error::from(format!("{e:?}")))?;
    target.new_attr::<VarLenUnicode>().create(name)?.write_scalar(&value)?;
    Ok(())
}

fn check_type(
    dataset: &Dataset,
    path: &str,
    expected: &'static str,
    fits: impl Fn(&TypeDescriptor) -> bool,
) -> Result<(), BodyFault> {
    let found = match dataset.dtype().and_then(|t| t.to_descriptor()) {
        Ok(descriptor) if fits(&descriptor) => return Ok(()),
        Ok(descriptor) => descriptor.to_string(),
        Err(_) => "a type that this program does not know".into(),
    };
    Err(BodyFault::Numbers { path: path.into(), found, allowed: format!("expected {expected}") })
}

fn text(shape: &[Extent]) -> String {
    let length = |e: &Extent| match e {
        Extent::Exactly(n) => n.to_string(),
        Extent::Any(letter) => (*letter).to_string(),
    };
    format!("[{}]", shape.iter().map(length).collect::<Vec<_>>().join(", "))
}

/// Position in every direction of entry `at`, the last direction running fastest.
fn multi_index(mut at: usize, shape: &[usize]) -> Vec<usize> {
    let mut index: Vec<usize> = shape
        .iter()
        .rev()
        .map(|n| {
            let i = at % (*n).max(1);
            at /= (*n).max(1);
            i
        })
        .collect();
    index.reverse();
    index
}
