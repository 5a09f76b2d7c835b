//! Which time series a result file has: path, unit, description, and where each comes from in a
//! sample.

use std::ops::Range;

use adaptive::record::{Sample, Timings};
use hdf5::{Group, H5Type, Result};
use result_files::dataset::describe;
use result_files::dataset::scales::{self, Scale};
use result_files::stored::pressure_series as pressure;
use result_files::stored::stages::STAGES;

use super::series::{Past, Series, Storage};

/// Second dimension of a series.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// One value per row.
    Scalar,
    /// x, y, z.
    Space,
    /// w, x, y, z.
    Quaternion,
    /// One value an elastic coordinate.
    Mode,
    /// One value a coordinate of a joint.
    Coordinate,
    /// Six components of a tensor.
    Tensor,
}

/// Declaration of a series; `extract` appends the values of entry `index` of the sample.
pub struct Declaration<T> {
    /// Name in its group.
    pub name: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Second dimension.
    pub axis: Axis,
    /// One sentence.
    pub description: &'static str,
    /// Reads the values.
    pub extract: fn(&Sample, usize, &mut Vec<T>),
}

impl Declaration<f64> {
    /// Numbers of a row, where the axis says it.
    pub fn components(&self) -> usize {
        match self.axis {
            Axis::Space => 3,
            Axis::Quaternion => 4,
            Axis::Scalar | Axis::Mode | Axis::Coordinate | Axis::Tensor => 1,
        }
    }
}

const fn scalar<T>(
    name: &'static str,
    unit: &'static str,
    description: &'static str,
    extract: fn(&Sample, usize, &mut Vec<T>),
) -> Declaration<T> {
    Declaration { name, unit, axis: Axis::Scalar, description, extract }
}

const fn vector(
    name: &'static str,
    unit: &'static str,
    description: &'static str,
    extract: fn(&Sample, usize, &mut Vec<f64>),
) -> Declaration<f64> {
    Declaration { name, unit, axis: Axis::Space, description, extract }
}

/// `/time`.
pub const TIME: Declaration<f64> = scalar("time", "s", "Simulated time.", |s, _, out| out.push(s.time));

/// `/phase`.
pub const PHASE: Declaration<u32> =
    scalar("phase", "–", "Index into /phases of the phase that the instant belongs to.", |s, _, out| {
        out.push(s.phase);
    });

/// `/energies`.
pub const ENERGIES: [Declaration<f64>; 10] = [
    scalar("kinetic", "J", "Kinetic energy of all bodies.", |s, _, out| out.push(s.energies.kinetic)),
    scalar("elastic_low", "J", "Elastic energy of the dynamic coordinates.", |s, _, out| {
        out.push(s.energies.elastic_low);
    }),
    scalar("elastic_high", "J", "Quasistatic elastic energy of the contact zones.", |s, _, out| {
        out.push(s.energies.elastic_high);
    }),
    scalar("gravity", "J", "Potential energy of gravity, zero at the start.", |s, _, out| {
        out.push(s.energies.gravity);
    }),
    scalar("penalty", "J", "Energy in the penalty springs.", |s, _, out| out.push(s.energies.penalty)),
    scalar("springs", "J", "Energy in the joint springs.", |s, _, out| out.push(s.energies.springs)),
    scalar("dissipated", "J", "Work lost to damping and friction so far.", |s, _, out| {
        out.push(s.energies.dissipated);
    }),
    scalar("supplied", "J", "Work supplied by loads, drives and prescribed motion so far.", |s, _, out| {
        out.push(s.energies.supplied);
    }),
    scalar("numerical", "J", "Energy that a dissipative integrator removed so far.", |s, _, out| {
        out.push(s.energies.numerical);
    }),
    scalar(
        "total",
        "J",
        "Energies held and lost, less the work supplied: constant in an exact solution.",
        |s, _, out| out.push(s.energies.total()),
    ),
];

