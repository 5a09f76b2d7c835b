//! Decks as they come: parts and instances, files that include others, elements and cards that are no mesh, odd lines, bulk data of Nastran,
//! pieces that share no node, folded elements.

use crate::blocks::{block, shaken, volume};
use crate::writers::{Fields, Form, gmsh, inp, nastran};
use fe_mesh::fault::MeshError;
use fe_mesh::mesh::raw::RawMesh;
use fe_mesh::read::{Wanted, parts, read, read_part};
use fe_mesh::{ElementKind, Mesh};

/// The mesh of `part` of a file that includes none.
fn part(text: &str, part: Option<&str>) -> Result<Mesh, MeshError> {
    let mut none = |_: &str| Err("there is none".to_owned());
    read_part(text.as_bytes(), 1.0, &mut Wanted { part, include: &mut none })
}

fn refused(text: &str, name: Option<&str>) -> String {
    part(text, name).expect_err("refused").to_string()
}

/// A box of two elements of the lengths `size`.
fn sized(kind: ElementKind, size: [f64; 3]) -> RawMesh {
    block(kind, [2, 1, 1], |x| [0, 1, 2].map(|d| size[d] * x[d]))
}

/// Ends of the box about the nodes along `d`.
fn ends(mesh: &Mesh, d: usize) -> [f64; 2] {
    let along = mesh.nodes().iter().map(|x| x[d]);
    [along.clone().fold(f64::INFINITY, f64::min), along.fold(f64::NEG_INFINITY, f64::max)]
}

/// Coordinates of the nodes are written with all digits.
fn near(found: [f64; 2], wanted: [f64; 2]) -> bool {
    found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-14)
}

/// Three parts, of which `Plate` has shells alone, and instances of them.
fn assembly() -> String {
    let (cube, rod) =
        (inp(&sized(ElementKind::Hex8, [1.0; 3])), inp(&sized(ElementKind::Tet10, [3.0, 1.0, 1.0])));
    format!(
        "*Heading\n*Part, name=Cube\n{cube}*Elset, elset=Ends\n1, 2\n*Surface, name=Under\nEnds, S1\n*End Part\n*Part, name=Plate\n*Node\n1,0,0,0\n2,1,0,0\n\
         3,1,1,0\n4,0,1,0\n*Element, type=R3D4\n1,1,2,3,4\n*End Part\n*Part, name=\"Rod, long\"\n{rod}*End Part\n*Assembly, name=All\n*Instance, name=Cube-1, \
         part=Cube\n*End Instance\n*Instance, name=Plate-1, part=Plate\n*End Instance\n*Instance, name=Cube-2, part=Cube\n1., 0., 0.\n1., 0., 0., 1., 0., 1., 90.\n\
         *End Instance\n*Instance, name=Rod-1, part=\"Rod, long\"\n0., 0., 5.\n*End Instance\n*Node\n1, 9., 9., 9.\n*Element, type=SpringA, elset=Springs\n1, 1, 1\n\
         *Nset, nset=Hold, instance=Cube-1\n1, 2, 3, 4\n*Nset, nset=Hold, instance=Cube-2, generate\n1, 100\n*Nset, nset=Point\n1,\n*Elset, elset=Ends, \
         instance=Cube-2\n2\n*Elset, elset=Inner, instance=Rod-1\nall\n*Surface, name=Top\nCube-2.Ends, S2\nCube-1.Ends, S2\n*Tie, name=T\nTop, Cube-1.Under\n\
         *End Assembly\n*Material, name=M\n*Step\n"
    )
}

