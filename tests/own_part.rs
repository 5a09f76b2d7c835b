//! The page docs/own_part.md from a STEP file to an impact and its pictures, as `scripts/own_part.py` follows it: where Gmsh's Python module is.

use std::path::Path;
use std::process::Command;

use hdf5::File;

#[test]
#[ignore = "second tier: needs Gmsh's Python module"]
fn the_page_leads_from_step_to_an_impact() {
    let python = std::env::var("FBIMPACT_PYTHON").unwrap_or_else(|_| "python3".into());
    let has_gmsh = Command::new(&python).args(["-c", "import gmsh"]).output();
    if !has_gmsh.is_ok_and(|run| run.status.success()) {
        println!(
            "skipped: {python} has no module gmsh; pip install gmsh, or name another Python in FBIMPACT_PYTHON"
        );
        return;
    }
    let folder = tempfile::TempDir::new().unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts/own_part.py");
    let run = Command::new(&python)
        .arg(script)
        .arg(folder.path())
        .args(["--fbimpact", env!("CARGO_BIN_EXE_fbimpact")])
        .output()
        .unwrap();
    let said = format!("{}{}", String::from_utf8_lossy(&run.stdout), String::from_utf8_lossy(&run.stderr));
    assert!(run.status.success(), "{said}");
    // The page's figure.
    let file = File::open(folder.path().join("pin.h5")).unwrap();
    let force: Vec<f64> = file.dataset("contacts/impact/normal_force").unwrap().read_raw().unwrap();
    let peak = force.into_iter().fold(0.0_f64, f64::max);
    println!("peak {peak:.2} N");
    // Hertz's law for two masses: a pin of 90 g with a round end of 10 mm at 0.1 m/s; waves and the smooth surface of the mesh take some percent.
    assert!((peak / HERTZ - 1.0).abs() < 0.05, "{peak}");
}

/// $F = k^{2/5}(\tfrac54 m v^2)^{3/5}$, $k = \tfrac43 E^*\sqrt R$ \[N\].
const HERTZ: f64 = 266.4;