/// `/momentum`.
pub const MOMENTUM: [Declaration<f64>; 2] = [
    vector("linear", "kg m/s", "Linear momentum of all bodies.", |s, _, out| out.extend(s.linear_momentum)),
    vector("angular", "kg m²/s", "Angular momentum of all bodies about the origin.", |s, _, out| {
        out.extend(s.angular_momentum);
    }),
];

/// `/bodies/<name>`.
pub const BODY: [Declaration<f64>; 7] = [
    vector("position", "m", "Origin of the reference frame.", |s, i, out| out.extend(s.bodies[i].position)),
    Declaration {
        name: "rotation",
        unit: "–",
        axis: Axis::Quaternion,
        description: "Unit quaternion from body to space.",
        extract: |s, i, out| out.extend(s.bodies[i].rotation),
    },
    vector("velocity", "m/s", "Velocity of the origin of the reference frame, in space.", |s, i, out| {
        out.extend(s.bodies[i].velocity);
    }),
    vector("angular_velocity", "rad/s", "Angular velocity of the reference frame, in space.", |s, i, out| {
        out.extend(s.bodies[i].angular_velocity);
    }),
    vector("centre_of_mass", "m", "Centre of mass of the deformed body.", |s, i, out| {
        out.extend(s.bodies[i].centre_of_mass);
    }),
    Declaration {
        name: "elastic_coordinates",
        unit: "m kg^0.5",
        axis: Axis::Mode,
        description: "Elastic coordinates, for mass-orthonormal modes.",
        extract: |s, i, out| out.extend(&s.bodies[i].elastic_coordinates),
    },
    Declaration {
        name: "elastic_velocities",
        unit: "m kg^0.5/s",
        axis: Axis::Mode,
        description: "Rates of the elastic coordinates.",
        extract: |s, i, out| out.extend(&s.bodies[i].elastic_velocities),
    },
];

/// `/contacts/<name>`, numbers.
pub const CONTACT: [Declaration<f64>; 6] = [
    scalar("normal_force", "N", "Sum of the normal forces of the contact points.", |s, i, out| {
        out.push(s.contacts[i].normal_force);
    }),
    vector("force", "N", "Total force on the contact body, in space.", |s, i, out| {
        out.extend(s.contacts[i].force);
    }),
    vector("friction_force", "N", "Friction force on the contact body, in space.", |s, i, out| {
        out.extend(s.contacts[i].friction_force);
    }),
    scalar(
        "penetration",
        "m",
        "Largest penetration of a contact point; zero without contact.",
        |s, i, out| {
            out.push(s.contacts[i].penetration);
        },
    ),
    scalar("contact_area", "m²", "Sum of the tributary areas of the points in contact.", |s, i, out| {
        out.push(s.contacts[i].contact_area);
    }),
    scalar("penalty", "N/m³", "Penalty factor in use; infinite for the exact constraint.", |s, i, out| {
        out.push(s.contacts[i].penalty);
    }),
];

/// `/contacts/<name>`, counts.
pub const CONTACT_COUNTS: [Declaration<u32>; 3] = [
    scalar("active_points", "–", "Number of points in contact.", |s, i, out| {
        out.push(s.contacts[i].active_points);
    }),
    scalar("sliding_points", "–", "Number of points in contact that slide.", |s, i, out| {
        out.push(s.contacts[i].sliding_points);
    }),
    scalar(
        pressure::COUNT,
        "–",
        "Number of points in /pressure/NAME that belong to the instant.",
        |s, i, out| {
            out.push(s.pressures.get(i).map_or(0, |points| points.len() as u32));
        },
    ),
];

/// `/joints/<name>`; the units are those of the coordinates.
pub const JOINT: [Declaration<f64>; 2] = [
    Declaration {
        name: "coordinates",
        unit: "",
        axis: Axis::Coordinate,
        description: "Positions of the joint, prescribed ones included; quaternions as w x y z.",
        extract: |s, i, out| out.extend(&s.joints[i].positions),
    },
    Declaration {
        name: "velocities",
        unit: "",
        axis: Axis::Coordinate,
        description: "Velocities of the joint.",
        extract: |s, i, out| out.extend(&s.joints[i].velocities),
    },
];

