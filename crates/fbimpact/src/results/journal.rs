//! The restart file of a run, `<output>.restart`: everything reported so far, and states from which
//! the run can be taken up.
//!
//! Records are appended and never changed, each in the encoding of postcard with its length before
//! and a checksum behind it: whenever the process dies, and whatever that does to the HDF5 file,
//! the records up to the last restart point are whole. A run that is taken up writes its HDF5 file
//! anew from them.

use std::fs::{File, OpenOptions};
use std::io::{BufReader, BufWriter, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use adaptive::record::warning::Warning;
use adaptive::record::{EventRecord, ImpactRecord, PhaseRecord, PressurePoint, TransferRecord, TrialRecord};
use adaptive::state::RunState;
use result_files::file::fault::{Access, FileError, FileFault};
use result_files::file::plain_file;
use result_files::file::whole_file;
use serde::{Deserialize, Serialize};

use crate::process::provenance;
use crate::scenario::Scenario;

/// First bytes of the file; the last one is the version of the format.
const MAGIC: &[u8; 17] = b"fbimpact restart\x0b";
/// Bytes collected before they are written; restart points are written at once.
const BUFFER: usize = 1 << 20;
/// Longest record that can be meant: a damaged length must not ask for more memory than there is.
const LONGEST: u64 = 1 << 32;

/// What a run was started from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Header {
    /// Version of the program.
    pub version: String,
    /// Commit that it was built from.
    pub commit: String,
    /// The scenario file as named on the command line.
    pub scenario: String,
    /// The same from the root of the file system, for the files that the scenario names.
    pub absolute: String,
    /// SHA-256 of the scenario file.
    pub sha256: String,
    /// SHA-256 of what the result follows from, see [`crate::scenario::Source`].
    pub inputs_sha256: String,
    /// The scenario with overrides applied and defaults filled in.
    pub resolved: String,
}

impl Header {
    /// The header of a run of `scenario` with this program.
    pub fn new(scenario: &Scenario) -> Self {
        let path = &scenario.source.path;
        let absolute = std::path::absolute(path).unwrap_or_else(|_| path.clone());
        Self {
            version: provenance::VERSION.to_owned(),
            commit: provenance::build().commit.to_owned(),
            scenario: path.display().to_string(),
            absolute: absolute.display().to_string(),
            sha256: scenario.source.sha256.clone(),
            inputs_sha256: scenario.source.inputs_sha256.clone(),
            resolved: scenario.source.resolved.clone(),
        }
    }
}

/// A record of the file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Entry {
    /// What the run was started from; comes first.
    Header(Header),
    /// How many numbers each row of every series has: of series of floating-point numbers, then of
    /// series of counts; then the number of contacts, whose series are not among them.
    Layout(Vec<u64>),
    /// A row of all series.
    Row(Row),
    /// A finished phase.
    Phase(PhaseRecord),
    /// A finished impact.
    Impact(ImpactRecord),
    /// What a contact did.
    Event(EventRecord),
    /// A finished try.
    Trial(TrialRecord),
    /// A change of the model.
    Transfer(Box<TransferRecord>),
    /// A state from which the run can be taken up.
    Restart(Box<RunState>),
    /// The run was taken up here.
    Resumed,
    /// A warning.
    Warning(Warning),
}

/// A row of all series.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Floating-point numbers, series after series.
    pub numbers: Vec<f64>,
    /// Counts, series after series.
    pub counts: Vec<u32>,
    /// Those contacts that do not have the row of the instant before.
    pub contacts: Vec<ContactRow>,
}

/// A row of the series of a contact.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ContactRow {
    /// Index of the contact.
    pub contact: u32,
    /// Floating-point numbers, series after series.
    pub numbers: Vec<f64>,
    /// Counts, series after series.
    pub counts: Vec<u32>,
    /// Points that carry force.
    pub points: Vec<PressurePoint>,
}

/// A restart file that is written.
pub struct Journal {
    writer: BufWriter<File>,
    /// Bytes of a record.
    payload: Vec<u8>,
}

impl Journal {
    fn to(file: File) -> Self {
        Self { writer: BufWriter::with_capacity(BUFFER, file), payload: Vec::new() }
    }

