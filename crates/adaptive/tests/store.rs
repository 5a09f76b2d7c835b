//! Models kept between runs: the same results with and without, keys that tell models apart, equal bodies built once.

use crate::impacts;
use std::convert::Infallible;
use std::sync::{Arc, Mutex};

use crate::bodies::{block, sphere, wanted_at};
use crate::impacts::{STEEL, contact, law, spec};
use adaptive::body::fine::refined::FineSettings;
use adaptive::body::fine::refined::zone_definition;
use adaptive::body::reduced::Interface;
use adaptive::body::reduced::modes_key;
use adaptive::model::RunModel;
use adaptive::run::driver::run;
use adaptive::run::recording::Recording;
use adaptive::spec::DivisionRule;
use adaptive::spec::{
    BodyKind, DampingSpec, ElasticSpec, FrameSpec, InterfaceModes, IntervalSpec, PenaltySearch, Place,
    ReductionSpec, RefinementSpec, RunSpec, Target, Treatment,
};
use adaptive::store::{CacheUse, ModelCache, ModelKey, ModelStore, StoredModel, body_definition};
use iga_core::elasticity::{Material, Model};
use iga_core::nurbs::primitives::sphere::SphereNet;
use iga_core::nurbs::primitives::{self, solid};

/// Models in memory, and what was asked for.
#[derive(Default)]
struct Shelf {
    models: Mutex<Vec<(ModelKey, StoredModel)>>,
    asked: Mutex<Vec<&'static str>>,
}

impl ModelStore for Shelf {
    fn load(&self, key: &ModelKey) -> Option<StoredModel> {
        self.asked.lock().unwrap().push(key.kind);
        let models = self.models.lock().unwrap();
        models.iter().find(|(k, _)| k == key).map(|(_, model)| model.clone())
    }

    fn save(&self, key: &ModelKey, model: &StoredModel) {
        self.models.lock().unwrap().push((key.clone(), model.clone()));
    }
}

/// Everything that a run reports, by the bits of its numbers, and how it used `store`.
fn traced(spec: &RunSpec, store: Option<&Arc<Shelf>>) -> (String, CacheUse) {
    let cache = store.map_or_else(ModelCache::default, |s| ModelCache::new(Arc::clone(s) as _));
    let mut model = RunModel::build_with(spec, &cache).unwrap_or_else(|e| panic!("{e}"));
    let mut trace = Recording::default();
    run(&mut model, &spec.settings, &mut trace).unwrap_or_else(|e| panic!("{e}"));
    trace.phases.iter_mut().for_each(|p| p.wall_time = 0.0);
    trace.trials.iter_mut().for_each(|t| (t.wall_time, t.cpu_time) = (0.0, 0.0));
    // Debug prints the shortest text that gives the number back, so equal texts are equal numbers.
    let Recording { samples, phases, impacts, trials, transfers, .. } = &trace;
    let text = format!("{samples:?} {phases:?} {impacts:?} {trials:?} {transfers:?}");
    assert_eq!(cache.used(), model.timings().cache);
    (text, cache.used())
}

/// A ball that falls on another one.
fn two_spheres() -> RunSpec {
    let bodies = vec![
        impacts::sphere("lower", 0.01, STEEL, (0.0, 0.0)),
        impacts::sphere("upper", 0.01, STEEL, (0.02 + 1e-7, -0.1)),
    ];
    spec(bodies, vec![contact("c", 1, Target::Body(0))], 60e-6)
}

/// The same in three dimensions with few elements, for a moment.
fn two_balls() -> RunSpec {
    let mut run = two_spheres();
    for body in &mut run.bodies {
        let BodyKind::Elastic(elastic) = &mut body.kind else { panic!("elastic") };
        elastic.shape = primitives::sphere::sphere(0.01, SphereNet::for_degree(2)).unwrap().into();
        elastic.model = Model::Solid;
        let knots = elastic.shape.patches[0].knots();
        elastic.discretisation.degrees = knots.iter().map(|k| k.degree().max(2)).collect();
        elastic.discretisation.elements = vec![4, 2, 2];
        elastic.flexible.reduction = ReductionSpec::Modal { modes: 7 };
    }
    // Above each other the balls touch at poles, where the net is turned.
    let mut law = law();
    law.treatment = Treatment::Quasistatic;
    law.interval = IntervalSpec { width: Some(4e-4), elements: Some(4), ..IntervalSpec::default() };
    law.search = PenaltySearch::Fixed;
    law.penalty = Some(1e16);
    run.contacts[0].law = adaptive::spec::ContactLaw::Surface(law);
    run.settings.end_time = 8e-6;
    run.settings.free_interval = Some(1e-6);
    run
}

/// Fails where two reports begin to differ.
fn same(a: &str, b: &str, what: &str) {
    let differs = a.bytes().zip(b.bytes()).position(|(x, y)| x != y);
    let place = differs.unwrap_or(a.len().min(b.len()));
    let part = |text: &str| text[place.saturating_sub(80)..(place + 80).min(text.len())].to_owned();
    assert!(a == b, "{what}: {} instead of {}", part(b), part(a));
}

