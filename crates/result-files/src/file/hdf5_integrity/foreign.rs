//! Code and files that a file of HDF5 can have the library load: plug-ins for its filters, links
//! into other files.
#![expect(unsafe_code, reason = "the crate has no binding for these functions of the C library")]

use std::ffi::{CStr, c_char, c_int, c_uint, c_void};
use std::sync::Once;

use hdf5::File;
use hdf5_sys::h5i::hid_t;

/// Kinds of links: to an object of the same file by its place, by its name, and into another file.
const HARD: c_int = 0;
const SOFT: c_int = 1;
const EXTERNAL: c_int = 64;
/// Ways through a group: by names, in the order in which they are stored.
const BY_NAME: c_int = 0;
const AS_STORED: c_int = 2;

/// What a visit calls: group, name of the link, description (which begins with its kind), place of
/// the caller.
type Visitor = extern "C" fn(hid_t, *const c_char, *const c_int, *mut c_void) -> c_int;

unsafe extern "C" {
    // The binding of the crate takes a pointer, the library a number.
    fn H5PLset_loading_state(kinds: c_uint) -> c_int;
    fn H5PLsize(count: *mut c_uint) -> c_int;
    fn H5PLremove(index: c_uint) -> c_int;
    fn H5Lunregister(kind: c_int) -> c_int;
    fn H5Lvisit2(group: hid_t, index: c_int, order: c_int, visitor: Visitor, place: *mut c_void) -> c_int;
}

/// Has the library load no plug-ins and follow no links into other files; what fails here was off
/// before. The folders in which it would look for plug-ins go as well: that of its build is
/// compiled in, and no setting of its packages leaves it out.
pub fn forbid() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        // SAFETY: plain numbers, and `sync` holds the library's lock.
        hdf5::sync::sync(|| unsafe {
            H5PLset_loading_state(0);
            (0..folders()).for_each(|_| _ = H5PLremove(0));
            H5Lunregister(EXTERNAL);
        });
    });
}

/// Number of folders in which the library would look for plug-ins.
fn folders() -> c_uint {
    let mut count = 0;
    // SAFETY: the place outlives the call.
    unsafe { H5PLsize(&raw mut count) };
    count
}

/// The path of a link in `file` that leads to another file.
pub fn external_link(file: &File) -> Option<String> {
    let mut found: Option<String> = None;
    let place = (&raw mut found).cast::<c_void>();
    // SAFETY: the identifier belongs to a live handle, `found` outlives the call, `sync` holds the
    // library's lock.
    hdf5::sync::sync(|| unsafe { H5Lvisit2(file.id(), BY_NAME, AS_STORED, note_external, place) });
    found
}

/// Notes the name of a link that is neither hard nor soft, and ends the visit.
extern "C" fn note_external(_: hid_t, name: *const c_char, kind: *const c_int, found: *mut c_void) -> c_int {
    // SAFETY: the library hands over a name that ends, a description of the link, and the place
    // that was given to it.
    let (kind, name, found) = unsafe { (*kind, CStr::from_ptr(name), &mut *found.cast::<Option<String>>()) };
    if matches!(kind, HARD | SOFT) {
        return 0;
    }
    *found = Some(name.to_string_lossy().into_owned());
    1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_folder_is_left_to_load_plug_ins_from() {
        forbid();
        assert_eq!(hdf5::sync::sync(folders), 0);
    }
}
