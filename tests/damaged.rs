//! Files with damaged bytes that HDF5 itself pays for with memory or time without end: refused by every reader, at once.

use crate::support;
use std::path::Path;
use std::process::Command;

/// Code and standard error of a command that must end.
fn fbimpact(at: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fbimpact"));
    command.args(arguments).current_dir(at);
    let (code, _, err) = support::ended(&mut command);
    (code, err)
}

/// A small result in `folder`, its bytes, and where its table of phases starts.
fn result(folder: &Path) -> (Vec<u8>, usize) {
    let path =
        support::simulate(folder, "rigid_double_pendulums.toml", "ok.h5", &["simulation.end_time=0.02"]);
    let table = hdf5::File::open(&path).and_then(|f| f.dataset("phases")).expect("a table");
    let chunk = table.chunk_info(0).expect("a chunk");
    (std::fs::read(path).expect("readable"), usize::try_from(chunk.addr).expect("an address"))
}

#[test]
fn text_longer_than_the_file_is_refused_before_memory_is_taken_for_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let (mut bytes, phases) = result(at);
    // The first column is a text: its length, four bytes, comes first. HDF5 would take and clear 2 GB.
    assert_eq!(bytes[phases..phases + 4], 4_u32.to_le_bytes(), "\"free\"");
    bytes[phases..phases + 4].copy_from_slice(&2_000_000_000_u32.to_le_bytes());
    std::fs::write(at.join("bad.h5"), bytes).expect("written");
    for arguments in [&["info", "bad.h5"][..], &["plot", "bad.h5", "-o", "figures"]] {
        let (code, err) = fbimpact(at, arguments);
        assert_eq!(code, Some(6), "{err}");
        let cause = "/phases claims a text of 2000000000 bytes; the file is damaged, copy it again";
        assert!(err.starts_with("error: bad.h5: ") && err.contains(cause), "{err}");
    }
}

#[test]
fn heap_of_texts_without_end_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let (mut bytes, _) = result(at);
    let heap = bytes.windows(5).position(|w| w == b"GCOL\x01").expect("a heap");
    // Behind the first text, what is left becomes free space (object 0) of size zero.
    let first = u64::from_le_bytes(bytes[heap + 24..heap + 32].try_into().expect("eight bytes"));
    let next = heap + 32 + usize::try_from(first).expect("short").next_multiple_of(8);
    bytes[next..next + 16].fill(0);
    std::fs::write(at.join("bad.h5"), bytes).expect("written");
    let commands: [&[&str]; 5] = [
        &["info", "bad.h5"],
        &["compare", "bad.h5", "bad.h5"],
        &["plot", "bad.h5", "-o", "figures"],
        &["export", "bad.h5", "--vtk", "vtk"],
        &["thin", "bad.h5", "-o", "t.h5"],
    ];
    for arguments in commands {
        let (code, err) = fbimpact(at, arguments);
        assert_eq!(code, Some(6), "{arguments:?}: {err}");
        let cause = format!("the texts at byte {heap} are damaged, copy the file again or make it anew");
        assert!(err.starts_with("error: bad.h5: ") && err.contains(&cause), "{arguments:?}: {err}");
    }
}

#[test]
fn shape_larger_than_the_file_is_refused_before_memory_is_taken_for_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    std::fs::write(at.join("bad.h5"), result(at).0).expect("written");
    let file = hdf5::File::open_rw(at.join("bad.h5")).expect("writable");
    // Eight terabytes of which nothing is stored: reading them takes as much memory.
    file.unlink("energies/total").expect("removed");
    file.new_dataset::<f64>().chunk(256).shape(1_usize << 40).create("energies/total").expect("created");
    file.close().expect("closed");
    for arguments in [&["info", "bad.h5"][..], &["plot", "bad.h5", "-o", "figures"]] {
        let (code, err) = fbimpact(at, arguments);
        assert_eq!(code, Some(6), "{err}");
        let cause = "/energies/total claims shape [1099511627776], which is more than the file holds";
        assert!(err.starts_with("error: bad.h5: ") && err.contains(cause), "{err}");
    }
}