/// `/joints/<name>`: what the joint transmits.
pub const REACTION: [Declaration<f64>; 2] = [
    vector("reaction_force", "N", "Force of the joint on its child, in space.", |s, i, out| {
        out.extend(s.joints[i].reaction_force);
    }),
    vector(
        "reaction_moment",
        "N m",
        "Moment of the joint on its child about the place of the child's marker, in space.",
        |s, i, out| out.extend(s.joints[i].reaction_moment),
    ),
];

/// `/gears/<name>`; the unit is that of the second coordinate.
pub const GEAR: Declaration<f64> = scalar(
    "force",
    "N, N m",
    "Force or moment of the gear along its second coordinate; along the first it is the same times `-ratio`.",
    |s, i, out| out.push(s.gears[i]),
);

/// `/points/<name>`.
pub const POINT: [Declaration<f64>; 2] = [
    vector(
        "position",
        "m",
        "Position of the point on the deformed body, with the local deformation of quasistatic contact zones.",
        |s, i, out| {
            out.extend(s.points[i].position);
        },
    ),
    vector(
        "velocity",
        "m/s",
        "Velocity of the point; that of the local deformation is a difference over the last steps (theory Q.6).",
        |s, i, out| out.extend(s.points[i].velocity),
    ),
];

/// `/points/<name>`: stress.
pub const POINT_STRESS: [Declaration<f64>; 2] = [
    Declaration {
        name: "stress",
        unit: "Pa",
        axis: Axis::Tensor,
        description: "Stress at the point, in the axes of the body's frame, with that of the local deformation (theory Q.7, Q.8).",
        extract: |s, i, out| out.extend(s.points[i].state.stress),
    },
    scalar("von_mises", "Pa", "Von Mises stress at the point.", |s, i, out| {
        out.push(s.points[i].state.von_mises());
    }),
];

/// `/points/<name>`: strain.
pub const POINT_STRAIN: [Declaration<f64>; 1] = [Declaration {
    name: "strain",
    unit: "–",
    axis: Axis::Tensor,
    description: "Strain at the point, in the axes of the body's frame; shear strains are angles, twice the tensor's components.",
    extract: |s, i, out| out.extend(s.points[i].state.strain),
}];

/// A stage of a run whose wall time is stored.
pub struct Stage {
    /// Name in `/timings`.
    pub name: &'static str,
    /// One sentence.
    pub description: &'static str,
    /// Wall time of the stage \[s\].
    pub seconds: fn(&Timings) -> f64,
}

/// `/timings`.
pub const TIMINGS: [Stage; 9] = [
    Stage {
        name: STAGES[0],
        description: "What comes before the models: the scenario read and checked, poses, first touches.",
        seconds: |t| t.preparation,
    },
    Stage {
        name: STAGES[1],
        description: "Choice of meshes and numbers of modes, where the scenario leaves them to the program.",
        seconds: |t| t.sizes,
    },
    Stage { name: STAGES[2], description: "Geometry and assembly of the matrices.", seconds: |t| t.assembly },
    Stage {
        name: STAGES[3],
        description: "Eigenmodes and compliance; attribute `fine_models`: number of fine models built.",
        seconds: |t| t.reduction,
    },
    Stage { name: STAGES[4], description: "Contact search.", seconds: |t| t.search },
    Stage { name: STAGES[5], description: "Contact solver.", seconds: |t| t.contact },
    Stage { name: STAGES[6], description: "Time integration without contact.", seconds: |t| t.integration },
    Stage { name: STAGES[7], description: "Writing results.", seconds: |t| t.output },
    Stage {
        name: STAGES[8],
        description: "What has no row of its own, such as reports at the end: all rows but `cache` sum to the time of the command, the closing of the file left aside.",
        seconds: |t| t.rest,
    },
];

/// Scales that the dimensions refer to.
pub struct Axes {
    /// `/time`.
    pub time: Scale,
    /// `/xyz`: x, y, z.
    pub space: Scale,
    /// `/wxyz`: w, x, y, z.
    pub quaternion: Scale,
    /// How all are stored.
    pub storage: Storage,
}