#[test]
fn the_body_is_chosen_among_parts_and_moved_as_its_instance() {
    let text = assembly();
    let cube = part(&text, Some("cube-2")).expect("a mesh");
    assert_eq!((cube.elements().len(), cube.nodes().len()), (2, 12));
    // Along x by one, then about the parallel to z through (1, 0, 0): what was x - 1 is y, what was y is 1 - x.
    assert!(
        near(ends(&cube, 0), [0.0, 1.0])
            && near(ends(&cube, 1), [0.0, 1.0])
            && near(ends(&cube, 2), [0.0, 1.0])
    );
    let first = |mesh: &Mesh| mesh.nodes()[mesh.node_labels().iter().position(|l| *l == 1).expect("node 1")];
    let corner = first(&cube);
    assert!((0..3).all(|d| (corner[d] - [1.0, 0.0, 0.0][d]).abs() < 1e-15), "{corner:?}");
    // Sets of the assembly are those of this instance; one of the part that has the name of another stands with the instance before it.
    assert_eq!(cube.volume_group("Ends"), Ok(&[1][..]));
    assert_eq!(cube.volume_group("Cube-2.Ends"), Ok(&[0, 1][..]));
    assert_eq!(cube.face_group("Top").expect("a face").len(), 2);
    assert_eq!(cube.face_group("Under").expect("a face"), cube.face_group("z-").expect("a face"));
    assert_eq!(cube.face_group("Hold").expect("a face").len(), cube.surface().len());
    let notes = cube.notes().join("\n");
    assert!(notes.contains("*TIE \"T\" (line") && notes.contains("*NODE of the assembly"), "{notes}");
    // The only instance of a part can be called by the part; sets are sought in an instance named before them.
    let rod = part(&text, Some("Rod, long")).expect("a mesh");
    assert!(near(ends(&rod, 2), [5.0, 6.0]) && (volume(&rod) - 3.0).abs() < 1e-14);
    assert_eq!(rod.volume_group("Inner").expect("a group").len(), rod.elements().len());
    let one = part(&text, Some("Cube-1.Ends")).expect("a mesh");
    assert!(near(ends(&one, 0), [0.0, 1.0]));
    for (name, words) in [
        (None, &["several parts", "\"Cube-1\", \"Cube-2\", \"Rod-1\"", "part = "][..]),
        (Some("Cube"), &["no part \"Cube\"", "\"Cube-1\""]),
        (Some("Cube-1.None"), &["no group \"None\"", "\"Ends\""]),
    ] {
        let text = refused(&text, name);
        assert!(words.iter().all(|w| text.contains(w)) && !text.contains("Plate"), "{text}");
    }
    // Where one part has solids nothing is needed, whatever else there is; nor are instances.
    let alone = text
        .replace("name=Cube-2, part=Cube", "name=Cube-2, part=Plate")
        .replace("part=\"Rod, long\"", "part=Plate");
    assert_eq!(part(&alone, None).expect("a mesh").elements().len(), 2);
    let library = &text[..text.find("*Assembly").expect("an assembly")];
    assert_eq!(part(library, Some("rod, LONG")).expect("a mesh").elements().len(), 12);
    let unknown = refused(&text.replace("part=Cube\n1.", "part=None\n1."), Some("Cube-2"));
    assert!(unknown.contains("\"None\"") && unknown.contains("line "), "{unknown}");
}

