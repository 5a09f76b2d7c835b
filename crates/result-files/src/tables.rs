//! Tables of a result file: a row of each is declared once, with name, unit, origin and meaning of
//! every column. The dataset, its description, the reference page and the JSON of `info` follow.

use hdf5::types::VarLenUnicode;
use hdf5::{Group, H5Type, Result};
use serde_json::{Map, Value};

use crate::dataset::Table;

/// A column of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TableColumn {
    /// Name in the file.
    pub name: &'static str,
    /// Unit, "–" for what has none.
    pub unit: &'static str,
    /// What it holds.
    pub meaning: &'static str,
}

/// A row of a table.
pub trait TableRow: H5Type {
    /// Name of the table.
    const NAME: &'static str;
    /// What the table holds, a sentence.
    const DESCRIPTION: &'static str;
    /// The columns in their order.
    const COLUMNS: &'static [TableColumn];

    /// The row as JSON, its columns by their names; what is no number is null.
    fn json(&self) -> Map<String, Value>;
}

/// What the column `outcome` of [`TrialRow`] holds of a trial that is the result.
pub const ACCEPTED: &str = "accepted";

/// Creates the table of rows `T` in `group`; its attribute `unit` has names and units of the
/// columns, `name: unit, name: unit`.
///
/// # Errors
/// Those of HDF5.
pub fn create<T: TableRow>(group: &Group) -> Result<Table> {
    let units: Vec<String> = T::COLUMNS.iter().map(|c| format!("{}: {}", c.name, c.unit)).collect();
    Table::create::<T>(group, T::NAME, &units.join(", "), T::DESCRIPTION)
}

/// A value of a column as JSON.
trait ColumnValue {
    fn json(&self) -> Value;
}

macro_rules! column_values {
    ($($kind:ty),*) => { $(
        impl ColumnValue for $kind {
            fn json(&self) -> Value {
                (*self).into()
            }
        }
    )* };
}
column_values!(f64, u32, u64, i32);

impl<const N: usize> ColumnValue for [f64; N] {
    fn json(&self) -> Value {
        self.iter().copied().collect()
    }
}

impl ColumnValue for VarLenUnicode {
    fn json(&self) -> Value {
        self.as_str().into()
    }
}

/// The name of a column: that of its field unless another is given.
macro_rules! column_name {
    ($field:ident) => {
        stringify!($field)
    };
    ($field:ident $name:literal) => {
        $name
    };
}

/// Declares the row of a table: `field [as name]: type [unit], meaning;` for each column.
macro_rules! table {
    ($row:ident $name:literal $description:literal {
        $($field:ident $(as $rename:literal)?: $kind:ty [$unit:literal], $meaning:literal;)*
    }) => {
        #[doc = concat!("A row of `/", $name, "`.")]
        #[derive(Debug, Clone, PartialEq, H5Type)]
        #[repr(C)]
        pub struct $row {
            $(
                #[doc = concat!($meaning, " \\[", $unit, "\\]")]
                $(#[hdf5(rename = $rename)])?
                pub $field: $kind,
            )*
        }

        impl TableRow for $row {
            const NAME: &'static str = $name;
            const DESCRIPTION: &'static str = $description;
            const COLUMNS: &'static [TableColumn] = &[
                $(TableColumn { name: column_name!($field $($rename)?), unit: $unit, meaning: $meaning },)*
            ];

            fn json(&self) -> Map<String, Value> {
                let columns = [$((column_name!($field $($rename)?), self.$field.json()),)*];
                columns.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
            }
        }
    };
}

table!(PhaseRow "phases" "Phases of the run." {
    kind: VarLenUnicode ["–"], "`free`, `impact` or `lasting`";
    start: f64 ["s"], "time at which it starts";
    end: f64 ["s"], "time at which it ends";
    steps: u64 ["–"], "accepted steps";
    rejected: u64 ["–"], "rejected steps";
    evaluations: u64 ["–"], "evaluations of the right-hand side";
    wall_time: f64 ["s"], "wall time";
});

table!(ImpactRow "impacts" "Impacts; touches between which the bodies are apart for no longer than the longest of them lasts are one (theory Q.1)." {
    contact: VarLenUnicode ["–"], "name of the contact";
    start: f64 ["s"], "first contact";
    end: f64 ["s"], "last contact";
    peak_force: f64 ["N"], "largest normal force";
    peak_time: f64 ["s"], "its time";
    impulse: f64 ["N s"],
        "force over time, along the normal at the peak: what the momenta of the bodies change by in that direction; where normals differ, as in a conical seat, less than the normal force over time";
    approach_velocity: f64 ["m/s"],
        "of the bodies' rigid motions at the place of contact when it closes, along the normal at the peak (theory Q.2)";
    separation_velocity: f64 ["m/s"],
        "the same when it opens for the last time, positive apart; NaN if the run ends in contact";
    restitution: f64 ["–"],
        "ratio of the two (theory Q.3); NaN where it has no meaning: no approach, run ended in contact, the motions still \
         approach each other when the contact opens, the bodies rang before they touched, another contact pressed the same bodies meanwhile, or they touched at several places at once";
    peak_force_uncertainty: f64 ["N"],
        "band of the largest normal force: by how much it may be off because of what the run is resolved to (docs/uncertainty.md); NaN where that is not known, like the columns that follow";
    duration_uncertainty: f64 ["s"], "band of the time from the first to the last contact";
    impulse_uncertainty: f64 ["N s"], "band of the impulse";
    separation_velocity_uncertainty: f64 ["m/s"], "band of the separating speed";
    restitution_uncertainty: f64 ["–"], "band of the restitution";
    uncertainty: VarLenUnicode ["–"],
        "the largest part of these bands and what lowers it, or why there is none";
    peak_time_uncertainty: f64 ["s"], "band of the time of the largest normal force";
});

