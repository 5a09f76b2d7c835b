//! Examples of every command, shown by `--help` and by the manual pages.

/// A command line and what it does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Example {
    /// What it does, as a fragment.
    pub does: &'static str,
    /// As typed.
    pub line: &'static str,
}

const fn example(does: &'static str, line: &'static str) -> Example {
    Example { does, line }
}

/// Examples by command; those of a command below another one under both names. The program itself
/// has the empty name.
pub const EXAMPLES: &[(&str, [Example; 2])] = &[
    (
        "",
        [
            example("a first run, from nothing to a page to look at", "fbimpact new drop"),
            example("then", "fbimpact run drop.toml"),
        ],
    ),
    (
        "new",
        [
            example("write drop.toml, a ball that falls on a floor", "fbimpact new drop"),
            example(
                "write bracket.toml and bracket.msh, a part from CAD that falls",
                "fbimpact new bracket --mesh bracket.step --material aluminium",
            ),
        ],
    ),
    (
        "check",
        [
            example("every fault of two scenarios, nothing is built", "fbimpact check drop.toml rig.toml"),
            example(
                "read a scenario that another program writes, with what a run takes",
                "fbimpact check --cost -",
            ),
        ],
    ),
    (
        "schema",
        [
            example("print it", "fbimpact schema"),
            example("print it without a word on standard error", "fbimpact schema -q"),
        ],
    ),
    (
        "mesh-size",
        [
            example("how fine the meshes are to be", "fbimpact mesh-size rig.toml"),
            example(
                "write a script with sizes for Gmsh",
                "fbimpact mesh-size rig.toml --body part -o sizes.geo",
            ),
        ],
    ),
    (
        "run",
        [
            example(
                "simulate at another speed, into another file",
                "fbimpact run drop.toml --set bodies.ball.velocity[2]=-0.5 -o fast.h5",
            ),
            example("go on with a run that was stopped", "fbimpact run --resume fast.h5"),
        ],
    ),
    (
        "static",
        [
            example("how a part rests under its weight, and what holds it", "fbimpact static rig.toml"),
            example(
                "the same at another load, as JSON",
                "fbimpact static rig.toml --set loads.push.force[2]=-500.0 --json",
            ),
        ],
    ),
    (
        "converge",
        [
            example("is it right to 1 %?", "fbimpact converge drop.toml"),
            example(
                "is it right to 5 %, two runs at a time, as JSON",
                "fbimpact converge drop.toml --tolerance 0.05 --jobs 2 --json",
            ),
        ],
    ),
    (
        "drop",
        [
            example(
                "onto its faces, edges and corners from 1.2 m, which is the worst?",
                "fbimpact drop bracket.msh --units mm --height 1.2",
            ),
            example(
                "40 directions, with acceleration at a point, two runs at a time",
                "fbimpact drop bracket.step --height 1.2 --toward 40 --at board=0,0.01,0.002 --jobs 2",
            ),
        ],
    ),
    (
        "modes",
        [
            example("modes of one body", "fbimpact modes rig.toml --body part"),
            example("modes of all bodies as joints hold them", "fbimpact modes rig.toml --system"),
        ],
    ),
    (
        "info",
        [
            example("phases, impacts, reactions, energy", "fbimpact info drop.h5"),
            example("the same for a program", "fbimpact info drop.h5 --json"),
        ],
    ),
    (
        "plot",
        [
            example("all figures as SVG, into a folder", "fbimpact plot drop.h5 -o figures"),
            example(
                "impacts of two results in one figure, for LaTeX",
                "fbimpact plot drop.h5 fast.h5 --figure impacts --pdf",
            ),
        ],
    ),
    (
        "report",
        [
            example("one page to look at and to send", "fbimpact report drop.h5"),
            example("two results side by side", "fbimpact report drop.h5 fast.h5 -o both.html"),
        ],
    ),
    (
        "probe",
        [
            example(
                "stress over time at a point that the scenario did not name",
                "fbimpact probe drop.h5 --body ball --point 0.0,-0.005",
            ),
            example(
                "along a line, as JSON",
                "fbimpact probe drop.h5 --body ball --line 0,-0.01:0,0.01:11 --json",
            ),
        ],
    ),
    (
        "metric",
        [
            example("the largest force", "fbimpact metric drop.h5 'max(contacts.impact.normal_force)'"),
            example("a number with a name", "fbimpact metric drop.h5 'rebound=bodies.ball.velocity[-1].z'"),
        ],
    ),
    (
        "export",
        [
            example(
                "bodies in motion for ParaView, at peaks of impacts",
                "fbimpact export drop.h5 --vtk paraview --times peak",
            ),
            example("look at a scenario before its run", "fbimpact export rig.toml --vtk setup"),
        ],
    ),
    (
        "compare",
        [
            example("does a new result agree with a kept one?", "fbimpact compare drop.h5 reference/drop.h5"),
            example(
                "with 1 % of the peaks allowed, as JSON",
                "fbimpact compare drop.h5 reference/drop.h5 --rtol 0.01 --json",
            ),
        ],
    ),
    (
        "thin",
        [
            example("keep some 40 kB as a reference", "fbimpact thin drop.h5 -o reference/drop.h5"),
            example("with 50 instants", "fbimpact thin drop.h5 -o small.h5 --rows 50"),
        ],
    ),
    (
        "collect",
        [
            example("a row for each run of a sweep", "fbimpact collect sweep -o table.csv"),
            example(
                "with a column of one's own",
                "fbimpact collect sweep -o table.csv --column 'rebound=bodies.ball.velocity[-1].z'",
            ),
        ],
    ),
    (
        "export-body",
        [
            example(
                "a reduced body, to be used again",
                "fbimpact export-body rig.toml --body ball -o ball.h5",
            ),
            example(
                "the exact shape for another program, in millimetres",
                "fbimpact export-body rig.toml --body ball --nurbs gismo --units mm -o ball.xml",
            ),
        ],
    ),
    (
        "import-body",
        [
            example(
                "matrices of CalculiX in N, mm, tonne, s",
                "fbimpact import-body --stiffness b.sti --mass b.mas --dof-map b.dof --nodes b.inp --units mm -o b.h5",
            ),
            example(
                "with a marker that joints can hold",
                "fbimpact import-body --stiffness k.mtx --mass m.mtx --nodes n.txt --units m --marker hinge=1,2,5-9 -o b.h5",
            ),
        ],
    ),
    (
        "cache",
        [
            example("where models are kept, and how many", "fbimpact cache info"),
            example("remove them", "fbimpact cache clear"),
        ],
    ),
    (
        "cache info",
        [
            example("of the user's folder", "fbimpact cache info"),
            example("of another one", "fbimpact cache info --cache-dir models"),
        ],
    ),
    (
        "cache clear",
        [
            example("the user's folder", "fbimpact cache clear"),
            example("another one", "fbimpact cache clear --cache-dir models"),
        ],
    ),
    (
        "reference",
        [
            example("every key of the scenario file", "fbimpact reference"),
            example("every dataset of the result file", "fbimpact reference results"),
        ],
    ),
    (
        "completions",
        [
            example("for bash, to be stored where it looks for them", "fbimpact completions bash"),
            example("for fish", "fbimpact completions fish"),
        ],
    ),
    (
        "man",
        [
            example("the page of a command", "fbimpact man cache info"),
            example("all pages into a folder", "fbimpact man --all man1"),
        ],
    ),
];

/// Examples of a command, by its name below the program.
pub fn of(name: &str) -> &'static [Example] {
    EXAMPLES.iter().find(|(known, _)| *known == name).map_or(&[], |(_, examples)| examples)
}