#[test]
fn files_include_others() {
    let whole = inp(&sized(ElementKind::Hex20, [1.0; 3]));
    let at = whole.find("*ELEMENT").expect("elements");
    let data =
        whole[..at].find('\n').and_then(|i| whole[i + 1..at].find('\n').map(|j| i + j + 2)).expect("lines");
    let outer = format!(
        "{}*INCLUDE, INPUT=nodes.txt\n{}*ELSET, ELSET=E, INPUT=set.txt\n*INCLUDE, INPUT=\"rest of it.inp\"\n",
        &whole[..data],
        &whole[at..]
    );
    let mut asked = Vec::new();
    let mut include = |name: &str| {
        asked.push(name.to_owned());
        match name {
            "nodes.txt" => Ok(whole.as_bytes()[data..at].to_vec()),
            "set.txt" => Ok(b"2\n".to_vec()),
            "rest of it.inp" => Ok(b"*SURFACE, NAME=S\nE, S1\n".to_vec()),
            _ => Err("no such file".to_owned()),
        }
    };
    let mesh =
        read_part(outer.as_bytes(), 1.0, &mut Wanted { part: None, include: &mut include }).expect("a mesh");
    assert_eq!(mesh.volume_group("E"), Ok(&[1][..]));
    assert_eq!((mesh.face_group("S").expect("a face").len(), mesh.nodes().len()), (1, 32));
    assert_eq!(asked, ["nodes.txt", "set.txt", "rest of it.inp"]);
    // Faults have both places; a file that includes itself ends.
    let of = |text: &str| {
        let mut include = |name: &str| match name {
            "a" => Ok(b"*NODE\n1, 0, zero\n".to_vec()),
            "b" => Ok(b"** itself\n*INCLUDE, INPUT=b\n".to_vec()),
            _ => Err("no such file".to_owned()),
        };
        let wanted = &mut Wanted { part: None, include: &mut include };
        read_part(text.as_bytes(), 1.0, wanted).expect_err("refused").to_string()
    };
    for (text, words) in [
        ("*HEADING\n*INCLUDE, INPUT=a\n", &["line 2: in \"a\", line 2:", "a coordinate expected"][..]),
        ("*INCLUDE, INPUT=b\n", &["line 1: in \"b\", line 2:", "16 files within each other"]),
        ("*NODE, INPUT=c\n", &["line 1: \"c\" cannot be included: no such file"]),
        ("*INCLUDE\n", &["line 1", "INPUT="]),
    ] {
        let text = of(text);
        assert!(words.iter().all(|w| text.contains(w)), "{words:?}: {text}");
    }
}

#[test]
fn what_is_no_solid_is_left_out_with_one_note() {
    let text = inp(&sized(ElementKind::Hex8, [1.0; 3]))
        + "*Element, type=S4, elset=Shells\n100, 1, 2, 3, 4\n*Element, type=SPRINGA, elset=Springs\n101, 1, 2\n*Element, type=Mass, elset=Masses\n102, 1\n\
           *Element, type=GAPUNI, elset=Gaps\n103, 1, 2\n*Element, type=B32R, elset=Beams\n104, 1, 2, 3\n*Element, type=DCOUP3D, elset=Coupled\n105, 1\n\
           *Spring, elset=Springs\n\n10.\n*Mass, elset=Masses\n1.\n*Elset, elset=Every\nShells, Springs, 1, 102, Beams, all\n*Surface, name=Skin\nShells, SPOS\n\
           *Surface, name=Turned, type=Cylinder\nstart, 0, 0\n*Nset, nset=Held, elset=Shells\n*Distributing coupling, elset=Coupled\n2, 1\n";
    let mesh = part(&text, None).expect("a mesh");
    assert_eq!((mesh.elements().len(), mesh.volume_group("Every")), (2, Ok(&[0, 1][..])));
    assert!(mesh.volume_group("Springs").is_err() && mesh.volume_group("Shells").is_err());
    // Shells are sides where they lie on the surface; these do not.
    assert!(mesh.faces().iter().any(|(name, _)| name == "Skin"));
    let notes: Vec<&String> = mesh.notes().iter().filter(|n| n.contains("left out")).collect();
    let [note] = notes[..] else { panic!("{notes:?}") };
    let words = [
        "SPRINGA (line",
        "MASS",
        "GAPUNI",
        "B32R",
        "DCOUP3D",
        "*SPRING",
        "*DISTRIBUTING COUPLING",
        "those of the scenario",
    ];
    assert!(words.iter().all(|w| note.contains(w)), "{note}");
    let shells = refused("*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n*ELEMENT, TYPE=S3\n1, 1, 2, 3\n", None);
    assert!(shells.contains("no solid or plane elements; C3D10"), "{shells}");
    assert!(refused("*NODE\n1,0,0,0\n*ELEMENT, TYPE=C3D7\n1, 1\n", None).contains("C3D7"));
}