impl Axes {
    /// Writes which datasets the scales are attached to.
    pub fn finish(&self) -> Result<()> {
        [&self.time, &self.space, &self.quaternion].into_iter().try_for_each(Scale::finish)
    }
}

/// A series with the rule that fills it.
pub struct Column<T> {
    /// Dataset and buffer.
    pub series: Series<T>,
    /// Which entries of a sample it has.
    entries: Range<usize>,
    extract: fn(&Sample, usize, &mut Vec<T>),
}

impl<T: H5Type + Copy + Default + Into<f64>> Column<T> {
    /// Creates the dataset without a scale.
    pub fn bare(group: &Group, d: &Declaration<T>, storage: Storage) -> Result<Self> {
        Self::after(None, group, d, &[], 0..1, storage)
    }

    fn after(
        past: Option<Past<T>>,
        group: &Group,
        d: &Declaration<T>,
        row: &[usize],
        entries: Range<usize>,
        storage: Storage,
    ) -> Result<Self> {
        let series = Series::create(group, d.name, row, storage, past)?;
        describe(series.dataset(), d.unit, d.description)?;
        Ok(Self { series, entries, extract: d.extract })
    }

    /// Creates the dataset and attaches its scales; `own` is the scale of elastic coordinates (the
    /// body's eigenfrequencies), of joint coordinates or of tensors (the names of their
    /// components), if there are any.
    pub fn create(
        group: &Group,
        d: &Declaration<T>,
        index: usize,
        axes: &Axes,
        own: Option<&Scale>,
    ) -> Result<Self> {
        Self::late(Past::default(), group, d, index, axes, own)
    }

    /// As [`Column::create`], for a dataset whose first rows are known.
    pub fn late(
        past: Past<T>,
        group: &Group,
        d: &Declaration<T>,
        index: usize,
        axes: &Axes,
        own: Option<&Scale>,
    ) -> Result<Self> {
        Self::along(past, group, d, (index..index + 1, None), axes, own)
    }

    /// Creates the dataset of all bodies, whose names are the scale `names`: time × body × component.
    pub fn of_all(group: &Group, d: &Declaration<T>, names: &Scale, axes: &Axes) -> Result<Self> {
        Self::along(Past::default(), group, d, (0..names.size(), Some((names, "body"))), axes, None)
    }

    fn along(
        past: Past<T>,
        group: &Group,
        d: &Declaration<T>,
        (entries, members): (Range<usize>, Option<(&Scale, &'static str)>),
        axes: &Axes,
        own: Option<&Scale>,
    ) -> Result<Self> {
        let last = match d.axis {
            Axis::Scalar => None,
            Axis::Space => Some((&axes.space, "xyz")),
            Axis::Quaternion => Some((&axes.quaternion, "wxyz")),
            Axis::Mode => own.map(|scale| (scale, "eigenfrequencies")),
            Axis::Coordinate => own.map(|scale| (scale, "coordinate")),
            Axis::Tensor => own.map(|scale| (scale, "component")),
        };
        let scales: Vec<_> = members.into_iter().chain(last).collect();
        let row: Vec<usize> = scales.iter().map(|(scale, _)| scale.size()).collect();
        let column = Self::after(Some(past), group, d, &row, entries, axes.storage)?;
        scales::attach(column.series.dataset(), &[&[(&axes.time, "time")], scales.as_slice()].concat())?;
        Ok(column)
    }

    /// Buffers the row of a sample, and appends it to `row`.
    pub fn push(&mut self, sample: &Sample, row: &mut Vec<T>) {
        let start = self.series.buffer.len();
        self.entries.clone().for_each(|entry| (self.extract)(sample, entry, &mut self.series.buffer));
        row.extend(&self.series.buffer[start..]);
    }

    /// Buffers the row in front of `row` and takes it from there; false if there are too few
    /// values.
    pub fn push_row(&mut self, row: &mut &[T]) -> bool {
        let Some((own, rest)) = row.split_at_checked(self.series.width()) else { return false };
        self.series.buffer.extend(own);
        *row = rest;
        true
    }
}