/// How the store was used that was empty.
fn runs_agree(spec: &RunSpec) -> CacheUse {
    let store = Arc::new(Shelf::default());
    let (without, unused) = traced(spec, None);
    let (cold, first) = traced(spec, Some(&store));
    let (warm, second) = traced(spec, Some(&store));
    same(&without, &cold, "empty store");
    same(&without, &warm, "full store");
    assert_eq!(unused, CacheUse { fine_models: first.fine_models, ..CacheUse::default() });
    // The modes and a fine model, which equal balls share.
    assert!(first.hits == 0 && first.misses >= 2, "{first:?}");
    assert_eq!((second.hits, second.misses), (first.misses, 0));
    assert!(first.fine_models >= 1 && second.fine_models == 0, "{first:?} {second:?}");
    // Equal bodies are looked up once per run.
    let asked = store.asked.lock().unwrap();
    assert_eq!(asked.iter().filter(|kind| **kind == "modes").count(), 2);
    first
}

#[test]
fn axisymmetric_runs_are_the_same_without_a_store_with_an_empty_and_with_a_full_one() {
    runs_agree(&two_spheres());
}

#[test]
fn solid_runs_are_the_same_without_a_store_with_an_empty_and_with_a_full_one() {
    // Both balls are touched in one place of the turned net.
    assert_eq!(runs_agree(&two_balls()).fine_models, 1);
}

#[test]
fn stored_models_that_do_not_fit_are_built_anew() {
    let store = Arc::new(Shelf::default());
    let spec = two_spheres();
    let (good, _) = traced(&spec, Some(&store));
    let cuts: [fn(&mut StoredModel); 4] = [
        |m| m.values.truncate(3),
        |m| m.values.push(0.0),
        |m| m.values.clear(),
        |m| {
            m.counts.iter_mut().for_each(|n| *n = u64::MAX);
            m.values.pop();
        },
    ];
    for cut in cuts {
        store.models.lock().unwrap().iter_mut().for_each(|(_, model)| cut(model));
        let (again, used) = traced(&spec, Some(&store));
        same(&good, &again, "cut models");
        assert_eq!(used.hits, 0);
    }
}

#[test]
fn everything_that_changes_the_matrices_changes_the_definition() {
    let base = block(2).spec;
    let changes: [fn(&mut ElasticSpec); 11] = [
        |s| s.shape = solid::cuboid([0.02, 0.02, 0.020_000_000_000_000_003]).unwrap().into(),
        |s| Arc::make_mut(&mut s.shape).symmetry = Some(iga_core::nurbs::Symmetry::ball(&[[1.0, 0.0, 0.0]])),
        |s| {
            Arc::make_mut(&mut s.shape).symmetry =
                Some(iga_core::nurbs::Symmetry::about_z(&[[1.0, 0.0, 0.0]]))
        },
        |s| s.model = Model::PlaneStrain { thickness: 1.0 },
        |s| s.model = Model::PlaneStress { thickness: 1.0 },
        |s| s.model = Model::PlaneStress { thickness: 1.0f64.next_up() },
        |s| s.material = Material::new(210e9, 0.3, 7850.0f64.next_up()).unwrap(),
        |s| s.discretisation.degrees = vec![2, 2, 3],
        |s| s.discretisation.elements = vec![2, 3, 2],
        |s| s.discretisation.knots = Some(vec![vec![0.5], vec![0.5], vec![]]),
        |s| {
            let (width, elements, ratio) = (1e-3, 4, 2.0);
            s.discretisation.refine.push(RefinementSpec { centre: [0.0; 3], width, elements, ratio });
        },
    ];
    let mut definitions = vec![body_definition(&base)];
    for change in changes {
        let mut spec = base.clone();
        change(&mut spec);
        definitions.push(body_definition(&spec));
    }
    let n = definitions.len();
    definitions.sort();
    definitions.dedup();
    assert_eq!(definitions.len(), n);
}

#[test]
fn what_comes_after_the_matrices_changes_no_definition() {
    let base = block(2).spec;
    let mut other = base.clone();
    other.flexible.damping = DampingSpec::Modal(vec![0.1]);
    other.flexible.frame = FrameSpec::Tangent(Place::Point([0.0; 3]));
    other.flexible.reduction = ReductionSpec::All;
    other.flexible.geometric_stiffening = true;
    Arc::make_mut(&mut other.shape).markers.insert("tip".into(), [0.0; 3]);
    assert_eq!(body_definition(&base), body_definition(&other));
}

