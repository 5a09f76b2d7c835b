//! The result file: written from a made-up run, read back, and what is left when a run does not end well.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use adaptive::AdaptiveError;
use adaptive::record::{
    BodyLayout, BodySample, ContactSample, Energies, ImpactRecord, JointLayout, JointSample, PhaseKind,
    PhaseRecord, PointLayout, PointSample, PressurePoint, RunLayout, Sample, StressRecord, Timings,
    TrialRecord,
};
use adaptive::state::observer::{Continue, Observer};
use fbimpact::commands::run::recording::{Simulation, record};
use fbimpact::commands::run::stop::Stop;
use fbimpact::error::AppError;
use fbimpact::results::{OutputFile, Recorder, Status};
use fbimpact::scenario::{self, Scenario};
use fbimpact::simulate::{Ending, RunReport};
use ffr_dynamics::DynamicsError;
use ffr_dynamics::error::{IntegrationFault, Rejection};
use hdf5::types::VarLenUnicode;
use indicatif::ProgressBar;
use result_files::stored::summary;

/// More than two write buffers, and not a multiple of one.
const ROWS: u32 = 600;

fn scenario_with(set: &[&str]) -> Scenario {
    let text = include_bytes!("../scenarios/sphere_on_plane.toml");
    let mut overrides = vec!["output.points.top.body=ball", "output.points.top.marker=top"];
    overrides.extend(set);
    let overrides: Vec<_> = overrides.iter().map(|s| s.parse().expect("valid --set")).collect();
    scenario::parse(Path::new("sphere_on_plane.toml"), text, &overrides).expect("valid")
}

fn loaded(j: u32) -> PressurePoint {
    let x = f64::from(j);
    PressurePoint { position: [1e-4 * x, 0.0, 0.0], area: 1e-8 * (1.0 + x), pressure: 1e6 * x }
}

fn sample(i: u32) -> Sample {
    let x = f64::from(i);
    let body = |n_q: usize| BodySample {
        position: [x, 2.0 * x, 3.0 * x],
        rotation: [1.0, 0.0, 0.0, 0.0],
        elastic_coordinates: (0..n_q).map(|j| x + 0.1 * j as f64).collect(),
        elastic_velocities: vec![-x; n_q],
        ..BodySample::default()
    };
    Sample {
        time: x * 1e-7,
        phase: u32::from(i >= 300),
        energies: Energies { kinetic: 2.0, penalty: 1e-6 * x, ..Energies::default() },
        linear_momentum: [0.0, 0.0, -x],
        angular_momentum: [0.0; 3],
        bodies: vec![body(6), body(0)],
        contacts: vec![ContactSample { normal_force: 0.1 * x, active_points: i, ..ContactSample::default() }],
        pressures: vec![(0..i % 4).map(loaded).collect()],
        points: vec![PointSample {
            position: [0.0, 0.0, x],
            velocity: [x, 0.0, 0.0],
            ..PointSample::default()
        }],
        joints: vec![JointSample {
            positions: vec![x, 0.5 * x],
            velocities: vec![1.0, 2.0],
            reaction_force: [3.0 * x, 0.0, 4.0 * x],
            reaction_moment: [0.0, -x, 0.0],
        }],
        gears: vec![2.0 * x],
    }
}

fn start(observer: &mut dyn Observer) -> Result<(), AppError> {
    let body = |name: &str, f: Vec<f64>| BodyLayout {
        name: name.into(),
        frequency_bands: vec![0.5; f.len()],
        eigenfrequencies: f,
    };
    let layout = RunLayout {
        bodies: vec![body("ball", (1..=6).map(|i| 1e5 * f64::from(i)).collect()), body("floor", Vec::new())],
        contacts: vec!["impact".into()],
        stops: Vec::new(),
        points: vec![PointLayout { name: "top".into(), ..PointLayout::default() }],
        joints: vec![JointLayout {
            name: "guide".into(),
            kind: "cylindrical".into(),
            positions: vec![("displacement z".into(), "m".into()), ("angle".into(), "rad".into())],
            velocities: vec![
                ("velocity z".into(), "m/s".into()),
                ("angular velocity".into(), "rad/s".into()),
            ],
        }],
        gears: vec![("mesh".into(), "N m".into())],
        time_span: (0.0, 1e-4),
    };
    observer.start(&layout).map_err(|e| AppError::Run(Box::new(e.into())))
}

