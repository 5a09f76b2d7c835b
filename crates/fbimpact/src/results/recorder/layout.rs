//! The datasets of a run: which there are follows from its bodies, contacts, points, joints and
//! gears.

use adaptive::record::{BodyLayout, JointLayout, NameAndUnit, PointLayout, RunLayout};
use hdf5::{Group, Result};
use ndarray::ArrayView1;
use result_files::dataset::scales::Scale;
use result_files::dataset::{component_scale, describe, text_attribute};
use result_files::stored::members::{ARRAYS, NAMES};
use result_files::stored::open::VERSION_OF_ARRAYS;

use super::super::columns::{self, Axes, Axis, Column, Declaration};
use super::super::disk_space::BYTES_OF_DATASET;
use super::super::fault::RecordingFault;
use super::super::series::Storage;
use super::super::stress::tensor_scale;
use super::contacts::Contacts;
use super::{DATASETS_PER_GROUP, FileForm, Open, Recorded};

impl Open {
    /// Creates the datasets of everything that is stored at every instant.
    pub(super) fn layout(&mut self, layout: &RunLayout, form: FileForm) -> Recorded<()> {
        let file = self.file.clone();
        self.contact_names = layout.contacts.iter().chain(&layout.stops).cloned().collect();
        // All contacts share the datasets of one, and need a name each.
        let has_group = |body: &&BodyLayout| !form.arrays || !body.eigenfrequencies.is_empty();
        let (bodies, contacts) = (layout.bodies.iter().filter(has_group).count(), layout.contacts.len());
        let groups = 2 + bodies + layout.points.len() + layout.joints.len() + layout.gears.len();
        let bytes = (DATASETS_PER_GROUP * groups + contacts) as u64 * BYTES_OF_DATASET;
        self.disk_space.reserve(file.size(), bytes).map_err(RecordingFault::Space)?;
        let storage = Storage::of(DATASETS_PER_GROUP * (groups + contacts), form.compression);
        self.block = storage.rows;
        let time = Column::bare(&file, &columns::TIME, storage)?;
        let time_scale = Scale::new(time.series.dataset().clone(), "time")?;
        self.columns.push(time);
        let space = component_scale(&file, "xyz", &["x", "y", "z"], "Components of vectors in space.")?;
        let labels = ["w", "x", "y", "z"];
        let quaternion = component_scale(&file, "wxyz", &labels, "Components of quaternions.")?;
        let axes = Axes { time: time_scale, space, quaternion, storage };
        self.counts.push(Column::create(&file, &columns::PHASE, 0, &axes, None)?);
        self.group(&file.create_group("energies")?, &columns::ENERGIES, 0, &axes)?;
        self.group(&file.create_group("momentum")?, &columns::MOMENTUM, 0, &axes)?;
        let bodies = file.create_group("bodies")?;
        let is_own = |d: &&Declaration<f64>| !form.arrays || d.axis == Axis::Mode;
        for (i, body) in layout.bodies.iter().enumerate().filter(|(_, body)| has_group(body)) {
            let group = bodies.create_group(&body.name)?;
            let modes = eigenfrequencies(&group, body)?;
            let there = columns::BODY.iter().filter(|d| d.axis != Axis::Mode || modes.is_some());
            for d in there.filter(is_own) {
                self.columns.push(Column::create(&group, d, i, &axes, modes.as_ref())?);
            }
            modes.as_ref().map_or(Ok(()), Scale::finish)?;
        }
        if form.arrays {
            let group = file.create_group(ARRAYS)?.create_group("bodies")?;
            let names: Vec<&str> = layout.bodies.iter().map(|body| body.name.as_str()).collect();
            let names = component_scale(&group, NAMES, &names, "Names of the bodies.")?;
            for d in columns::BODY.iter().filter(|d| !is_own(d)) {
                self.columns.push(Column::of_all(&group, d, &names, &axes)?);
            }
            names.finish()?;
            file.attr("format_version")?.write_scalar(&VERSION_OF_ARRAYS)?;
        }
        self.contacts = Contacts::create(&file, &layout.contacts, &axes)?;
        let points = file.create_group("points")?;
        for (i, point) in layout.points.iter().enumerate() {
            self.point(&points.create_group(&point.name)?, point, i, &axes)?;
        }
        let joints = file.create_group("joints")?;
        for (i, joint) in layout.joints.iter().enumerate() {
            self.joint(&joints.create_group(&joint.name)?, joint, i, &axes)?;
        }
        if !layout.gears.is_empty() {
            let gears = file.create_group("gears")?;
            for (i, (name, unit)) in layout.gears.iter().enumerate() {
                let group = gears.create_group(name)?;
                let column = Column::create(&group, &columns::GEAR, i, &axes, None)?;
                text_attribute(column.series.dataset(), "unit", unit)?;
                self.columns.push(column);
            }
        }
        axes.finish()?;
        self.axes = Some(axes);
        self.room = self.columns.iter().map(|c| c.series.bytes_needed()).sum::<u64>()
            + self.counts.iter().map(|c| c.series.bytes_needed()).sum::<u64>();
        Ok(self.flush()?)
    }

