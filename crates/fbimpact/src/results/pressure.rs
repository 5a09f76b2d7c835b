//! Contact pressure: the points that carry force at each stored instant, one list per contact, and
//! where they lie.

use std::collections::HashMap;

use adaptive::record::PressurePoint;
use hdf5::{Group, Result};
use result_files::dataset::describe;
use result_files::dataset::scales::{self, Scale};
use result_files::stored::pressure_series::{AREA, POINT, POSITION, PRESSURE};

use super::series::{Series, Storage};

/// Bits that tell points apart.
type Key = [u64; 4];

/// Pressures of one contact.
pub struct Pressures {
    position: Series<f64>,
    area: Series<f64>,
    point: Series<u32>,
    pressure: Series<f32>,
    known: HashMap<Key, u32>,
}

impl Pressures {
    /// Creates the datasets in `group`; `space` is the scale of x, y, z.
    pub fn create(group: &Group, space: &Scale, storage: Storage) -> Result<Self> {
        let pressures = Self {
            position: Series::create(group, POSITION.0, &[3], storage, None)?,
            area: Series::create(group, AREA.0, &[], storage, None)?,
            point: Series::create(group, POINT.0, &[], storage, None)?,
            pressure: Series::create(group, PRESSURE.0, &[], storage, None)?,
            known: HashMap::new(),
        };
        let (area, point) = (pressures.area.dataset(), pressures.point.dataset());
        let all = [
            (pressures.position.dataset(), POSITION),
            (area, AREA),
            (point, POINT),
            (pressures.pressure.dataset(), PRESSURE),
        ];
        for (dataset, (_, unit, description)) in all {
            describe(dataset, unit, description)?;
        }
        // Each table of equal length has an axis of its own.
        let (area, point) = (Scale::new(area.clone(), AREA.0)?, Scale::new(point.clone(), POINT.0)?);
        scales::attach(pressures.position.dataset(), &[(&area, AREA.0), (space, "xyz")])?;
        scales::attach(pressures.pressure.dataset(), &[(&point, POINT.0)])?;
        [area, point].iter().try_for_each(Scale::finish)?;
        Ok(pressures)
    }

    /// Buffers the points of an instant.
    pub fn push(&mut self, points: &[PressurePoint]) {
        points.iter().for_each(|point| self.add(point));
    }

    fn add(&mut self, p: &PressurePoint) {
        let [x, y, z] = p.position.map(f64::to_bits);
        let next = self.known.len() as u32;
        let index = *self.known.entry([x, y, z, p.area.to_bits()]).or_insert(next);
        if index == next {
            self.position.buffer.extend(p.position);
            self.area.buffer.push(p.area);
        }
        self.point.buffer.push(index);
        self.pressure.buffer.push(p.pressure as f32);
    }

    /// Bytes on the disk that writing the buffers may take.
    pub fn bytes_needed(&self) -> u64 {
        self.position.bytes_of_buffer()
            + self.area.bytes_of_buffer()
            + self.point.bytes_of_buffer()
            + self.pressure.bytes_of_buffer()
    }

    /// Appends what is buffered to the datasets.
    pub fn write(&mut self) -> Result<()> {
        self.position.write()?;
        self.area.write()?;
        self.point.write()?;
        self.pressure.write()
    }
}