    /// Creates the file `path`, or replaces it; it is there with its header or not at all, whenever
    /// the process is killed.
    ///
    /// # Errors
    /// [`FileError`] if it cannot be written.
    pub fn create(path: &Path, header: Header) -> Result<Self, FileError> {
        let mut created = None;
        let written: std::io::Result<()> = whole_file::replace(path, |part| {
            let mut journal = Self::to(File::create(part)?);
            journal.writer.write_all(MAGIC)?;
            journal.append(&Entry::Header(header))?;
            journal.flush()?;
            created = Some(journal);
            Ok(())
        });
        let fail = |e: std::io::Error| FileError::new(path, FileFault::system(Access::Write, e));
        written.map_err(fail)?;
        Ok(created.expect("what was written was created"))
    }

    /// Opens the file `path` to go on behind its first `length` bytes; what comes after them is
    /// lost.
    ///
    /// # Errors
    /// [`FileError`] if it cannot be written.
    fn go_on(path: &Path, length: u64) -> Result<Self, FileError> {
        let open = || {
            let mut file = OpenOptions::new().write(true).open(path)?;
            file.set_len(length)?;
            file.seek(SeekFrom::End(0))?;
            Ok(Self::to(file))
        };
        open().map_err(|e: std::io::Error| FileError::new(path, FileFault::system(Access::Write, e)))
    }

    /// Appends a record.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn append(&mut self, entry: &Entry) -> std::io::Result<()> {
        let mut payload = std::mem::take(&mut self.payload);
        payload.clear();
        self.payload = postcard::to_extend(entry, payload).map_err(std::io::Error::other)?;
        self.writer.write_all(&(self.payload.len() as u64).to_le_bytes())?;
        self.writer.write_all(&self.payload)?;
        self.writer.write_all(&checksum(&self.payload).to_le_bytes())
    }

    /// Writes what is buffered.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn flush(&mut self) -> std::io::Result<()> {
        self.writer.flush()
    }
}

/// FNV-1a, on words of eight bytes for speed: it guards against records cut short and disks that
/// lie, not against people.
fn checksum(payload: &[u8]) -> u64 {
    const PRIME: u64 = 0x0000_0100_0000_01b3;
    const OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
    let mix = |hash: u64, word: u64| {
        let mixed = (hash ^ word).wrapping_mul(PRIME);
        mixed ^ (mixed >> 32) // high bits of a word reach the low ones of the sum
    };
    let (words, rest) = payload.as_chunks::<8>();
    let hash = words.iter().fold(OFFSET, |h, w| mix(h, u64::from_le_bytes(*w)));
    rest.iter().fold(mix(hash, payload.len() as u64), |h, b| mix(h, u64::from(*b)))
}

/// Whether `path` is a restart file, of whatever version.
pub fn is_own(path: &Path) -> bool {
    let mut begin = [0; MAGIC.len() - 1];
    plain_file::open(path).and_then(|mut file| file.read_exact(&mut begin)).is_ok()
        && MAGIC.starts_with(&begin)
}

/// Reads the records of a restart file one after the other, up to the first that is not whole.
pub struct Entries {
    reader: BufReader<File>,
    path: PathBuf,
    position: u64,
}

impl Entries {
    /// Opens the file `path`.
    ///
    /// # Errors
    /// [`FileError`] if it cannot be read or is no restart file of this version.
    pub fn open(path: &Path) -> Result<Self, FileError> {
        let cannot = |e: std::io::Error| FileError::new(path, FileFault::system(Access::Read, e));
        let mut reader = BufReader::with_capacity(BUFFER, plain_file::open(path).map_err(cannot)?);
        let mut magic = [0; MAGIC.len()];
        match reader.read_exact(&mut magic) {
            Err(e) if e.kind() != ErrorKind::UnexpectedEof => return Err(cannot(e)),
            Ok(()) if magic == *MAGIC => {}
            Ok(()) if magic[..MAGIC.len() - 1] == MAGIC[..MAGIC.len() - 1] => {
                return Err(FileError::new(
                    path,
                    "was written by another version of the program, start the run anew".into(),
                ));
            }
            _ => {
                return Err(FileError::new(path, "is damaged or no restart file, start the run anew".into()));
            }
        }
        Ok(Self { reader, path: path.to_owned(), position: MAGIC.len() as u64 })
    }

