//! The series of contacts, `/contacts/NAME` and `/pressure/NAME`.
//!
//! Contacts that have had the same row ever since share their datasets: several names lead to one group. So thousands of pairs that never
//! meet cost a name each, and a contact gets datasets of its own, which read as the shared ones for the time before, when it first differs.

use adaptive::record::Sample;
use hdf5::plist::group_create::LinkPhaseChange;
use hdf5::{File, Group};

use super::super::columns::{Axes, CONTACT, CONTACT_COUNTS, Column, Declaration};
use super::super::disk_space::{BYTES_OF_DATASET, DiskSpace};
use super::super::fault::RecordingFault;
use super::super::journal::ContactRow;
use super::super::pressure::Pressures;
use super::super::series::Past;
use super::{DATASETS_PER_GROUP, Recorded};

/// Group of the contacts' numbers.
const NUMBERS: &str = "contacts";
/// Group of the pressures of those that have carried force at points.
const PRESSURES: &str = "pressure";

/// All contacts of a run.
#[derive(Default)]
pub(super) struct Contacts {
    names: Vec<String>,
    /// Which datasets the name of each contact leads to.
    places: Vec<usize>,
    shelves: Vec<Shelf>,
    /// Rows in the datasets, and in the buffers.
    written: usize,
    buffered: usize,
    /// Bytes on the disk that writing what is buffered may take.
    room: u64,
    row: ContactRow,
}

/// The datasets of one contact or of several.
struct Shelf {
    columns: Vec<Column<f64>>,
    counts: Vec<Column<u32>>,
    pressures: Option<Pressures>,
    /// The row of the last instant; without numbers before the first.
    row: ContactRow,
    /// How many contacts have it.
    users: usize,
}

impl Shelf {
    /// Creates the datasets of contact `name`; rows like `blank` precede, so many in datasets and in buffers as `past` says.
    fn create(
        file: &File,
        name: &str,
        axes: &Axes,
        past: [usize; 2],
        blank: ContactRow,
    ) -> hdf5::Result<Self> {
        let [written, buffered] = past;
        let numbers = group(file, NUMBERS, name)?;
        let mut place = 0;
        let columns = CONTACT.iter().map(|d| {
            let value = blank.numbers.get(place).copied().unwrap_or_default();
            let column = Column::late(Past { written, buffered, value }, &numbers, d, 0, axes, None)?;
            place += column.series.width();
            Ok(column)
        });
        let columns = columns.collect::<hdf5::Result<Vec<_>>>()?;
        let counts = CONTACT_COUNTS.iter().enumerate().map(|(k, d)| {
            let value = blank.counts.get(k).copied().unwrap_or_default();
            Column::late(Past { written, buffered, value }, &numbers, d, 0, axes, None)
        });
        Ok(Self {
            counts: counts.collect::<hdf5::Result<_>>()?,
            pressures: None,
            columns,
            row: blank,
            users: 1,
        })
    }

    /// Buffers the row of an instant.
    fn push(&mut self) {
        let (mut numbers, mut counts) = (self.row.numbers.as_slice(), self.row.counts.as_slice());
        self.columns.iter_mut().for_each(|column| _ = column.push_row(&mut numbers));
        self.counts.iter_mut().for_each(|column| _ = column.push_row(&mut counts));
        self.pressures.iter_mut().for_each(|pressures| pressures.push(&self.row.points));
    }

    /// Bytes on the disk that writing what is buffered up to the next flush may take, with its entries in the lists of the scales.
    fn bytes_needed(&self) -> u64 {
        BYTES_OF_DATASET
            + self.columns.iter().map(|c| c.series.bytes_needed()).sum::<u64>()
            + self.counts.iter().map(|c| c.series.bytes_needed()).sum::<u64>()
            + self.pressures.as_ref().map_or(0, Pressures::bytes_needed)
    }
}

/// The group `name` of a contact in the group `of`.
fn group(file: &File, of: &str, name: &str) -> hdf5::Result<Group> {
    // No heap for names as few as these.
    let few = LinkPhaseChange { max_compact: DATASETS_PER_GROUP as u32, min_dense: 1 };
    file.group(of)?.create_group_builder().with_gcpl(|p| p.link_phase_change(few)).create(name)
}

/// Has the name `name` lead to what the name `to` leads to.
fn lead(file: &File, name: &str, to: &str) -> hdf5::Result<()> {
    file.link_hard(&format!("/{NUMBERS}/{to}"), &format!("/{NUMBERS}/{name}"))
}

impl Contacts {
    /// One group for all of them, while nothing is known.
    pub fn create(file: &File, names: &[String], axes: &Axes) -> hdf5::Result<Self> {
        [NUMBERS, PRESSURES].iter().try_for_each(|of| file.create_group(of).map(|_| ()))?;
        let Some((first, others)) = names.split_first() else { return Ok(Self::default()) };
        let shelf = Shelf::create(file, first, axes, [0, 0], ContactRow::default())?;
        others.iter().try_for_each(|name| lead(file, name, first))?;
        Ok(Self {
            names: names.to_vec(),
            room: shelf.bytes_needed(),
            places: vec![0; names.len()],
            shelves: vec![Shelf { users: names.len(), ..shelf }],
            ..Self::default()
        })
    }