#[test]
fn lines_are_read_as_calculix_reads_them() {
    let good = inp(&sized(ElementKind::Hex8, [1.0; 3]));
    let plain = part(&good, None).expect("a mesh");
    // C3D8I has eleven nodes in CalculiX; blanks, small letters, a lone asterisk, a mark of the encoding.
    let odd: String = good
        .replace("TYPE=C3D8", "type = c3d8i")
        .replace("*NODE, NSET", "* Node , nset ")
        .lines()
        .map(|line| match line.split(',').count() {
            9 => format!("  {line}, 9, 10, \r\n\n"),
            _ => format!("{line}\t\r\n*\r\n** \r\n").replace("c3d8i,\t\r\n*\r\n** \r\n", "c3d8i,\n"),
        })
        .collect();
    let mesh = part(&format!("\u{feff}> a remark\n{odd}"), None).expect("a mesh");
    assert_eq!((mesh.nodes(), mesh.volumes()), (plain.nodes(), plain.volumes()));
    let notes = mesh.notes().join("\n");
    assert!(notes.contains("more numbers than nodes (line") && notes.contains("C3D8I"), "{notes}");
}

#[test]
fn pieces_are_chosen_by_group_or_element() {
    // Two boxes side by side, with numbers of their own; the second has a group.
    let (first, mut second) = (sized(ElementKind::Hex8, [1.0; 3]), sized(ElementKind::Hex8, [2.0, 1.0, 1.0]));
    let n = first.nodes.len() as u64;
    second.nodes.iter_mut().for_each(|x| x[0] += 5.0);
    second.node_labels.iter_mut().for_each(|l| *l += n);
    let lines = |raw: &RawMesh, from: u64| -> (String, String) {
        let node = |(l, x): (&u64, &[f64; 3])| format!("{l}, {:e}, {:e}, {:e}\n", x[0], x[1], x[2]);
        let element = |e: fe_mesh::mesh::raw::Element<'_>| {
            let nodes: Vec<String> =
                e.nodes.iter().map(|&n| raw.node_labels[n as usize].to_string()).collect();
            format!("{}, {}\n", e.label + from, nodes.join(", "))
        };
        (
            raw.node_labels.iter().zip(&raw.nodes).map(node).collect(),
            raw.elements.iter().map(element).collect(),
        )
    };
    let ((a, b), (c, d)) = (lines(&first, 0), lines(&second, 20));
    let text = format!(
        "*NODE\n{a}{c}*ELEMENT, TYPE=C3D8, ELSET=mixed\n{b}*ELEMENT, TYPE=C3D8, ELSET=Teil ä/2\n{d}*ELSET, ELSET=mixed\n21\n*NSET, NSET=N\n1, 2, 13, 14\n\
         *SURFACE, NAME=S\nTeil ä/2, S1\n1, S1\n"
    );
    let fault = refused(&text, None);
    assert!(
        ["2 parts", "\"element 1\", \"Teil ä/2\"", "part = "].iter().all(|w| fault.contains(w)),
        "{fault}"
    );
    let mesh = part(&text, Some("Teil ä/2")).expect("a mesh");
    assert!(near(ends(&mesh, 0), [5.0, 7.0]) && (volume(&mesh) - 2.0).abs() < 1e-14);
    assert_eq!(mesh.face_group("S").expect("a face").len(), 2);
    assert_eq!(mesh.volume_group("mixed"), Ok(&[0][..]));
    assert!(mesh.notes().iter().all(|n| !n.contains("nodes belong to no")), "{:?}", mesh.notes());
    assert!(near(ends(&part(&text, Some("element 2")).expect("a mesh"), 0), [0.0, 1.0]));
    assert!(refused(&text, Some("element 3")).contains("no group \"element 3\""));
    // A group that is less than a piece is cut out of it.
    let cut = part(&format!("{text}*ELSET, ELSET=half\n1\n"), Some("HALF")).expect("a mesh");
    assert!((volume(&cut) - 0.5).abs() < 1e-15);
    assert!(
        cut.notes().iter().any(|n| n.contains("1 elements beside part \"HALF\" share nodes")),
        "{:?}",
        cut.notes()
    );
}