    /// Bytes read so far.
    pub fn position(&self) -> u64 {
        self.position
    }

    /// The next record; `None` at the end, or where the file is not whole.
    ///
    /// # Errors
    /// [`FileError`] if the file cannot be read.
    pub fn next_entry(&mut self) -> Result<Option<Entry>, FileError> {
        match self.read() {
            Ok(entry) => Ok(entry),
            Err(e) if e.kind() == ErrorKind::UnexpectedEof => Ok(None),
            Err(e) => Err(FileError::new(&self.path, FileFault::system(Access::Read, e))),
        }
    }

    fn read(&mut self) -> std::io::Result<Option<Entry>> {
        let mut word = [0; 8];
        self.reader.read_exact(&mut word)?;
        let length = u64::from_le_bytes(word);
        if length > LONGEST {
            return Ok(None);
        }
        let mut payload = Vec::new();
        // Not read in one go: a damaged length must not reserve memory for what is not there.
        let n = self.reader.by_ref().take(length).read_to_end(&mut payload)?;
        if n as u64 != length {
            return Ok(None);
        }
        self.reader.read_exact(&mut word)?;
        if checksum(&payload) != u64::from_le_bytes(word) {
            return Ok(None);
        }
        self.position += 8 + length + 8;
        let entry = postcard::take_from_bytes(&payload).ok();
        Ok(entry.and_then(|(entry, rest)| rest.is_empty().then_some(entry)))
    }
}

/// What a restart file tells about the run to be taken up.
#[derive(Debug, Clone, PartialEq)]
pub struct Restart {
    /// The file.
    pub path: PathBuf,
    /// What the run was started from.
    pub header: Header,
    /// The last state to take it up from; `None` if it died before the first one.
    pub point: Option<RunState>,
    /// Bytes up to that point.
    pub length: u64,
    /// How often it was taken up before.
    pub resumptions: u32,
}

impl Restart {
    /// Opens the file to go on behind the restart point, and notes that.
    ///
    /// # Errors
    /// [`FileError`] if it cannot be written.
    pub fn go_on(&self) -> Result<Journal, FileError> {
        let mut journal = Journal::go_on(&self.path, self.length)?;
        let mut note = || match &self.point {
            // The mark lies before a restart point, as all that counts.
            Some(point) => {
                journal.append(&Entry::Resumed)?;
                journal.append(&Entry::Restart(Box::new(point.clone())))?;
                journal.flush()
            }
            None => {
                (0..=self.resumptions).try_for_each(|_| journal.append(&Entry::Resumed))?;
                journal.flush()
            }
        };
        note().map_err(|e| FileError::new(&self.path, FileFault::system(Access::Write, e)))?;
        Ok(journal)
    }
}