#[test]
fn modes_are_told_apart_by_reduction_and_interface() {
    let craig_bampton =
        |modes, fixed_interface_modes| ReductionSpec::CraigBampton { modes, fixed_interface_modes };
    let interface =
        |unknowns: &[usize], modes| Interface { unknowns: unknowns.to_vec(), modes, ..Interface::default() };
    let (dynamic, quasistatic) = (InterfaceModes::Dynamic, InterfaceModes::Quasistatic);
    let cases = [
        (ReductionSpec::Modal { modes: 6 }, interface(&[], dynamic)),
        (ReductionSpec::Modal { modes: 7 }, interface(&[], dynamic)),
        (ReductionSpec::All, interface(&[], dynamic)),
        (craig_bampton(6, None), interface(&[1, 2], dynamic)),
        (craig_bampton(6, None), interface(&[1, 3], dynamic)),
        (craig_bampton(6, None), interface(&[1, 2], quasistatic)),
        (craig_bampton(6, Some(1)), interface(&[1, 2], dynamic)),
        (craig_bampton(6, Some(2)), interface(&[1, 2], dynamic)),
    ];
    let no_loads = faer::Mat::zeros(4, 0);
    let keys: Vec<ModelKey> = cases.iter().map(|(r, i)| modes_key(b"body", *r, i, &no_loads)).collect();
    for (i, key) in keys.iter().enumerate() {
        assert!(!keys[..i].contains(key), "case {i}");
    }
    // Nothing is held and nothing static: these are the free modes, and damped modes are the dynamic ones.
    let loaded = |force: f64| {
        let load = faer::Mat::from_fn(4, 1, |i, _| if i == 2 { force } else { 0.0 });
        modes_key(b"body", craig_bampton(6, None), &interface(&[], dynamic), &load)
    };
    assert!(loaded(1.0) != keys[0] && loaded(1.0) != loaded(2.0) && loaded(1.0) == loaded(1.0));
    assert_eq!(modes_key(b"body", craig_bampton(6, None), &interface(&[], dynamic), &no_loads), keys[0]);
    assert_eq!(
        modes_key(b"body", craig_bampton(6, None), &interface(&[1, 2], InterfaceModes::Damped), &no_loads),
        keys[3]
    );
}

#[test]
fn fine_models_are_told_apart_by_the_last_bit_of_interval_and_settings() {
    let body = sphere([4, 4]);
    let (wanted, settings) = (wanted_at(&body, [0.0, -0.01, 0.0], 3e-4), FineSettings::default());
    let key = |wanted, settings| zone_definition(&body, &[wanted], &settings).0;
    let mut keys = vec![key(wanted, settings)];
    let mut other = wanted;
    other.widths[0] = other.widths[0].next_up();
    keys.push(key(other, settings));
    let mut other = wanted;
    other.centre[0] = other.centre[0].next_up();
    keys.push(key(other, settings));
    keys.push(key(wanted, FineSettings { elements: 20, ..settings }));
    keys.push(key(wanted, FineSettings { division: DivisionRule::Printed, ..settings }));
    keys.push(key(wanted, FineSettings { growth: Some(1), ..settings }));
    keys.push(zone_definition(&body, &[], &settings).0);
    keys.push(zone_definition(&body, &[wanted, other], &settings).0);
    for (i, key) in keys.iter().enumerate() {
        assert!(!keys[..i].contains(key), "case {i}");
    }
    assert!(key(wanted, settings) == keys[0]);
}

#[test]
fn an_error_of_a_build_is_passed_on_and_nothing_is_kept() {
    let store = Arc::new(Shelf::default());
    let cache = ModelCache::new(Arc::clone(&store) as _);
    let key = || ModelKey { kind: "test", definition: vec![1] };
    let failed = cache.stored(key, |_| Some(0), || Err("no"), |_| StoredModel::default());
    assert_eq!(failed, Err("no"));
    assert!(store.models.lock().unwrap().is_empty());
    let built = cache.stored(key, |_| Some(0), || Ok::<_, Infallible>(1), |_| StoredModel::default());
    assert_eq!(built, Ok(1));
    assert_eq!(cache.stored(key, |_| Some(0), || Ok::<_, Infallible>(1), |_| StoredModel::default()), Ok(0));
    assert_eq!((cache.used().hits, cache.used().misses), (1, 1));
}

#[test]
fn models_used_last_are_not_built_again_where_there_is_no_store() {
    let cache = ModelCache::default();
    let key = |n: u8| ModelKey { kind: "test", definition: vec![n] };
    let encode = |n: &u64| StoredModel { counts: vec![*n], values: Vec::new() };
    let decode = |stored: &StoredModel| stored.counts.first().copied();
    assert_eq!(cache.recent(key(1), decode, || Ok::<_, Infallible>(7), encode), Ok(7));
    assert_eq!(cache.recent(key(1), decode, || Err("built again"), encode), Ok(7));
    assert_eq!(cache.recent(key(2), decode, || Err("another model"), encode), Err("another model"));
    // A clone is the same cache.
    assert_eq!(cache.clone().recent(key(1), decode, || Err("built again"), encode), Ok(7));
}