#[test]
fn bulk_data_of_nastran() {
    for kind in ElementKind::SOLID {
        if matches!(kind, ElementKind::Hex27 | ElementKind::Wedge18 | ElementKind::Pyramid14) {
            continue;
        }
        // Coordinates of few digits, which short fields hold.
        let raw = block(kind, [2, 1, 1], |x| x.map(|x| 16.0 * x));
        let expected = Mesh::new(raw.clone(), 1e-3).expect("a mesh");
        for fields in [Fields::Short, Fields::Large, Fields::Free] {
            let mesh = read(nastran(&raw, fields).as_bytes(), 1e-3)
                .unwrap_or_else(|e| panic!("{kind:?} {fields:?}: {e}"));
            assert_eq!(
                (mesh.nodes(), mesh.elements()),
                (expected.nodes(), expected.elements()),
                "{kind:?} {fields:?}"
            );
            assert_eq!(mesh.volume_group("PSOLID 7"), mesh.volume_group("MAT1 9"));
            for (i, (name, faces)) in expected.faces().iter().enumerate() {
                assert_eq!(
                    mesh.face_group(&format!("PSHELL {}", i + 1)),
                    Ok(&faces[..]),
                    "{kind:?} {fields:?} {name}"
                );
            }
            // Corners may turn either way.
            let mut other = raw.clone();
            other.nodes.iter_mut().for_each(|x| x[0] = 16.0 - x[0]);
            let other =
                read(nastran(&other, fields).as_bytes(), 1e-3).unwrap_or_else(|e| panic!("{kind:?}: {e}"));
            assert!((volume(&other) / volume(&mesh) - 1.0).abs() < 1e-13, "{kind:?}");
            assert!(mesh.notes().iter().any(|n| n.contains("CBAR (line")), "{:?}", mesh.notes());
        }
    }
}

#[test]
fn coordinates_and_faults_of_nastran() {
    let deck = |grid: &str, more: &str| {
        format!("GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\n{grid}\n{more}\nCTETRA,5,1,1,2,3,4\n")
    };
    // A cylinder about y: radius 2, 90 degrees from the plane of y and z, height 3.
    let turned =
        part(&deck("GRID,4,6,2.,90.,3.", "CORD2C,6,0,0.,0.,0.,0.,1.,0.,\n,0.,0.,1."), None).expect("a mesh");
    let place = turned.nodes()[3];
    assert!((0..3).all(|d| (place[d] - [2.0, 3.0, 0.0][d]).abs() < 1e-15), "{place:?}");
    // A sphere within it: radius 2, 90 degrees from its z, 90 from its x, which are those of the cylinder.
    let within = "CORD2S,7,6,0.,0.,1.,0.,0.,2.\n,1.,0.,1.\nCORD2C,6,0,0.,0.,0.,0.,1.,0.,\n,0.,0.,1.";
    let turned = part(&deck("GRID,4,7,2.,90.,90.", within), None).expect("a mesh");
    let place = turned.nodes()[3];
    assert!((0..3).all(|d| (place[d] - [2.0, 1.0, 0.0][d]).abs() < 1e-15), "{place:?}");
    for (grid, more, words) in [
        ("GRID,4,5,0.,0.,1.", "CORD2R,5,5,0.,0.,0.,0.,1.,0.\n,1.,2.,0.", &["line 5", "within itself"][..]),
        ("GRID,4,8,0.,0.,1.", "", &["line 4", "coordinate system 8", "CORD2R"]),
        ("GRID,4,,0.,x,1.", "", &["line 4", "field 5 of GRID", "\"x\""]),
        ("", "", &["line 6", "element 5 names node 4"]),
        ("GRID,4,,0.,0.,1.\nGRID,4,,0.,0.,1.", "", &["grid point 4 stands in the file twice"]),
        (
            "GRID,4,,0.,0.,1.",
            "CTETRA,6,1,1,2,3,4,1",
            &["line 5", "CTETRA with 4 or 10 grid points", "5 grid points"],
        ),
        ("GRID,4,6,0.,0.,1.", "CORD2R,6,0,0.,0.,0.,0.,1.,0.\n+,0.,2.,0.", &["line 5", "on a line"]),
        ("GRID,4,,0.,0.,1.", "INCLUDE 'a.bdf'", &["line 5", "a.bdf", "there is none"]),
        ("GRID,4,,0.,0.,1.", "INCLUDE", &["line 5", "INCLUDE with the name of a file"]),
    ] {
        let text = refused(&deck(grid, more), None);
        assert!(words.iter().all(|w| text.contains(w)), "{words:?}: {text}");
    }
}