/// Reads the restart file `path`.
///
/// # Errors
/// [`FileError`] if it cannot be read or is damaged at its beginning.
pub fn read(path: &Path) -> Result<Restart, FileError> {
    let mut entries = Entries::open(path)?;
    let Some(Entry::Header(header)) = entries.next_entry()? else {
        return Err(FileError::new(path, "is damaged, start the run anew".into()));
    };
    let mut restart =
        Restart { path: path.to_owned(), header, point: None, length: entries.position(), resumptions: 0 };
    let mut resumptions = 0;
    while let Some(entry) = entries.next_entry()? {
        match entry {
            Entry::Restart(point) => {
                (restart.point, restart.length) = (Some(*point), entries.position());
                restart.resumptions = resumptions;
            }
            Entry::Resumed => resumptions += 1,
            _ => {}
        }
    }
    // Without a restart point there is nothing between the header and the marks of those who found
    // none.
    if restart.point.is_none() {
        restart.resumptions = resumptions;
    }
    Ok(restart)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header() -> Header {
        let text = || "text".to_owned();
        Header {
            version: text(),
            commit: text(),
            scenario: text(),
            absolute: text(),
            sha256: text(),
            inputs_sha256: text(),
            resolved: "title = \"µ\"".into(),
        }
    }

    fn point(time: f64) -> RunState {
        RunState { time, state: vec![time; 3], ..RunState::default() }
    }

    fn written(path: &Path) -> Vec<u8> {
        let mut journal = Journal::create(path, header()).expect("writable");
        let phase = Entry::Phase(PhaseRecord { end: 0.5, ..PhaseRecord::default() });
        let row = Entry::Row(Row { counts: vec![1, 2, 3], ..Row::default() });
        let entries = [
            Entry::Restart(Box::new(point(0.1))),
            row.clone(),
            phase,
            Entry::Restart(Box::new(point(0.5))),
            row.clone(),
            row,
        ];
        entries.iter().for_each(|e| journal.append(e).expect("writable"));
        journal.flush().expect("writable");
        std::fs::read(path).expect("readable")
    }

    #[test]
    fn whatever_is_cut_off_the_last_whole_restart_point_is_found() {
        let directory = tempfile::tempdir().expect("a directory");
        let path = directory.path().join("a.restart");
        let bytes = written(&path);
        let whole = read(&path).expect("whole");
        assert_eq!((&whole.header, &whole.point), (&header(), &Some(point(0.5))));
        let (mut seen, mut first) = (Vec::new(), bytes.len());
        for n in (0..bytes.len()).rev() {
            std::fs::write(&path, &bytes[..n]).expect("writable");
            match read(&path) {
                Ok(found) => {
                    assert!(found.length <= n as u64);
                    seen.push(found.point.map(|p| p.time));
                    first = n;
                }
                Err(e) => assert!(e.to_string().contains("start the run anew"), "{e}"),
            }
        }
        seen.dedup();
        assert_eq!(seen, [Some(0.5), Some(0.1), None]);
        assert!(first > MAGIC.len(), "without the header there is no run");
    }

    #[test]
    fn no_changed_byte_is_taken_for_another_state() {
        let directory = tempfile::tempdir().expect("a directory");
        let path = directory.path().join("a.restart");
        let bytes = written(&path);
        for i in 0..bytes.len() {
            let mut changed = bytes.clone();
            changed[i] ^= 0x10;
            std::fs::write(&path, &changed).expect("writable");
            if let Ok(found) = read(&path) {
                assert_eq!(found.header, header(), "byte {i}");
                assert!(found.point.is_none_or(|p| p == point(0.1) || p == point(0.5)), "byte {i}");
            }
        }
    }

    #[test]
    fn states_come_back_to_the_last_bit() {
        let directory = tempfile::tempdir().expect("a directory");
        let path = directory.path().join("a.restart");
        let state = vec![1.0 / 3.0, -0.0, f64::MIN_POSITIVE / 8.0, f64::INFINITY, f64::from_bits(u64::MAX)];
        let point = RunState { state: state.clone(), n_refined: u64::MAX, ..RunState::default() };
        let mut journal = Journal::create(&path, header()).expect("writable");
        journal.append(&Entry::Restart(Box::new(point))).and_then(|()| journal.flush()).expect("writable");
        let found = read(&path).expect("readable").point.expect("there");
        let bits = |list: &[f64]| list.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert_eq!((bits(&found.state), found.n_refined), (bits(&state), u64::MAX));
    }

    #[test]
    fn files_of_another_version_are_refused() {
        let directory = tempfile::tempdir().expect("a directory");
        let path = directory.path().join("a.restart");
        let mut bytes = written(&path);
        bytes[MAGIC.len() - 1] -= 1;
        std::fs::write(&path, &bytes).expect("writable");
        let error = read(&path).expect_err("of another version");
        assert!(error.to_string().contains("another version of the program"), "{error}");
    }

    #[test]
    fn a_file_that_goes_on_keeps_what_came_before() {
        let directory = tempfile::tempdir().expect("a directory");
        let path = directory.path().join("a.restart");
        written(&path);
        for n in 1..3 {
            let found = read(&path).expect("readable");
            drop(found.go_on().expect("writable"));
            let found = read(&path).expect("readable");
            assert_eq!((found.resumptions, found.point), (n, Some(point(0.5))));
        }
        let mut entries = Entries::open(&path).expect("readable");
        let mut rows = 0;
        while let Some(entry) = entries.next_entry().expect("readable") {
            rows += u32::from(matches!(entry, Entry::Row(_)));
        }
        assert_eq!(rows, 1, "rows behind the restart point are gone");
    }
}
