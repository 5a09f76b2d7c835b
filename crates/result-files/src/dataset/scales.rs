//! Dimension scales, by which readers find the axes of a dataset. The HDF5 crate has no binding for
//! them.
#![expect(unsafe_code, reason = "the only way to the dimension scale functions of the C library")]

use std::ffi::{CString, c_char, c_int, c_uint};

use hdf5::{Dataset, Error, Result};
use hdf5_sys::h5i::hid_t;

unsafe extern "C" {
    fn H5DSset_scale(dataset: hid_t, name: *const c_char) -> c_int;
    fn H5DSattach_scale(dataset: hid_t, scale: hid_t, dimension: c_uint) -> c_int;
    fn H5DSset_label(dataset: hid_t, dimension: c_uint, label: *const c_char) -> c_int;
}

/// Makes `dataset` a dimension scale called `name`.
pub fn make_scale(dataset: &Dataset, name: &str) -> Result<()> {
    let text = c_string(name)?;
    // SAFETY: the identifier belongs to a live handle, the string outlives the call, `sync` holds
    // the library's lock.
    checked("H5DSset_scale", hdf5::sync::sync(|| unsafe { H5DSset_scale(dataset.id(), text.as_ptr()) }))
}

/// Attaches `scale` to a dimension of `dataset` and labels it.
pub fn attach(dataset: &Dataset, dimension: u32, scale: &Dataset, label: &str) -> Result<()> {
    let text = c_string(label)?;
    // SAFETY: as above, for both handles; an invalid dimension is answered with an error code.
    let codes = hdf5::sync::sync(|| unsafe {
        [
            H5DSattach_scale(dataset.id(), scale.id(), dimension),
            H5DSset_label(dataset.id(), dimension, text.as_ptr()),
        ]
    });
    checked("H5DSattach_scale", codes[0])?;
    checked("H5DSset_label", codes[1])
}

fn c_string(text: &str) -> Result<CString> {
    CString::new(text).map_err(|e| Error::from(e.to_string()))
}

fn checked(function: &str, code: c_int) -> Result<()> {
    if code < 0 { Err(Error::from(format!("{function} failed with code {code}"))) } else { Ok(()) }
}
