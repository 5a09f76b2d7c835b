//! The table of shapes in the program names the markers and faces that the geometry has.

use std::collections::BTreeSet;
use std::path::Path;

use fbimpact::scenario;
use fbimpact::scenario::keys::Named;
use fbimpact::scenario::tables::{ModelFacts, ShapeName};

#[test]
fn folded_net_is_a_located_fault() {
    let text = "[simulation]\nend_time = 1e-6\n\
         [materials.m]\nyoungs_modulus = 1e9\npoissons_ratio = 0.3\ndensity = 1e3\n\
         [bodies.b]\nmodel = \"plane-strain\"\nmaterial = \"m\"\n[bodies.b.geometry]\nshape = \"nurbs\"\n\
         degrees = 1\nknots = [[0, 0, 1, 1], [0, 0, 1, 1]]\ncontrol_points = [[0, 0], [1, 0], [1, 1], [0, 1]]\n";
    let faults = scenario::parse(Path::new("t.toml"), text.as_bytes(), &[]).unwrap_err();
    let [fault] = faults.list() else { panic!("{faults}") };
    assert_eq!((fault.key.as_str(), fault.line()), ("bodies.b.geometry.control_points", Some(14)));
    assert!(fault.message.starts_with("patch 0: geometry is folded or inside out"), "{fault}");
}

/// A geometry table with sizes for the shape.
fn geometry(shape: &str, model: &str) -> String {
    let sizes = match shape {
        "sphere" | "disc" => "radius = 0.01",
        "ellipsoid" if model == "axisymmetric" => "semi_axes = [0.015, 0.015, 0.01]",
        "ellipsoid" => "semi_axes = [0.02, 0.015, 0.01]",
        "rod" | "rod-spherical-end" | "cylinder" => "radius = 0.01, length = 0.05",
        "hollow-cylinder" => "inner_radius = 0.005, outer_radius = 0.01, length = 0.05",
        "tube-sector" => "inner_radius = 0.005, outer_radius = 0.01, length = 0.05, angle_deg = 60.0",
        "cone" => "radius = 0.01, end_radius = 0.005, length = 0.05",
        "capsule" => "radius = 0.01, length = 0.05",
        "rounded-cylinder" => "radius = 0.01, length = 0.05, crown_radius = 0.02, fillet_radius = 0.001",
        "torus" => "radius = 0.02, tube_radius = 0.005",
        "rounded-box" => "size = [0.01, 0.02, 0.03], fillet_radius = 0.002",
        "plate-with-hole" if model == "solid" => {
            "size = [0.04, 0.02], hole_radius = 0.005, thickness = 0.002"
        }
        "plate-with-hole" => "size = [0.04, 0.02], hole_radius = 0.005",
        "l-beam" => "width = 0.02, height = 0.03, thickness = 0.002, length = 0.2",
        "t-beam" => {
            "width = 0.02, height = 0.03, flange_thickness = 0.002, web_thickness = 0.003, length = 0.2"
        }
        "gear-tooth" if model == "solid" => "module = 0.005, teeth = 20, inner_radius = 0.03, width = 0.02",
        "gear-tooth" => "module = 0.005, teeth = 20, inner_radius = 0.03",
        "box" => "size = [0.01, 0.02, 0.03]",
        "rectangle" => "size = [0.01, 0.02]",
        other => panic!("no sizes for {other}"),
    };
    format!("{{ shape = \"{shape}\", {sizes} }}")
}

#[test]
fn every_named_shape_is_built_with_the_markers_and_faces_of_its_table() {
    for &shape in ShapeName::VALUES {
        for ModelFacts { model, markers, faces } in shape.models() {
            if markers.is_empty() {
                continue;
            }
            let (name, model) = (shape.name(), model.name());
            let text = format!(
                "[simulation]\nend_time = 1e-6\n\
                 [materials.m]\nyoungs_modulus = 1e9\npoissons_ratio = 0.3\ndensity = 1e3\n\
                 [bodies.b]\nmodel = \"{model}\"\nmaterial = \"m\"\ngeometry = {}\n{}\
                 reduction = {{ method = \"modal\", modes = 3 }}\n",
                geometry(name, model),
                if model.starts_with("plane") { "thickness = 0.01\n" } else { "" },
            );
            let scenario = scenario::parse(Path::new("t.toml"), text.as_bytes(), &[]).unwrap();
            let built = &scenario.run.bodies[0].elastic().expect("elastic").shape;
            let sorted = |names: &[&str]| names.iter().map(|n| (*n).to_owned()).collect::<BTreeSet<_>>();
            let found = built.markers.keys().cloned().collect();
            assert_eq!(sorted(markers), found, "{name} as {model}");
            let found = built.faces.keys().cloned().collect();
            assert_eq!(sorted(faces), found, "{name} as {model}");
        }
    }
}