fn report(ending: Ending, time: f64) -> RunReport {
    RunReport { ending, time, timings: Timings { assembly: 0.25, ..Timings::default() } }
}

/// Stops at row `until` at the latest, or when the observer says so.
fn samples(observer: &mut dyn Observer, until: u32) -> Result<RunReport, AppError> {
    let fail = |e: adaptive::error::ObserverError| AppError::Run(Box::new(e.into()));
    for i in 0..until {
        let sample = sample(i);
        observer.sample(&sample).map_err(fail)?;
        if observer.progress(sample.time, 1e-7, PhaseKind::Impact) == Continue::Interrupt {
            return Ok(report(Ending::Interrupted, sample.time));
        }
    }
    Ok(report(Ending::Complete, 1e-4))
}

fn complete(_: &Scenario, observer: &mut dyn Observer, _: usize) -> Result<RunReport, AppError> {
    let fail = |e: adaptive::error::ObserverError| AppError::Run(Box::new(e.into()));
    start(observer)?;
    let report = samples(observer, ROWS)?;
    let phase =
        PhaseRecord { kind: PhaseKind::Impact, start: 0.0, end: 6e-5, steps: 600, ..Default::default() };
    observer.phase(&phase).map_err(fail)?;
    let impact =
        ImpactRecord { contact: 0, end: 8e-5, peak_force: 52.0, restitution: 0.5, ..Default::default() };
    observer.impact(&impact).map_err(fail)?;
    let trial = TrialRecord {
        number: 1,
        outcome: adaptive::record::TrialOutcome::Accepted,
        reason: "done".into(),
        ..Default::default()
    };
    observer.trial(&trial).map_err(fail)?;
    let stress = StressRecord {
        name: "axis".into(),
        time: 4e-5,
        points: vec![[0.0, -0.01, 0.0], [0.0, -0.009, 0.0]],
        stress: vec![[1.0, 2.0, 3.0, 4.0, 0.0, 0.0]; 2],
        von_mises: vec![5.0, 6.0],
    };
    observer.stress(&stress).map_err(fail)?;
    Ok(report)
}

fn fails(_: &Scenario, observer: &mut dyn Observer, _: usize) -> Result<RunReport, AppError> {
    start(observer)?;
    samples(observer, 10)?;
    let remedy = "soften the contact";
    let fault = IntegrationFault::StepTooShort { step: 1e-18, rejection: Rejection::NotFinite, remedy };
    Err(AppError::Run(Box::new(AdaptiveError::Dynamics(DynamicsError::Integration { time: 0.0, fault }))))
}

fn fails_early(_: &Scenario, _: &mut dyn Observer, _: usize) -> Result<RunReport, AppError> {
    let joint = DynamicsError::JointCycle { path: "no such thing".into() };
    Err(AppError::model(AdaptiveError::Model(joint)))
}

fn runs(path: &Path, force: bool, stopped: bool, simulation: Simulation) -> Result<(), AppError> {
    let output = OutputFile::claim(path, force)?;
    let stop = Stop::default();
    if stopped {
        stop.note();
    }
    record(&scenario_with(&[]), output, 1, (&stop, ProgressBar::hidden(), Instant::now()), simulation)
}

fn directory() -> (tempfile::TempDir, PathBuf) {
    let directory = tempfile::tempdir().expect("a temporary directory");
    let path = directory.path().join("out.h5");
    (directory, path)
}

fn status(path: &Path) -> String {
    summary::read(path).expect("readable").attribute("status").to_owned()
}

