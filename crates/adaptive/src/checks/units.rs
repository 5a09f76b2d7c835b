//! Numbers that look as if they were given in other units: materials that nothing is made of, parts
//! that nobody makes (docs/theory.md Eq. P.5).

use std::fmt;

use iga_core::elasticity::Material;

use crate::spec::RunSpec;

/// Speeds of waves along a rod of solids, from soft rubber to diamond [m/s].
const WAVE_SPEEDS: [f64; 2] = [0.1e3, 20e3];
/// Densities, from aerogel to osmium with some room [kg/m³].
const DENSITIES: [f64; 2] = [1.0, 30e3];
/// Solids that are lighter are foams and aerogels, which are soft: stiff ones have their density in
/// other units [kg/m³].
const LIGHT: f64 = 30.0;
/// Sizes of parts \[m\].
const SIZES: [f64; 2] = [1e-6, 1e4];
/// What a material of engineering has, by which systems of units are told apart: modulus \[Pa\],
/// density [kg/m³], speed of waves [m/s].
const COMMON: [[f64; 2]; 3] = [[1e6, 1.3e12], [300.0, 23e3], [0.3e3, 13e3]];

/// Units of material constants: name, pascals in a unit of the modulus, kg/m³ in a unit of the
/// density, metres in a unit of length.
const SYSTEMS: [(&str, f64, f64, f64); 11] = [
    ("tonne, mm, s (MPa)", 1e6, 1e12, 1e-3),
    ("kg, mm, ms (GPa)", 1e9, 1e9, 1e-3),
    ("g, mm, ms (MPa)", 1e6, 1e6, 1e-3),
    ("kg, mm, s (kPa)", 1e3, 1e9, 1e-3),
    ("kg, µm, s (MPa)", 1e6, 1e18, 1e-6),
    ("lbf s²/in, in, s (psi)", 6_894.757, 1.068_689e7, 0.0254),
    ("g, cm, s (dyn/cm²)", 0.1, 1e3, 1e-2),
    ("MPa beside kg/m³", 1e6, 1.0, 1.0),
    ("GPa beside kg/m³", 1e9, 1.0, 1.0),
    ("MPa beside g/cm³", 1e6, 1e3, 1.0),
    ("GPa beside g/cm³", 1e9, 1e3, 1.0),
];

/// A body whose numbers are doubtful.
#[derive(Debug, Clone, PartialEq)]
pub struct UnitsDoubt {
    /// Name of the body.
    pub body: String,
    /// The property that is doubtful.
    pub what: Doubtful,
}

/// A property of a body that is doubtful.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Doubtful {
    /// Its material.
    Material(Material),
    /// Its size \[m\].
    Size(f64),
}

impl fmt::Display for UnitsDoubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let body = &self.body;
        match &self.what {
            Doubtful::Material(material) => {
                let (modulus, density) = (material.youngs_modulus(), material.density());
                let speed = material.bar_speed();
                write!(
                    f,
                    "body \"{body}\": no solid has a Young's modulus of {modulus:.3e} Pa with a density of {density:.3e} kg/m³"
                )?;
                if is_within(speed, WAVE_SPEEDS) && is_within(density, DENSITIES) {
                    write!(f, " (it would be a foam)")?;
                } else if is_within(speed, WAVE_SPEEDS) {
                    write!(f, " (densities are between {} and {:.0} kg/m³)", DENSITIES[0], DENSITIES[1])?;
                } else {
                    let [slow, fast] = WAVE_SPEEDS.map(|c| 1e-3 * c);
                    write!(
                        f,
                        ": waves would travel at {:.3e} km/s, in solids it is {slow} to {fast} km/s",
                        1e-3 * speed
                    )?;
                }
                match likely_system(material) {
                    Some((name, modulus_unit, density_unit, length)) => {
                        write!(
                            f,
                            "; this looks like {name}: give SI units, youngs_modulus = {:.4e}, density = {:.4e}",
                            modulus * modulus_unit,
                            density * density_unit
                        )?;
                        if length < 1.0 {
                            write!(f, ", lengths times {length}")?;
                        }
                        write!(f, ", or numbers with their units (\"210 GPa\")")
                    }
                    None => write!(f, "; check its units, which are Pa and kg/m³"),
                }
            }
            Doubtful::Size(size) => write!(
                f,
                "body \"{body}\" is {size:.3e} m large; check its unit of length, numbers are metres unless they have a unit (\"10 mm\")"
            ),
        }
    }
}

