//! What must not panic, whatever bytes come: run by `fuzz/` on bytes that a fuzzer finds, by `tests/fuzzing.rs` on random ones.

use std::fmt::Write as _;
use std::path::Path;

use adaptive::store::ModelCache;
use fbimpact::interchange::body_file;
use fbimpact::postprocessing::replay::states::States;
use fbimpact::{scenario, simulate};
use result_files::collect;
use result_files::compare::{Rules, compare};
use result_files::expression::evaluate::evaluate;
use result_files::expression::parse::parse;
use result_files::expression::source::Source;
use result_files::plot::data::ResultData;
use result_files::plot::figures::Kind;
use result_files::plot::render;
use result_files::plot::theme::Page;
use result_files::stored::Stored;
use result_files::stored::{summary, thin};

/// A source of choices.
pub struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self(bytes)
    }

    /// The next byte, zero at the end.
    pub fn next(&mut self) -> u8 {
        let Some((first, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        *first
    }

    pub fn below(&mut self, n: usize) -> usize {
        let high = usize::from(self.next());
        (high << 8 | usize::from(self.next())) % n.max(1)
    }

    /// A number, most often a harmless one.
    pub fn number(&mut self) -> f64 {
        const WORST: [f64; 12] = [
            f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
            -0.0,
            -1.0,
            1e300,
            -1e300,
            1e-300,
            5e-324,
            1e16,
            1e-16,
            0.0,
        ];
        match self.next() {
            b @ 0..=7 => WORST[usize::from(b) + usize::from(self.next() % 5)],
            b @ 8..=39 => f64::from(b - 8) / 8.0,
            _ => f64::from(self.next()) / 256.0,
        }
    }

    fn numbers(&mut self, n: usize) -> String {
        let numbers: Vec<String> = (0..n).map(|_| toml_number(self.number())).collect();
        format!("[{}]", numbers.join(", "))
    }
}

fn toml_number(x: f64) -> String {
    if x.is_nan() {
        "nan".into()
    } else if x.is_infinite() {
        format!("{}inf", if x < 0.0 { "-" } else { "" })
    } else {
        format!("{x:e}")
    }
}

/// A scenario is valid or has located faults; a valid one is valid again as it is stored.
pub fn scenario_text(bytes: &[u8]) {
    match scenario::parse(Path::new("case.toml"), bytes, &[]) {
        Ok(valid) => {
            let again = scenario::parse(Path::new("case.toml"), valid.source.resolved.as_bytes(), &[]);
            assert_eq!(again.unwrap().run, valid.run);
        }
        Err(faults) => assert!(!faults.to_string().is_empty() && !faults.list().is_empty()),
    }
}

/// A plane body of one NURBS patch is built or refused.
pub fn nurbs_data(bytes: &[u8]) {
    let mut b = Bytes::new(bytes);
    let degrees = [1 + b.below(3), 1 + b.below(3)];
    let counts = degrees.map(|p| p + 1 + b.below(3));
    let mut text = String::from(
        "[simulation]\nend_time = 1.0\n[materials.m]\nyoungs_modulus = 1e11\npoissons_ratio = 0.3\ndensity = 1e3\n[bodies.n]\n\
         model = \"plane-strain\"\nmaterial = \"m\"\nreduction = { method = \"modal\", modes = 2 }\n[bodies.n.geometry]\nshape = \"nurbs\"\n",
    );
    let _ = writeln!(text, "degrees = [{}, {}]", degrees[0], degrees[1]);
    let is_wild = b.next() < 64;
    let mut knots = Vec::new();
    for (p, n) in degrees.into_iter().zip(counts) {
        // Open and uniform unless the bytes want it otherwise.
        let inner: Vec<String> = (1..n - p).map(|i| toml_number(i as f64 / (n - p) as f64)).collect();
        let open = [vec!["0.0".to_owned(); p + 1], inner, vec!["1.0".to_owned(); p + 1]].concat();
        let n_knots = n + p + 1 + usize::from(b.next() < 4);
        knots.push(if is_wild { b.numbers(n_knots) } else { format!("[{}]", open.join(", ")) });
    }
    let _ = writeln!(text, "knots = [{}]", knots.join(", "));
    let n = counts[0] * counts[1] + usize::from(b.next() < 4);
    let mut points = Vec::new();
    for i in 0..n {
        let (x, y) = ((i % counts[0]) as f64, (i / counts[0]) as f64);
        let moved = |x: f64, b: &mut Bytes<'_>| if b.next() < 40 { b.number() } else { x };
        points.push(format!("[{}, {}]", toml_number(moved(x, &mut b)), toml_number(moved(y, &mut b))));
    }
    let _ = writeln!(text, "control_points = [{}]", points.join(", "));
    let weights: Vec<String> =
        (0..n).map(|_| toml_number(if b.next() < 200 { 1.0 } else { b.number() })).collect();
    let _ = writeln!(text, "weights = [{}]", weights.join(", "));
    if let Ok(valid) = scenario::parse(Path::new("case.toml"), text.as_bytes(), &[])
        && let Ok(model) = simulate::build(&valid.run, 1, &ModelCache::default())
    {
        let body = &model.bodies[0];
        assert!(body.data.mass.is_finite() && body.data.mass > 0.0, "{text}");
        assert!(body.frequencies().iter().all(|f| f.is_finite() && *f > 0.0), "{text}");
    }
}

/// A body file is read or refused; `folder` takes the file.
pub fn body_import(bytes: &[u8], folder: &Path) {
    let path = folder.join("body.h5");
    std::fs::write(&path, bytes).unwrap();
    match body_file::read(&path) {
        Ok(body) => {
            let _ = (body.markers(), body.points(), body.motion());
        }
        Err(error) => assert!(error.to_string().contains("body.h5")),
    }
}

/// Everything that reads results takes a file or refuses it.
pub fn result_reading(bytes: &[u8], folder: &Path) {
    let path = folder.join("result.h5");
    std::fs::write(&path, bytes).unwrap();
    read_everything(&path, folder);
}

/// All readers, on a file.
pub fn read_everything(path: &Path, folder: &Path) {
    if let Ok(summary) = summary::read(path) {
        let _ = summary.json().to_string();
    }
    if let Ok(stored) = Stored::open(path) {
        let copy = folder.join("thin.h5");
        let _ = thin::write(&stored, &copy, 7);
        let _ = std::fs::remove_file(&copy);
        evaluate_everything(&stored);
    }
    if let Ok(data) = ResultData::read(path, "it".into()) {
        for kind in Kind::USUAL.into_iter().chain([Kind::Spectra]) {
            for figure in kind.figures(std::slice::from_ref(&data)).unwrap_or_default() {
                let _ = render::svg(&figure, Page::default());
            }
        }
    }
    if let Ok(states) = States::read(path) {
        for body in &states.scenario.bodies {
            let _ = states.motion(&body.name).map(|motion| motion.pose(0));
        }
        for contact in &states.scenario.run.contacts {
            let _ = states.contact(&contact.name);
            if let Ok(Some(series)) = states.pressures(&contact.name) {
                let entries = (0..states.time.len()).flat_map(|i| series.range(i));
                entries.for_each(|k| {
                    let _ = (series.pressure[k], series.position[series.point[k] as usize]);
                });
            }
        }
    }
    let rules = Rules::read(None, None, None).unwrap();
    if let Ok(comparison) = compare(path, path, &rules) {
        let _ = (comparison.table(), comparison.json().to_string());
    }
    let runs = collect::find(&[path.to_owned()], &["v=bodies.ball.velocity[-1]".parse().unwrap()]).unwrap();
    for is_long in [false, true] {
        let _ = collect::csv(&collect::gather(&runs, is_long));
    }
}

/// Expressions over all that a result holds have a value or a fault.
fn evaluate_everything(stored: &Stored) {
    let source = Source::new(stored);
    let tables =
        ["impacts.peak_force", "tries.interval_widths", "contacts.impact.impacts.start", "scenario.bodies"];
    let datasets = stored
        .entries
        .keys()
        .map(|path| path.split('/').map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join("."));
    for path in datasets.chain(tables.map(str::to_owned)) {
        for text in [
            "#",
            "#[-1]",
            "#[1:].z",
            "max(#)",
            "norm(#) + #",
            "at(#, 1e-5)",
            "integral(#)",
            "time_of_max(#[0:])",
        ] {
            if let Ok(expression) = parse(&text.replace("#", &path)) {
                let _ = evaluate(&expression, &source);
            }
        }
    }
}

/// Replaces datasets of the HDF5 file `path` by wrong ones, as the bytes say.
pub fn damage(path: &Path, bytes: &[u8]) {
    let mut b = Bytes::new(bytes);
    // Without a lock, which programs started by other tests meanwhile would inherit and keep.
    let file = hdf5::File::with_options().with_fapl(|p| p.file_locking(false)).open_rw(path).unwrap();
    let mut names = Vec::new();
    list(&file, "", &mut names);
    for _ in 0..1 + b.below(3) {
        let name = names[b.below(names.len())].clone();
        let old = file.dataset(&name).ok();
        let shape = old.as_ref().map(|d| d.shape()).unwrap_or_default();
        let what = b.below(8);
        if what == 0 {
            // A value in place.
            if let Some(old) = old
                && let Ok(mut values) = old.read_raw::<f64>()
                && !values.is_empty()
            {
                let at = b.below(values.len());
                values[at] = b.number();
                let _ = old.write_raw(&values);
            }
            continue;
        }
        drop(old);
        if file.unlink(&name).is_err() {
            continue;
        }
        let rows = shape.first().copied().unwrap_or(1);
        let shape: Vec<usize> = match what {
            1 => continue,
            2 => vec![],
            3 => vec![0],
            4 => vec![rows + 1],
            5 => [&[rows.saturating_sub(1)], shape.get(1..).unwrap_or_default()].concat(),
            6 => vec![rows, 2],
            _ => {
                let _ = file.create_group(&name);
                continue;
            }
        };
        let n: usize = shape.iter().product();
        let values: Vec<f64> = (0..n).map(|_| b.number()).collect();
        if let Ok(new) = file.new_dataset::<f64>().shape(shape).create(name.as_str()) {
            let _ = new.write_raw(&values);
        }
    }
}

fn list(group: &hdf5::Group, at: &str, names: &mut Vec<String>) {
    for name in group.member_names().unwrap_or_default() {
        let path = if at.is_empty() { name.clone() } else { format!("{at}/{name}") };
        if let Ok(child) = group.group(&name) {
            list(&child, &path, names);
        }
        names.push(path);
    }
}

/// Bytes as a matrix, an order of unknowns and nodes, and as each of them among those of a bar.
pub fn matrix_reading(bytes: &[u8]) {
    let rows = include_bytes!("../matrix_parts/bar.sti");
    let map = include_bytes!("../matrix_parts/bar.dof");
    matrices(bytes, (rows, map, include_bytes!("../matrix_parts/bar.inp")));
}

/// Bytes as a matrix, an order of unknowns and nodes, and as each of them among others that are sound.
pub fn matrices(bytes: &[u8], (rows, map, nodes): (&[u8], &[u8], &[u8])) {
    use fbimpact::interchange::matrix_files::{Parts, assemble, read_map, read_matrix, read_nodes};
    let text = String::from_utf8_lossy(bytes);
    let given = (read_matrix(&text, None).ok(), read_map(&text).ok(), read_nodes(&text).ok());
    drop(read_matrix(&text, Some("kaax")));
    if given == (None, None, None) {
        return;
    }
    let sound = [rows, map, nodes].map(String::from_utf8_lossy);
    let (Ok(matrix), Ok(map), Ok(nodes)) =
        (read_matrix(&sound[0], None), read_map(&sound[1]), read_nodes(&sound[2]))
    else {
        return;
    };
    let stiffness = given.0.as_ref().unwrap_or(&matrix);
    let parts = Parts {
        name: "body",
        stiffness,
        mass: &matrix,
        nodes: given.2.as_ref().unwrap_or(&nodes),
        map: Some(given.1.as_ref().unwrap_or(&map)),
        unit: 1e-3,
        markers: &[("a".to_owned(), vec![1, 101])],
    };
    drop(assemble(&parts));
    drop(assemble(&Parts { map: None, ..parts }));
}