#[test]
fn everything_written_is_read_back() {
    let (_directory, path) = directory();
    runs(&path, false, false, complete).expect("the run is complete");
    let file = result_files::file::hdf5_integrity::open(&path).expect("readable");
    let time = file.dataset("time").expect("there").read_raw::<f64>().expect("numbers");
    assert_eq!(time.len(), ROWS as usize);
    let last = sample(ROWS - 1);
    assert_eq!(time.last(), Some(&last.time));
    let q = file.dataset("bodies/ball/elastic_coordinates").expect("there").read_2d::<f64>().expect("2D");
    assert_eq!(q.shape(), [ROWS as usize, 6]);
    assert_eq!(q.row(ROWS as usize - 1).to_vec(), last.bodies[0].elastic_coordinates);
    let position = file.dataset("bodies/floor/position").expect("there").read_2d::<f64>().expect("2D");
    assert_eq!(position.row(7).to_vec(), [7.0, 14.0, 21.0]);
    assert!(file.dataset("bodies/floor/elastic_coordinates").is_err(), "a rigid body has none");
    let moment = file.dataset("joints/guide/reaction_moment").expect("there").read_2d::<f64>().expect("2D");
    assert_eq!(moment.row(9).to_vec(), [0.0, -9.0, 0.0]);
    let active =
        file.dataset("contacts/impact/active_points").expect("there").read_raw::<u32>().expect("u32");
    assert_eq!(active[599], 599);
    let phase = file.dataset("phase").expect("there").read_raw::<u32>().expect("u32");
    assert_eq!((phase[299], phase[300]), (0, 1));
    let mises = file.dataset("stress/axis/von_mises").expect("there");
    assert_eq!(mises.read_raw::<f64>().expect("numbers"), [5.0, 6.0]);
    let at: f64 = mises.attr("time").expect("there").read_scalar().expect("a number");
    assert!((at - 4e-5).abs() < 1e-18);
    assert_eq!(file.size(), std::fs::metadata(&path).expect("there").len(), "no room is left behind the end");
    let bytes = std::fs::read(&path).expect("readable");
    assert_eq!(bytes[8], 2, "superblock of HDF5 1.8, whose headers have checksums");
}

/// A process that is killed leaves what is on the disk at that moment, as the copies here do.
#[test]
fn between_flushes_a_run_of_many_bodies_is_on_the_disk_as_it_was_at_the_last_flush() {
    // Metadata of so many bodies do not fit into the memory that HDF5 takes for them unless it is told otherwise.
    const BODIES: usize = 200;
    const MODES: usize = 20;
    let (directory, path) = directory();
    let mut recorder = Recorder::create(&path, &scenario_with(&[]), 1).expect("writable");
    let body = |i: usize| BodyLayout {
        name: format!("body {i}"),
        eigenfrequencies: vec![1.0; MODES],
        ..BodyLayout::default()
    };
    let layout = RunLayout { bodies: (0..BODIES).map(body).collect(), ..RunLayout::default() };
    recorder.start(&layout).expect("writable");
    let body = BodySample {
        elastic_coordinates: vec![1.0; MODES],
        elastic_velocities: vec![1.0; MODES],
        ..BodySample::default()
    };
    let mut sample = Sample { bodies: vec![body; BODIES], ..Sample::default() };
    let copy = directory.path().join("copy.h5");
    for i in 1..=1024 {
        sample.time = f64::from(i);
        recorder.sample(&sample).expect("writable");
        if i % 256 == 0 {
            std::fs::copy(&path, &copy).expect("readable");
            assert_eq!(status(&copy), "running", "row {i}");
        }
    }
}