/// Bodies of `spec` with such numbers; of bodies with the same material the first.
pub fn doubts(spec: &RunSpec) -> Vec<UnitsDoubt> {
    let mut found: Vec<UnitsDoubt> = Vec::new();
    for body in &spec.bodies {
        let (materials, size) = (body.kind.materials(), body.kind.diagonal().unwrap_or_default());
        for material in materials.into_iter().filter(|m| !is_plausible(m)) {
            let what = Doubtful::Material(material);
            if found.iter().all(|doubt| doubt.what != what) {
                found.push(UnitsDoubt { body: body.name.clone(), what });
            }
        }
        if size > 0.0 && !is_within(size, SIZES) {
            found.push(UnitsDoubt { body: body.name.clone(), what: Doubtful::Size(size) });
        }
    }
    found
}

fn is_within(value: f64, [lower, upper]: [f64; 2]) -> bool {
    (lower..=upper).contains(&value)
}

fn is_plausible(material: &Material) -> bool {
    let is_of_another_system = material.density() < LIGHT && likely_system(material).is_some();
    is_within(material.bar_speed(), WAVE_SPEEDS)
        && is_within(material.density(), DENSITIES)
        && !is_of_another_system
}

/// The first system of units in which `material` is one of engineering.
fn likely_system(material: &Material) -> Option<(&'static str, f64, f64, f64)> {
    SYSTEMS.into_iter().find(|(_, modulus_unit, density_unit, _)| {
        let (modulus, density) =
            (material.youngs_modulus() * modulus_unit, material.density() * density_unit);
        let all = [modulus, density, (modulus / density).sqrt()];
        all.into_iter().zip(COMMON).all(|(value, range)| is_within(value, range))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn material(modulus: f64, density: f64) -> Material {
        Material::new(modulus, 0.3, density).expect("positive")
    }

    #[test]
    fn solids_pass_and_units_are_named() {
        // Steel, aluminium, diamond, lead, rubber, cork, foam, polystyrene foam, tungsten,
        // beryllium.
        let solids = [
            [210e9, 7850.0],
            [70e9, 2700.0],
            [1.05e12, 3515.0],
            [16e9, 11340.0],
            [50e6, 1100.0],
            [20e6, 200.0],
            [10e6, 50.0],
            [5e6, 20.0],
            [400e9, 19300.0],
            [287e9, 1850.0],
        ];
        for [modulus, density] in solids {
            assert!(is_plausible(&material(modulus, density)), "{modulus} {density}");
        }
        // Steel in each system, and aluminium, whose numbers are not to be taken for another one.
        for (name, modulus_unit, density_unit, _) in SYSTEMS {
            for [modulus, density] in [[210e9, 7850.0], [70e9, 2700.0]] {
                let given = material(modulus / modulus_unit, density / density_unit);
                assert!(!is_plausible(&given), "{name}");
                let found = likely_system(&given).expect(name);
                assert_eq!(found.0, name);
            }
        }
        assert_eq!(likely_system(&material(1e-3, 1e9)), None);
    }

    #[test]
    fn message_has_the_numbers_to_write() {
        let doubt = UnitsDoubt { body: "rod".into(), what: Doubtful::Material(material(210_000.0, 7.85e-9)) };
        let text = doubt.to_string();
        for part in
            ["\"rod\"", "tonne, mm, s", "youngs_modulus = 2.1000e11", "density = 7.8500e3", "times 0.001"]
        {
            assert!(text.contains(part), "{text}");
        }
    }
}