/// Bulk data in several files are those in one; faults and notes name the file and its line.
#[test]
fn bulk_data_include_files() {
    let raw = block(ElementKind::Tet10, [2, 1, 1], |x| x.map(|x| 16.0 * x));
    let whole = nastran(&raw, Fields::Free);
    let bulk =
        whole.split_once("BEGIN BULK\n").expect("bulk data").1.split_once("ENDDATA").expect("its end").0;
    let (elements, points) = bulk.split_at(bulk.find("GRID").expect("grid points"));
    let main = "INCLUDE 'case control'\nBEGIN BULK\n$ the model\ninclude 'all.bdf' $ here\nENDDATA\nINCLUDE 'nothing'\n";
    let all = "INCLUDE 'elements.bdf'\nPBUSH,1\nINCLUDE=\"points.bdf\"\n";
    let found = |points: &str| {
        let mut include = |name: &str| match name {
            "all.bdf" => Ok(all.as_bytes().to_vec()),
            "elements.bdf" => Ok(elements.as_bytes().to_vec()),
            "points.bdf" => Ok(points.as_bytes().to_vec()),
            _ => Err("there is none".to_owned()),
        };
        read_part(main.as_bytes(), 1.0, &mut Wanted { part: None, include: &mut include })
    };
    let (mesh, expected) = (found(points).expect("a mesh"), read(whole.as_bytes(), 1.0).expect("a mesh"));
    assert_eq!((mesh.nodes(), mesh.elements()), (expected.nodes(), expected.elements()));
    let notes = mesh.notes().join("\n");
    assert!(notes.contains("PBUSH (line 2 of all.bdf)"), "{notes}");
    let lost = found("GRID,1,,0.,0.,0.\nGRID,2,,x\n").expect_err("refused").to_string();
    let words = ["line 4: in \"all.bdf\", line 3: in \"points.bdf\", line 2:", "field 4 of GRID"];
    assert!(words.iter().all(|w| lost.contains(w)), "{lost}");
    let itself = |name: &str| Ok(format!("INCLUDE '{name}'\n").into_bytes());
    let mut include = itself;
    let mut wanted = Wanted { part: None, include: &mut include };
    let round =
        read_part(b"GRID,1,,0.,0.,0.\nINCLUDE 'a'\n", 1.0, &mut wanted).expect_err("refused").to_string();
    assert!(
        round.starts_with("line 2: in \"a\", line 1:") && round.contains("16 files within each other"),
        "{round}"
    );
}

#[test]
fn other_formats_are_told_with_the_command_that_converts() {
    for (bytes, words) in [
        (&b"# vtk DataFile Version 5.1\n"[..], &["legacy VTK", "meshio.read"][..]),
        (b"<?xml version=\"1.0\"?>\n<VTKFile>", &["XML", "meshio.read"]),
        (b"\x89HDF\r\n\x1a\n", &["MED", "gmsh PART -save -format msh41"]),
        (b"    -1\n  2411\n", &["UNV", "gmsh PART -save -format msh41"]),
        (b"ISO-10303-21;\n", &["STEP", "gmsh PART -3 -order 2"]),
        (b"solid cube\n", &["STL"]),
        (b"\x00\x01\x02", &["not a mesh that is known"]),
        (b"$MeshFormat\n1.9 0 8\n", &["MSH version 1.9", "-format msh41"]),
    ] {
        let text = read(bytes, 1.0).expect_err("refused").to_string();
        assert!(words.iter().all(|w| text.contains(w)), "{words:?}: {text}");
    }
}