#[test]
fn summary_holds_what_was_recorded() {
    let (_directory, path) = directory();
    runs(&path, false, false, complete).expect("the run is complete");
    let s = summary::read(&path).expect("readable");
    assert_eq!(s.attribute("status"), "complete");
    assert_eq!(s.n_samples, ROWS as usize);
    assert_eq!(s.impacts.len(), 1);
    assert_eq!(s.impacts[0].contact.as_str(), "impact");
    assert_eq!(s.phases[0].steps, 600);
    assert_eq!(s.trials[0].reason.as_str(), "done");
    assert_eq!(s.bodies, [("ball".to_owned(), 6), ("floor".to_owned(), 0)]);
    // The total rises by 599e-6 J over a largest energy of 2 J + 599e-6 J.
    let drift = s.energy_drift.expect("there are energies");
    assert!((drift - 599e-6 / (2.0 + 599e-6)).abs() < 1e-12, "{drift}");
    assert!(s.timings.iter().any(|(n, v)| n == "assembly" && (v - 0.25).abs() < 1e-15));
    assert_eq!(s.json()["impacts"][0]["peak_force"], 52.0);
    // The last of 600 rows has the largest reaction: 5 N and 1 N m a row.
    let [force, moment, moved, _] = &s.peaks[..] else { panic!("one joint, one point: {:?}", s.peaks) };
    assert!((force.peak.value - 5.0 * 599.0).abs() < 1e-9, "{force:?}");
    assert!((moment.peak.value - 599.0).abs() < 1e-12, "{moment:?}");
    assert!((force.peak.time - 599e-7).abs() < 1e-18 && force.place == "guide");
    assert!((moved.peak.value - 599.0).abs() < 1e-12 && moved.place == "top", "{moved:?}");
    assert_eq!(s.json()["joints"]["guide"]["peak_moment"], 599.0);
}

#[test]
fn every_numeric_dataset_has_unit_description_and_time_axis() {
    let (_directory, path) = directory();
    runs(&path, false, false, complete).expect("the run is complete");
    let file = result_files::file::hdf5_integrity::open(&path).expect("readable");
    let mut seen = 0;
    visit(&file, &mut |dataset| {
        let name = dataset.name();
        let text = |a: &str| {
            let value: VarLenUnicode = dataset.attr(a).ok()?.read_scalar().ok()?;
            Some(value.as_str().to_owned())
        };
        let is_text = dataset.dtype().is_ok_and(|t| t.is::<VarLenUnicode>());
        if !is_text {
            assert!(text("unit").is_some_and(|u| !u.is_empty()), "{name} has a unit");
            assert!(text("description").is_some_and(|d| !d.is_empty()), "{name} has a description");
        }
        let is_series = dataset.shape().first() == Some(&(ROWS as usize)) && name != "/time";
        if is_series {
            assert!(dataset.attr("DIMENSION_LIST").is_ok(), "{name} has its scales attached");
            seen += 1;
        }
    });
    // 1 phase, 10 energies, 2 momenta, 7 + 5 of bodies, 9 of contacts, 2 of points, 4 of joints, 1 of a gear.
    assert_eq!(seen, 41);
    // Scales name their datasets as these name their scales: `H5DSis_attached` looks at both.
    let users = file.dataset("time").and_then(|time| time.attr("REFERENCE_LIST")).expect("attached");
    assert_eq!(users.size(), seen);
    let class: hdf5::types::FixedAscii<16> = read_class(&file);
    assert_eq!(class.as_str(), "DIMENSION_SCALE");
}

#[test]
fn every_point_is_stored_once_and_the_lists_are_as_long_as_their_counts_say() {
    let (_directory, path) = directory();
    runs(&path, false, false, complete).expect("the run is complete");
    let file = result_files::file::hdf5_integrity::open(&path).expect("readable");
    let count: Vec<u32> =
        file.dataset("contacts/impact/pressure_points").and_then(|d| d.read_raw()).expect("u32");
    let point: Vec<u32> = file.dataset("pressure/impact/point").and_then(|d| d.read_raw()).expect("u32");
    let pressure: Vec<f64> =
        file.dataset("pressure/impact/pressure").and_then(|d| d.read_raw()).expect("f64");
    let area: Vec<f64> = file.dataset("pressure/impact/area").and_then(|d| d.read_raw()).expect("f64");
    let position: Vec<f64> =
        file.dataset("pressure/impact/position").and_then(|d| d.read_raw()).expect("f64");
    assert!(count.iter().zip(0..).all(|(n, i)| *n == i % 4) && count.len() == ROWS as usize);
    assert_eq!((area.len(), position.len()), (3, 9));
    let mut k = 0;
    for n in count {
        for j in 0..n {
            let at = point[k] as usize;
            let wanted = loaded(j);
            assert_eq!((position[3 * at], area[at]), (wanted.position[0], wanted.area));
            // Single precision.
            assert!((pressure[k] - wanted.pressure).abs() <= 1e-7 * wanted.pressure);
            k += 1;
        }
    }
    assert_eq!((k, k), (point.len(), pressure.len()));
}