    /// Number of contacts.
    pub fn len(&self) -> usize {
        self.names.len()
    }

    /// The rows of those contacts that do not have that of the instant before, or carry force.
    pub fn changed(&mut self, sample: &Sample) -> Vec<ContactRow> {
        let Self { places, shelves, row, .. } = self;
        let rows = places.iter().enumerate().filter_map(|(i, place)| {
            row.contact = i as u32;
            row.numbers.clear();
            row.counts.clear();
            row.points.clear();
            CONTACT.iter().for_each(|d| (d.extract)(sample, i, &mut row.numbers));
            CONTACT_COUNTS.iter().for_each(|d| (d.extract)(sample, i, &mut row.counts));
            row.points.extend(sample.pressures.get(i).into_iter().flatten());
            (!row.is_same(&shelves[*place].row)).then(|| row.clone())
        });
        rows.collect()
    }

    /// Stores an instant; false if a row fits no contact.
    pub fn push(
        &mut self,
        file: &File,
        space: &mut DiskSpace,
        axes: &Axes,
        rows: &[ContactRow],
    ) -> Recorded<bool> {
        for row in rows {
            let i = row.contact as usize;
            if i >= self.len() || !row.is_whole() {
                return Ok(false);
            }
            self.place(i, row, file, space, axes)?;
            let shelf = &mut self.shelves[self.places[i]];
            if shelf.pressures.is_none() && !row.points.is_empty() {
                let room = DATASETS_PER_GROUP as u64 * BYTES_OF_DATASET;
                space.reserve(file.size(), self.room + room).map_err(RecordingFault::Space)?;
                let group = group(file, PRESSURES, &self.names[i])?;
                shelf.pressures = Some(Pressures::create(&group, &axes.space, axes.storage)?);
            }
        }
        self.shelves.iter_mut().for_each(Shelf::push);
        self.buffered += 1;
        self.room = self.shelves.iter().map(Shelf::bytes_needed).sum();
        Ok(true)
    }

    /// Gives contact `i` a shelf that is to have this row.
    fn place(
        &mut self,
        i: usize,
        row: &ContactRow,
        file: &File,
        space: &mut DiskSpace,
        axes: &Axes,
    ) -> Recorded<()> {
        let is_first = self.written + self.buffered == 0;
        let shelf = &mut self.shelves[self.places[i]];
        if row.is_same(&shelf.row) {
            return Ok(());
        }
        if shelf.users == 1 || is_first && shelf.row.numbers.is_empty() && row.is_plain() {
            shelf.row.clone_from(row);
            return Ok(());
        }
        shelf.users -= 1;
        let before = shelf.row.clone();
        file.group(NUMBERS)?.unlink(&self.names[i])?;
        let equal = self
            .shelves
            .iter_mut()
            .enumerate()
            .find(|(_, s)| is_first && row.is_plain() && row.is_same(&s.row));
        if let Some((place, shelf)) = equal {
            shelf.users += 1;
            self.places[i] = place;
            return Ok(lead(file, &self.names[i], &self.names[shelf.row.contact as usize])?);
        }
        let room = DATASETS_PER_GROUP as u64 * BYTES_OF_DATASET;
        space.reserve(file.size(), self.room + room).map_err(RecordingFault::Space)?;
        let past = [self.written, self.buffered];
        let shelf = Shelf::create(file, &self.names[i], axes, past, before)?;
        self.room += shelf.bytes_needed();
        self.places[i] = self.shelves.len();
        self.shelves.push(Shelf { row: row.clone(), ..shelf });
        Ok(())
    }

    /// Bytes on the disk that writing what is buffered may take.
    pub fn bytes_needed(&self) -> u64 {
        self.room
    }

    /// Appends what is buffered to the datasets.
    pub fn write(&mut self) -> hdf5::Result<()> {
        for Shelf { columns, counts, pressures, .. } in &mut self.shelves {
            columns.iter_mut().try_for_each(|c| c.series.write())?;
            // The lists before their lengths: no instant has more points than there are.
            pressures.iter_mut().try_for_each(Pressures::write)?;
            counts.iter_mut().try_for_each(|c| c.series.write())?;
        }
        self.written += std::mem::take(&mut self.buffered);
        Ok(())
    }
}

impl ContactRow {
    /// Whether all numbers are there.
    fn is_whole(&self) -> bool {
        let width: usize = CONTACT.iter().map(Declaration::components).sum();
        self.numbers.len() == width && self.counts.len() == CONTACT_COUNTS.len()
    }

    /// Whether others may share it: no point carries force, and one value fills each dataset.
    fn is_plain(&self) -> bool {
        let mut numbers = self.numbers.as_slice();
        let is_filled = |d: &Declaration<f64>| {
            let own = numbers.split_off(..d.components()).unwrap_or_default();
            own.iter().all(|x| x.to_bits() == own[0].to_bits())
        };
        self.points.is_empty() && CONTACT.iter().all(is_filled)
    }

    /// Whether `other` has the same numbers, to the last bit, and no points carry force.
    fn is_same(&self, other: &Self) -> bool {
        self.points.is_empty()
            && other.points.is_empty()
            && self.counts == other.counts
            && self.numbers.len() == other.numbers.len()
            && self.numbers.iter().zip(&other.numbers).all(|(a, b)| a.to_bits() == b.to_bits())
    }
}