table!(EventRow "events" "What contacts do, in the order of time within every phase (theory Q.5)." {
    time: f64 ["s"], "when";
    contact: VarLenUnicode ["–"], "name of the contact";
    kind: VarLenUnicode ["–"],
        "`touch` and `release`: it closes and opens; `stick`, `partial slip`, `slip`: none, some or all of its points slide, of contacts with friction; `rest` and `motion`: its bodies stay where they are on each other, and no longer do";
    normal_force: f64 ["N"], "normal force at the end of the step in which it happened; of touches and releases zero";
});

table!(TrialRow "tries" "Trials of every impact phase, one row per trial and contact." {
    impact: u32 ["–"],
        "index of the impact, its row in `/impacts`; arrays count from 0, numbers that people see from 1";
    number as "try": u32 ["–"], "number of the trial, from 1";
    start: f64 ["s"], "time at which it starts";
    stop: f64 ["s"], "time reached";
    penalty_start: f64 ["N/m³"], "penalty factor at the start";
    penalty_end: f64 ["N/m³"], "penalty factor at the end";
    interval_widths: [f64; 2] ["m"], "width of the contact interval in two directions";
    utilisation: [f64; 2] ["–"], "largest part of it in contact, in two directions";
    elements: u64 ["–"], "elements of the fine model";
    dofs as "freedoms": u64 ["–"], "its degrees of freedom";
    interface_dofs as "interface_freedoms": u64 ["–"], "those in the contact zone";
    steps: u64 ["–"], "accepted steps";
    rejected: u64 ["–"], "rejected steps";
    peak_force: f64 ["N"], "largest normal force";
    outcome: VarLenUnicode ["–"], "`accepted`, `rejected`, `interrupted` or `failed`";
    reason: VarLenUnicode ["–"], "why";
    wall_time: f64 ["s"], "wall time";
    cpu_time: f64 ["s"], "processor time of the whole process";
});

table!(TransferRow "transfers" "Changes of models in the course of the run, and what they did to the ledger." {
    time: f64 ["s"], "when";
    direction: VarLenUnicode ["–"], "`coarse to fine`, `fine to coarse` or `penalty`";
    contact: VarLenUnicode ["–"], "name of the contact";
    energy_before: f64 ["J"], "total energy before";
    energy_after: f64 ["J"], "total energy after";
    momentum_change: f64 ["kg m/s"], "length of the change of linear momentum";
    face: i32 ["–"],
        "face of the contact body that the interval of the fine model lies on, counted through its patches; -1 if none came";
    centre: [f64; 3] ["–"], "parameters of the interval's centre in the face's patch";
    target_face: i32 ["–"], "the same of the target body";
    target_centre: [f64; 3] ["–"], "the same of the target body";
    interval_widths: [f64; 2] ["m"], "widths of the interval along the surface; infinite where the zone is the whole surface";
    finer: f64 ["–"], "how many times as many elements the interval has in a direction as intervals of the contact have, for contact that moves along it (theory A.1); 0 if none came";
    edge_face: i32 ["–"],
        "face of the target that has an edge or a corner where the contact body meets it at one point (theory C.63), counted through its patches; -1 elsewhere";
    edge_place: [f64; 3] ["–"], "parameters of that point in the face's patch";
    edge_normal: [f64; 3] ["–"], "unit normal there towards the contact body, in the target's frame";
    edge_along: [f64; 6] ["m"],
        "half of the straight edge that lies along a face of the contact body and has this point in its middle (theory C.97), in the frames of the contact body (3) and of the target (3); zeros where one point is met";
    edge_spread: f64 ["m"], "half of the width over which the face is pressed along that edge, or by a corner in the plane (theory C.98); 0 elsewhere";
    edge_outward: [f64; 3] ["–"],
        "of an edge of the contact body itself, which presses the target at this point: unit vector out of it there, in the model's components; zeros elsewhere";
    part: [f64; 8] ["–"],
        "the part of a surface with edges that is the zone (theory C.91): place (3) and direction to the partner (3) in the model's components, depth and radius in m; of an interval the flat face of the target about which it lies (C.102); zeros where it is all";
    target_part: [f64; 8] ["–"], "the same of the target body";
    others: [f64; 28] ["–"],
        "further places of the contact body about which the interval lies where bodies touch at several at once (theory A.12), up to seven: number of the face from 1 on, 0 for none, and parameters";
    target_others: [f64; 28] ["–"], "the same of the target body";
    across: [f64; 3] ["–"],
        "direction of the first width, across the line of a touch on a plane of a mesh of the contact body, in the model's components (theory C.110); zeros elsewhere";
    target_across: [f64; 3] ["–"], "the same of the target body";
    offset: f64 ["m"], "how far a zone on a smooth surface in place of the sides of a mesh was moved along its normal (theory C.75)";
});