    /// Datasets of an observed point: its motion, and stress and strain if they are wanted.
    fn point(&mut self, group: &Group, point: &PointLayout, index: usize, axes: &Axes) -> Result<()> {
        self.group(group, &columns::POINT, index, axes)?;
        if !point.gauge.is_any() {
            return Ok(());
        }
        let scale = tensor_scale(group, point.is_axisymmetric)?;
        let stress = columns::POINT_STRESS.iter().filter(|_| point.gauge.stress);
        let strain = columns::POINT_STRAIN.iter().filter(|_| point.gauge.strain);
        for d in stress.chain(strain) {
            self.columns.push(Column::create(group, d, index, axes, Some(&scale))?);
        }
        scale.finish()
    }

    /// Datasets of a joint: its coordinates, if it has any, and its reaction.
    fn joint(&mut self, group: &Group, joint: &JointLayout, index: usize, axes: &Axes) -> Result<()> {
        text_attribute(group, "type", &joint.kind)?;
        let both = columns::JOINT.iter().zip([&joint.positions, &joint.velocities]);
        for (d, names) in both.filter(|(_, names)| !names.is_empty()) {
            let labels: Vec<&str> = names.iter().map(|(name, _)| name.as_str()).collect();
            let about = format!("Names of the {}.", d.name);
            let scale = component_scale(group, &format!("{}_names", d.name), &labels, &about)?;
            let column = Column::create(group, d, index, axes, Some(&scale))?;
            text_attribute(column.series.dataset(), "unit", &joined_units(names))?;
            scale.finish()?;
            self.columns.push(column);
        }
        self.group(group, &columns::REACTION, index, axes)
    }

    fn group(
        &mut self,
        group: &Group,
        declarations: &[Declaration<f64>],
        index: usize,
        axes: &Axes,
    ) -> Result<()> {
        for d in declarations {
            self.columns.push(Column::create(group, d, index, axes, None)?);
        }
        Ok(())
    }
}

/// The unit of all coordinates, or their units in order.
fn joined_units(names: &[NameAndUnit]) -> String {
    let units: Vec<&str> = names.iter().map(|(_, unit)| unit.as_str()).collect();
    match units.split_first() {
        Some((first, rest)) if rest.iter().all(|u| u == first) => (*first).to_owned(),
        _ => units.join(", "),
    }
}

fn eigenfrequencies(group: &Group, body: &BodyLayout) -> Result<Option<Scale>> {
    if body.eigenfrequencies.is_empty() {
        return Ok(None);
    }
    let write = |name: &str, values: &[f64], description: &str| {
        let dataset = group.new_dataset::<f64>().shape(values.len()).create(name)?;
        dataset.write(ArrayView1::from(values))?;
        describe(&dataset, "Hz", description)?;
        Ok::<_, hdf5::Error>(dataset)
    };
    if !body.frequency_bands.is_empty() {
        let description = "By how much the mesh may put them off; NaN where that is not known.";
        write("eigenfrequencies_uncertainty", &body.frequency_bands, description)?;
    }
    let description = "Eigenfrequencies of the elastic coordinates.";
    let dataset = write("eigenfrequencies", &body.eigenfrequencies, description)?;
    Scale::new(dataset, "eigenfrequencies").map(Some)
}