/// The same names lead to the same datasets until a contact touches; what is read of each is what was reported of it.
#[test]
fn contacts_share_datasets_until_they_touch() {
    const CONTACTS: u32 = 12;
    // Instants with force: of every third contact none, of the others sixty from one on, of the first from the start.
    let touches = |i: u32, row: u32| i % 3 != 2 && (45 * i..45 * i + 60).contains(&row);
    let contact = |i: u32, row: u32| {
        let force = if touches(i, row) { f64::from(row + 1) } else { 0.0 };
        ContactSample {
            normal_force: force,
            force: [0.0, 2.0 * force, force],
            active_points: u32::from(touches(i, row)),
            penalty: if i.is_multiple_of(2) { 1e15 } else { f64::INFINITY },
            ..ContactSample::default()
        }
    };
    let (_directory, path) = directory();
    let mut recorder = Recorder::create(&path, &scenario_with(&[]), 1).expect("writable");
    let names = (0..CONTACTS).map(|i| format!("contact {i}")).collect();
    recorder.start(&RunLayout { contacts: names, ..RunLayout::default() }).expect("writable");
    for row in 0..ROWS {
        let points = |i| if touches(i, row) { vec![loaded(i)] } else { Vec::new() };
        let sample = Sample {
            contacts: (0..CONTACTS).map(|i| contact(i, row)).collect(),
            pressures: (0..CONTACTS).map(points).collect(),
            ..Sample::default()
        };
        recorder.sample(&sample).expect("writable");
    }
    recorder.finish(Status::Complete, "", None).expect("writable");
    let file = result_files::file::hdf5_integrity::open(&path).expect("readable");
    let numbers = |i: u32, name: &str| -> Vec<f64> {
        file.dataset(&format!("contacts/contact {i}/{name}")).and_then(|d| d.read_raw()).expect("numbers")
    };
    let mut places: Vec<_> = Vec::new();
    for i in 0..CONTACTS {
        let rows = || (0..ROWS).map(|row| contact(i, row));
        assert_eq!(numbers(i, "normal_force"), rows().map(|c| c.normal_force).collect::<Vec<_>>(), "{i}");
        assert_eq!(numbers(i, "force"), rows().flat_map(|c| c.force).collect::<Vec<_>>(), "{i}");
        assert_eq!(numbers(i, "penalty"), rows().map(|c| c.penalty).collect::<Vec<_>>(), "{i}");
        let active = rows().map(|c| f64::from(c.active_points));
        assert_eq!(numbers(i, "active_points"), active.clone().collect::<Vec<_>>(), "{i}");
        assert_eq!(numbers(i, "pressure_points"), active.collect::<Vec<_>>(), "{i}");
        // Lists are there once a point has carried force.
        let lists = format!("pressure/contact {i}");
        assert_eq!(file.link_exists(&lists), i % 3 != 2);
        if i % 3 != 2 {
            assert_eq!(file.dataset(&format!("{lists}/point")).expect("there").size(), 60);
        }
        places.push(
            file.group(&format!("contacts/contact {i}")).and_then(|g| g.loc_info()).expect("there").token,
        );
    }
    // What reads results takes each name for itself.
    let stored = result_files::stored::Stored::open(&path).expect("readable");
    assert_eq!(
        stored.entries.keys().filter(|name| name.ends_with("/penetration")).count(),
        CONTACTS as usize
    );
    let force = |i: u32| format!("contacts/contact {i}/force");
    let leads = |from: u32, to: u32| stored.entries[&force(from)].same == Some(force(to));
    assert!(leads(2, 8) || leads(8, 2));
    // Those that never touch share by their penalty factor.
    assert!(places[2] == places[8] && places[5] == places[11] && places[2] != places[5]);
    let groups = (0..places.len()).filter(|i| !places[..*i].contains(&places[*i])).count();
    assert_eq!(groups, 8 + 2);
    // Each dataset is named by the scale of its time once: phase, energies, momenta, and nine of each group.
    let users = file.dataset("time").and_then(|time| time.attr("REFERENCE_LIST")).expect("attached");
    assert_eq!(users.size(), 1 + 10 + 2 + 9 * groups);
}