#[test]
fn folded_elements_become_straight() {
    for (kind, slightly) in [
        (ElementKind::Tet10, 1.05),
        (ElementKind::Hex20, 1.05),
        (ElementKind::Hex27, 0.45),
        (ElementKind::Wedge15, 0.9),
        (ElementKind::Pyramid13, 0.63),
    ] {
        let good = block(kind, [2, 2, 2], |x| shaken(x, 0.02));
        let plain = Mesh::new(good.clone(), 1e-3).expect("a mesh");
        assert!(plain.notes().iter().all(|n| !n.contains("folded")));
        // Folded near a corner alone, where no matrix has a point, and altogether.
        for far in [slightly, 2.5] {
            // The middle of an edge inside is thrown through the opposite side: the corners stay as they are.
            let mut bent = good.clone();
            let is_inside = |n: &u32| good.nodes[*n as usize].iter().all(|x| (0.05..0.95).contains(x));
            let inside = |e: usize| {
                Some(e).zip(good.elements.get(e).nodes[kind.n_corners()..].iter().position(is_inside))
            };
            let (e, edge) = (0..good.elements.len()).find_map(inside).expect("an edge inside");
            let element = bent.elements.get(e);
            let [a, b] = kind.edges()[edge];
            let middle = element.nodes[kind.n_corners() + edge] as usize;
            let [from, to] = [a, b].map(|c| good.nodes[element.nodes[c as usize] as usize]);
            let away = element
                .nodes
                .iter()
                .map(|&n| good.nodes[n as usize])
                .fold([0.0; 3], |s, x| [s[0] + x[0], s[1] + x[1], s[2] + x[2]]);
            let centre = away.map(|c| c / kind.n_nodes() as f64);
            bent.nodes[middle] =
                [0, 1, 2].map(|d| 0.5 * (from[d] + to[d]) + far * (centre[d] - 0.5 * (from[d] + to[d])));
            let mesh = Mesh::new(bent, 1e-3).unwrap_or_else(|e| panic!("{kind:?}: {e}"));
            let note =
                mesh.notes().iter().find(|n| n.contains("folded")).unwrap_or_else(|| panic!("{kind:?}"));
            assert!(note.contains("straighter now") && note.contains("changes the volume"), "{note}");
            // Curves inside change no volume.
            assert!((volume(&mesh) / 1e-9 - 1.0).abs() < 1e-12, "{kind:?}: {}", volume(&mesh) / 1e-9 - 1.0);
        }
    }
    // Corners in a wrong order are another fault.
    let mut raw = block(ElementKind::Tet10, [1, 1, 1], |x| x);
    raw.nodes.iter_mut().for_each(|x| x[0] = -x[0]);
    let text = Mesh::new(raw, 1.0).expect_err("refused").to_string();
    assert!(text.contains("reorient"), "{text}");
}

#[test]
fn groups_of_one_name_are_one_place() {
    let raw = sized(ElementKind::Hex8, [1.0; 3]);
    let text = String::from_utf8(gmsh(&raw, Form::Text41)).expect("text").replace("\"x+\"", "\"x-    \"");
    assert_eq!(read(text.as_bytes(), 1.0).expect("a mesh").face_group("x-").expect("a face").len(), 2);
}

#[test]
fn thin_walls_of_tetrahedra_are_told() {
    for (thickness, is_thin) in [(0.2, false), (0.02, true)] {
        let told = |kind| {
            let raw = block(kind, [3, 3, 1], |[x, y, z]| [x, y, thickness * z]);
            let mesh = Mesh::new(raw, 1.0).expect("a mesh");
            mesh.notes().iter().any(|note| note.contains("times as long as high"))
        };
        assert_eq!([ElementKind::Tet10, ElementKind::Hex20].map(told), [is_thin, false], "{thickness}");
    }
}

