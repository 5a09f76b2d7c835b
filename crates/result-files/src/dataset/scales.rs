//! Dimension scales, by which readers find the axes of a dataset. The HDF5 crate has no binding for
//! them.
#![expect(unsafe_code, reason = "the only way to the dimension scale functions of the C library")]

use std::cell::RefCell;
use std::ffi::{CString, c_char, c_int};

use hdf5::types::{VarLenArray, VarLenAscii};
use hdf5::{Dataset, Error, H5Type, ObjectReference1, Result};
use hdf5_sys::h5i::hid_t;
use ndarray::ArrayView1;

unsafe extern "C" {
    fn H5DSset_scale(dataset: hid_t, name: *const c_char) -> c_int;
}

/// A dimension scale and the datasets that it is attached to. Both sides hold references, as the specification of scales
/// has them: datasets their scales (`DIMENSION_LIST`), scales their datasets (`REFERENCE_LIST`). `H5DSattach_scale` writes
/// the second list anew for each dataset, so that time and space grow by the square of their number; here it is written
/// by [`Scale::finish`], once for all that are there.
pub struct Scale {
    dataset: Dataset,
    own: ObjectReference1,
    users: RefCell<Vec<User>>,
}

/// An entry of the list of a scale.
#[derive(Debug, Clone, Copy, H5Type)]
#[repr(C)]
struct User {
    dataset: ObjectReference1,
    dimension: u32,
}

impl Scale {
    /// Makes `dataset` a dimension scale called `name`.
    pub fn new(dataset: Dataset, name: &str) -> Result<Self> {
        make_scale(&dataset, name)?;
        let own = dataset.reference::<ObjectReference1>(".")?;
        Ok(Self { dataset, own, users: RefCell::default() })
    }

    /// How many values it has.
    pub fn size(&self) -> usize {
        self.dataset.size()
    }

    /// Writes which datasets it is attached to, in place of an earlier list that was shorter.
    pub fn finish(&self) -> Result<()> {
        const LIST: &str = "REFERENCE_LIST";
        let users = self.users.borrow();
        let earlier = self.dataset.attr(LIST).map_or(0, |list| list.size());
        if users.len() == earlier {
            return Ok(());
        }
        if earlier > 0 {
            self.dataset.delete_attr(LIST)?;
        }
        let list = self.dataset.new_attr::<User>().shape(users.len()).create(LIST)?;
        list.write(ArrayView1::from(&*users))
    }
}

/// Makes `dataset` a dimension scale called `name` that is attached to no other.
pub fn make_scale(dataset: &Dataset, name: &str) -> Result<()> {
    let text = c_string(name)?;
    // SAFETY: the identifier belongs to a live handle, the string outlives the call, `sync` holds
    // the library's lock.
    checked("H5DSset_scale", hdf5::sync::sync(|| unsafe { H5DSset_scale(dataset.id(), text.as_ptr()) }))
}

/// Attaches `scales` to the first dimensions of `dataset`, which has no scales yet, and labels them.
pub fn attach(dataset: &Dataset, scales: &[(&Scale, &str)]) -> Result<()> {
    let own = dataset.reference::<ObjectReference1>(".")?;
    let mut lists = vec![VarLenArray::from_slice(&[]); dataset.ndim()];
    let mut labels = vec![VarLenAscii::new(); dataset.ndim()];
    for (dimension, ((scale, label), (list, text))) in
        (0..).zip(scales.iter().zip(lists.iter_mut().zip(&mut labels)))
    {
        *list = VarLenArray::from_slice(&[scale.own]);
        scale.users.borrow_mut().push(User { dataset: own, dimension });
        *text = VarLenAscii::from_ascii(label.as_bytes()).map_err(|e| Error::from(e.to_string()))?;
    }
    // As `H5DSset_label` writes it, which reads and writes it anew for each dimension.
    let text = dataset.new_attr::<VarLenAscii>().shape(labels.len()).create("DIMENSION_LABELS")?;
    text.write(ArrayView1::from(&labels))?;
    let list = dataset.new_attr::<VarLenArray<ObjectReference1>>().shape(lists.len());
    list.create("DIMENSION_LIST")?.write(ArrayView1::from(&lists))
}

fn c_string(text: &str) -> Result<CString> {
    CString::new(text).map_err(|e| Error::from(e.to_string()))
}

fn checked(function: &str, code: c_int) -> Result<()> {
    if code < 0 { Err(Error::from(format!("{function} failed with code {code}"))) } else { Ok(()) }
}