fn read_class(file: &hdf5::File) -> hdf5::types::FixedAscii<16> {
    let attribute = file.dataset("time").expect("there").attr("CLASS").expect("time is a scale");
    attribute.read_scalar().expect("text")
}

fn visit(group: &hdf5::Group, action: &mut dyn FnMut(&hdf5::Dataset)) {
    group.datasets().expect("readable").iter().for_each(&mut *action);
    for child in group.groups().expect("readable") {
        visit(&child, action);
    }
}

#[test]
fn resolved_scenario_in_the_file_reads_back() {
    let (_directory, path) = directory();
    runs(&path, false, false, complete).expect("the run is complete");
    let file = result_files::file::hdf5_integrity::open(&path).expect("readable");
    let text: VarLenUnicode = file.dataset("scenario").expect("there").read_scalar().expect("text");
    let again = scenario::parse(Path::new("again.toml"), text.as_str().as_bytes(), &[]).expect("valid");
    assert_eq!(again.run, scenario_with(&[]).run);
}

#[test]
fn compressed_and_plain_files_hold_the_same() {
    let (directory, plain) = directory();
    let packed = directory.path().join("packed.h5");
    runs(&plain, false, false, complete).expect("complete");
    let output = OutputFile::claim(&packed, false).expect("free");
    let stop = Stop::default();
    let scenario = scenario_with(&["output.compression=gzip"]);
    record(&scenario, output, 1, (&stop, ProgressBar::hidden(), Instant::now()), complete).expect("complete");
    let read = |path: &Path| {
        let file = result_files::file::hdf5_integrity::open(path).expect("readable");
        let dataset = file.dataset("bodies/ball/elastic_coordinates").expect("there");
        (dataset.read_raw::<f64>().expect("numbers"), dataset.filters().len())
    };
    let ((a, no_filters), (b, filters)) = (read(&plain), read(&packed));
    assert_eq!(a, b);
    assert_eq!((no_filters, filters), (0, 2));
}

#[test]
fn failed_run_keeps_what_it_stored() {
    let (_directory, path) = directory();
    let error = runs(&path, false, false, fails).expect_err("the run fails");
    assert_eq!(error.code(), 5);
    let s = summary::read(&path).expect("readable");
    assert_eq!((s.attribute("status"), s.n_samples), ("failed", 10));
    assert!(s.attribute("message").contains("step fell to 1.000e-18 s"));
}

#[test]
fn run_that_stored_nothing_leaves_nothing() {
    let (directory, path) = directory();
    let error = runs(&path, false, false, fails_early).expect_err("the run fails");
    assert_eq!(error.code(), 4);
    assert_eq!(std::fs::read_dir(directory.path()).expect("readable").count(), 0);
}

#[test]
fn interrupted_run_is_marked_and_readable() {
    let (_directory, path) = directory();
    let error = runs(&path, false, true, complete).expect_err("interrupted");
    assert_eq!(error.code(), 130);
    let s = summary::read(&path).expect("readable");
    assert_eq!((s.attribute("status"), s.n_samples), ("interrupted", 1));
}