#[test]
fn parts_are_listed_with_what_ties_them() {
    let mut none = |_: &str| Err("there is none".to_owned());
    let mut named = |text: &str| parts(text.as_bytes(), &mut none).expect("parts");
    let deck = assembly();
    assert_eq!(named(&deck), ["Cube-1", "Cube-2", "Rod-1"]);
    let cube = inp(&sized(ElementKind::Hex8, [1.0; 3]));
    assert!(named(&cube).is_empty(), "one piece");
    // A flat file of two pieces, tied in all ways that there are.
    let mut other = sized(ElementKind::Hex8, [1.0; 3]);
    other.nodes.iter_mut().for_each(|x| x[0] += 1.0);
    other.node_labels.iter_mut().for_each(|label| *label += 100);
    let first_of_other =
        (0..other.elements.len()).map(|e| other.elements.get(e).label).max().expect("elements");
    let second = inp(&other)
        .replace("everything", "others")
        .replace("ELSET=all", "ELSET=more")
        .replace("nset=", "nset=b");
    let numbered = second.lines().map(|line| match line.split_once(", ") {
        // Numbers of elements differ from those of the first piece; lines of nodes have points.
        Some((label, rest)) if !line.contains('e') && !line.starts_with('*') => {
            format!("{}, {rest}\n", label.parse::<u64>().expect("a number") + first_of_other)
        }
        _ => format!("{line}\n"),
    });
    let second: String = numbered.collect();
    let ties = "*TIE, NAME=Glue\nx+, bx-\n*TIE, CYCLIC SYMMETRY\nx+, x-\n*Coupling, ref node = 7, surface=x-, constraint name=Hold\n*Distributing\n\
                *RIGID BODY, NSET=bx+, REF NODE=7\n*RIGID BODY, ELSET=all, REF NODE=8\n*MPC\nBEAM, 3, 4\nPIN, 1, 2\n*KINEMATIC COUPLING, REF NODE=9\nx+, 1, 3\n*STEP\n";
    let flat = format!("{cube}{second}{ties}");
    let names = named(&flat);
    assert_eq!(names, ["all", "more"]);
    let meshes = names.iter().map(|name| part(&flat, Some(name)).expect("a part")).collect::<Vec<_>>();
    let told: Vec<String> = meshes[0].ties().iter().map(|tie| format!("{} {}", tie.is_rigid, tie)).collect();
    let line = |card: &str| 1 + flat.lines().position(|line| line.starts_with(card)).expect("a card");
    let wanted = [
        format!("false *TIE \"Glue\" (line {}): \"x+\" to \"bx-\"", line("*TIE")),
        format!("false *COUPLING \"Hold\" (line {}): \"x-\" to node 7", line("*Coupling")),
        format!("true *RIGID BODY (line {}): \"bx+\" to node 7", line("*RIGID")),
        format!("true *MPC (line {}): node 3 to node 4", line("*MPC")),
        format!("true *KINEMATIC COUPLING (line {}): node 9 to \"x+\"", line("*KINEMATIC")),
    ];
    assert_eq!(told, wanted);
    let glue = &meshes[0].ties()[0].joined;
    assert_eq!(meshes[0].joined_face("all", &glue[0]), Some("x+"));
    assert_eq!(
        [meshes[0].joined_face("all", &glue[1]), meshes[1].joined_face("more", &glue[1])],
        [None, Some("bx-")]
    );
    let [cube, rod] = ["Cube-1", "Rod-1"].map(|name| part(&deck, Some(name)).expect("a part"));
    let joined = &cube.ties()[0].joined;
    assert_eq!(cube.joined_face("Cube-1", &joined[1]), Some("Under"));
    assert_eq!(rod.joined_face("Rod-1", &joined[1]), None);
    assert!(cube.notes().iter().any(|note| note.contains("what the file ties")), "{:?}", cube.notes());
    assert!(
        meshes[0]
            .notes()
            .iter()
            .any(|note| note.contains("not read: *TIE (line") && note.contains("), *RIGID BODY (line")),
        "{:?}",
        meshes[0].notes()
    );
}