#[test]
fn incomplete_run_does_not_replace_a_result_without_force() {
    let (_directory, path) = directory();
    runs(&path, false, false, complete).expect("complete");
    runs(&path, false, false, fails).expect_err("the run fails");
    assert_eq!(status(&path), "complete");
    let part = path.with_file_name("out.h5.part");
    assert_eq!(status(&part), "failed");
    runs(&path, true, false, fails).expect_err("the run fails");
    assert_eq!(status(&path), "failed");
    assert!(!part.exists());
    runs(&path, false, false, complete).expect("complete");
    assert_eq!(status(&path), "complete");
}

#[test]
fn two_runs_cannot_claim_one_output() {
    let (_directory, path) = directory();
    let first = OutputFile::claim(&path, false).expect("free");
    let error = OutputFile::claim(&path, true).expect_err("taken");
    assert!(error.to_string().contains("another run"), "{error}");
    first.discard();
    OutputFile::claim(&path, false).expect("free again").discard();
}

#[test]
fn part_file_of_a_dead_run_is_replaced() {
    let (_directory, path) = directory();
    std::fs::write(path.with_file_name("out.h5.part"), b"\x89HDF\r\n\x1a\nleft behind").expect("written");
    runs(&path, false, false, complete).expect("complete");
    assert_eq!(status(&path), "complete");
}

#[test]
fn file_of_something_else_is_not_replaced_without_force() {
    let (_directory, path) = directory();
    std::fs::write(&path, "precious").expect("written");
    let error = runs(&path, false, false, complete).expect_err("refused");
    assert_eq!(error.code(), 6);
    assert_eq!(std::fs::read_to_string(&path).expect("readable"), "precious");
    assert!(!path.with_file_name("out.h5.part").exists());
    runs(&path, true, false, complete).expect("complete");
    assert_eq!(status(&path), "complete");
}

#[test]
fn output_that_cannot_be_written_is_refused_at_once() {
    let (directory, _) = directory();
    let missing = directory.path().join("no/such/directory/out.h5");
    for path in [missing.as_path(), directory.path()] {
        let error = OutputFile::claim(path, true).expect_err("refused");
        assert_eq!(error.code(), 6, "{error}");
    }
}

#[test]
fn every_dataset_of_a_result_is_in_the_reference() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("all.h5");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let scenario = root.join("scenarios/rigid_double_pendulums.toml");
    let disc = root.join("scenarios/sphere_on_plane.toml");
    let stress = "output.stress.line={body=\"ball\",from=\"bottom\",to=\"top\"}";
    let page = fbimpact::results::reference::markdown();
    for (scenario, set) in [(scenario, "simulation.end_time=0.01"), (disc, stress)] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_fbimpact"));
        command.args(["run", "-q", "--set", set, "--force", "-o"]).arg(&path).arg(&scenario);
        assert!(command.status().expect("the program starts").success());
        let mut names = Vec::new();
        let file = result_files::file::hdf5_integrity::open(&path).expect("readable");
        list(&file, "", &mut names);
        assert!(names.len() > 30);
        for name in names {
            let mut parts: Vec<&str> = name.split('/').collect();
            if matches!(
                parts[1],
                "bodies" | "joints" | "gears" | "contacts" | "pressure" | "points" | "stress"
            ) {
                parts[2] = "NAME";
            }
            let last = parts[parts.len() - 1];
            let (path, group) = (parts.join("/"), parts[..parts.len() - 1].join("/"));
            let is_there = page.contains(&format!("`{path}`"))
                || page.lines().any(|l| l.contains(&format!("`{group}/{{")) && l.contains(last));
            assert!(is_there, "{path}");
        }
        for name in file.attr_names().expect("readable") {
            assert!(page.contains(&format!("| `{name}` |")), "attribute {name}");
        }
    }
}

fn list(group: &hdf5::Group, at: &str, names: &mut Vec<String>) {
    for name in group.member_names().expect("readable") {
        let path = format!("{at}/{name}");
        match group.group(&name) {
            Ok(child) => list(&child, &path, names),
            Err(_) => names.push(path),
        }
    }
}
