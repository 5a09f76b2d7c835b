//! Columns of numbers in a text file, as programs and instruments write them: between commas, semicolons, tabs or blanks, with points or
//! commas in the numbers, under a line of names and one of units. What could be read in two ways is refused.

use crate::scenario::keys::column_units::{self, Found};

/// Keys that say where numbers are.
pub(super) const KEYS: [&str; 3] = ["file", "time_column", "value_column"];

/// What is wrong, and the key that it belongs to.
pub(super) struct Fault {
    pub(super) key: &'static str,
    /// Follows the name of the file.
    pub(super) message: String,
}

impl Fault {
    pub(super) fn of_file(message: impl std::fmt::Display) -> Self {
        Self { key: "file", message: message.to_string() }
    }
}

/// A column of numbers in the unit of keys.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Column {
    pub(super) numbers: Vec<f64>,
    /// The unit of keys, if the name of the column says one.
    pub(super) unit: Option<&'static str>,
}

/// What stands above the numbers, and how the lines are to be read.
struct Table<'a> {
    separator: Option<char>,
    /// Lines that are neither empty nor remarks, with their numbers from 1.
    names: Option<(usize, Vec<&'a str>)>,
    units: Option<(usize, Vec<&'a str>)>,
    rows: Vec<(usize, Vec<&'a str>)>,
}

/// Cells of a line, between blanks without a separator: what stands in quotes is one, blanks about cells do not count.
fn cells(line: &str, separator: Option<char>) -> Vec<&str> {
    let mut is_quoted = false;
    let split = line.split(|c: char| {
        is_quoted ^= c == '"';
        !is_quoted && separator.map_or(c.is_whitespace(), |separator| c == separator)
    });
    let mut cells: Vec<&str> = split.map(|cell| cell.trim().trim_matches('"').trim()).collect();
    if separator.is_none() {
        cells.retain(|cell| !cell.is_empty());
    }
    // Some programs end every line with the separator.
    while cells.len() > 1 && cells.last() == Some(&"") {
        cells.pop();
    }
    cells
}

/// A number with a comma in place of the point.
fn with_comma(cell: &str) -> Option<f64> {
    let (whole, part) = cell.split_once(',')?;
    let is_whole = whole.trim_start_matches(['+', '-']).bytes().all(|b| b.is_ascii_digit());
    let is_one = is_whole && part.starts_with(|c: char| c.is_ascii_digit()) && !part.contains(['.', ',']);
    is_one.then(|| cell.replace(',', ".").parse().ok()).flatten()
}

fn is_number(cell: &str) -> bool {
    cell.parse::<f64>().is_ok() || with_comma(cell).is_some()
}

/// Whether a line holds numbers: all cells are some, or the first one is and another one begins like one.
fn is_row(cells: &[&str]) -> bool {
    let begins =
        |cell: &&str| cell.trim_start_matches(['+', '-', '.']).starts_with(|c: char| c.is_ascii_digit());
    let is_first = cells.first().is_some_and(|cell| is_number(cell));
    cells.iter().all(|cell| is_number(cell)) || is_first && cells[1..].iter().any(begins)
}

/// What separates the cells of a line of numbers: what makes numbers of all of it.
fn separator(line: &str) -> Option<char> {
    let is_blank = !line.contains([';', '\t']) && cells(line, None).iter().all(|cell| is_number(cell));
    [';', '\t', ',']
        .into_iter()
        .find(|c| line.contains(*c))
        .filter(|_| !(is_blank && line.contains(char::is_whitespace)))
}

impl<'a> Table<'a> {
    fn of(text: &'a str) -> Result<Self, Fault> {
        let text = text.trim_start_matches('\u{feff}');
        let lines = text.lines().enumerate().map(|(n, line)| (n + 1, line.trim()));
        let lines: Vec<(usize, &str)> =
            lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#')).collect();
        let Some(first) = lines.iter().position(|(_, line)| is_row(&cells(line, separator(line)))) else {
            return Err(Fault::of_file(match lines.first() {
                None => " has no line of numbers".to_owned(),
                Some((n, line)) => {
                    format!(":{n}: no line of numbers follows {line:?}; it needs two columns of them")
                }
            }));
        };
        let separator = separator(lines[first].1);
        let split = |(n, line): &(usize, &'a str)| (*n, cells(line, separator));
        let rows: Vec<_> = lines[first..].iter().map(split).collect();
        let (names, units) = match lines[..first].iter().map(split).collect::<Vec<_>>().as_slice() {
            [] => (None, None),
            [names] => (Some(names.clone()), None),
            [names, units] if names.1.len() > 1 => (Some(names.clone()), Some(units.clone())),
            [(n, _), ..] => {
                let line = lines.iter().find(|line| line.0 == *n).map_or("", |line| line.1);
                return Err(Fault::of_file(format_args!(
                    ":{n}: {line:?} stands above the names of the columns: begin lines of other things with #; one line of names and one of units may stand above the numbers"
                )));
            }
        };
        let table = Self { separator, names, units, rows };
        table.check_widths()?;
        table.check_points()?;
        Ok(table)
    }

    /// Commas between numbers that have commas make more cells than there are names, blanks in names fewer.
    fn check_widths(&self) -> Result<(), Fault> {
        let Some((_, names)) = &self.names else { return Ok(()) };
        let is_other = |n: usize| n > names.len() || self.separator.is_none() && n < names.len();
        let Some((n, row)) = self.rows.iter().find(|(_, row)| is_other(row.len())) else { return Ok(()) };
        let remedy = match self.separator {
            Some(',') => {
                "commas within numbers and between them cannot be told apart, put semicolons between numbers or points into them"
            }
            _ => "put names with blanks in quotes, or tabs or semicolons between cells",
        };
        let (cells, names) = (row.len(), names.len());
        Err(Fault::of_file(format_args!(":{n}: the line has {cells} cells, the names are {names}: {remedy}")))
    }

    /// 1,234 is a thousand and more where other numbers have points.
    fn check_points(&self) -> Result<(), Fault> {
        let all = || self.rows.iter().flat_map(|(n, row)| row.iter().map(move |cell| (n, cell)));
        let with_comma = all().find(|(_, cell)| with_comma(cell).is_some());
        let with_point = all().find(|(_, cell)| cell.contains('.') && cell.parse::<f64>().is_ok());
        match (with_comma, with_point) {
            (Some((n, comma)), Some((_, point))) => Err(Fault::of_file(format_args!(
                ":{n}: {comma:?} has a comma where {point:?} has a point, write all numbers with points"
            ))),
            _ => Ok(()),
        }
    }

    /// The place of a column that is called for by its name or its number from 1, the `k`-th one of all if it is not.
    fn place(&self, wanted: Option<&String>, k: usize) -> Result<usize, Fault> {
        let Some(wanted) = wanted else { return Ok(k) };
        let (names, width) = match &self.names {
            Some((_, names)) => (names.as_slice(), names.len()),
            None => (&[][..], self.rows[0].1.len()),
        };
        let numbered = wanted.parse::<usize>().ok().filter(|n| (1..=width).contains(n)).map(|n| n - 1);
        names.iter().position(|name| name == wanted).or(numbered).ok_or_else(|| {
            let known = if names.is_empty() { format!("numbered 1 to {width}") } else { names.join(", ") };
            Fault {
                key: KEYS[k + 1],
                message: format!(" has no column \"{wanted}\", its columns are {known}"),
            }
        })
    }

    /// The unit of the column at `place`, from its name or the line below the names.
    fn unit(&self, place: usize, quantity: &str) -> Result<Option<Found>, Fault> {
        let cell =
            |line: &Option<(usize, Vec<&'a str>)>| Some((line.as_ref()?.0, *line.as_ref()?.1.get(place)?));
        let (name, below) = (cell(&self.names), cell(&self.units));
        let told = |n: usize, text: &str, message: String| {
            Fault::of_file(format_args!(":{n}, column \"{text}\": {message}"))
        };
        let of_name = match name {
            Some((n, text)) => column_units::of_name(text, quantity).map_err(|m| told(n, text, m))?,
            None => None,
        };
        let of_cell = match below {
            Some((n, text)) => column_units::of_cell(text, quantity)
                .map_err(|m| told(n, text, format!("{m}; a line between names and numbers holds units")))?,
            None => None,
        };
        match (of_name, of_cell, below) {
            (Some(a), Some(b), Some((n, text))) if a != b => {
                Err(told(n, text, format!("its name has another unit, {:?}", name.unwrap_or_default().1)))
            }
            _ => Ok(of_cell.or(of_name)),
        }
    }
}

/// The number in a cell of line `n`.
fn number(n: usize, cell: &str) -> Result<f64, Fault> {
    let number = cell.parse().ok().or_else(|| with_comma(cell));
    number.filter(|x: &f64| x.is_finite()).ok_or_else(|| {
        Fault::of_file(format_args!(
            ":{n}: {cell:?} is no number such as 0.5 or 1e-3; begin lines that hold none with #"
        ))
    })
}

/// Times and values of the columns `wanted`, by their names in the first line or by their numbers
/// from 1; the first and the second one unless said otherwise. Numbers are in the units of keys
/// `quantities`, or in those that the names, or the line below them, have.
pub(super) fn columns(
    text: &str,
    wanted: &[Option<String>; 2],
    quantities: [&str; 2],
) -> Result<[Column; 2], Fault> {
    let table = Table::of(text)?;
    let places = [table.place(wanted[0].as_ref(), 0)?, table.place(wanted[1].as_ref(), 1)?];
    let mut found: [Column; 2] = Default::default();
    let mut factors = [1.0; 2];
    for (k, &place) in places.iter().enumerate() {
        if let Some((unit, factor)) = table.unit(place, quantities[k])? {
            (found[k].unit, factors[k]) = (Some(unit), factor);
        }
    }
    for (n, row) in &table.rows {
        for ((column, factor), &place) in found.iter_mut().zip(factors).zip(&places) {
            let cell = row.get(place).ok_or_else(|| {
                Fault::of_file(format_args!(":{n}: {} columns, column {} is wanted", row.len(), place + 1))
            })?;
            column.numbers.push(number(*n, cell)? * factor);
        }
        if let [.., before, now] = found[0].numbers[..]
            && now <= before
        {
            return Err(Fault::of_file(format_args!(
                ":{n}: times must rise, {before:?} is followed by {now:?}"
            )));
        }
    }
    if found[0].numbers.len() < 2 {
        return Err(Fault::of_file(" has fewer than two lines of numbers"));
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str, wanted: [Option<&str>; 2]) -> Result<[Vec<f64>; 2], String> {
        columns(text, &wanted.map(|name| name.map(str::to_owned)), ["s", "N"])
            .map(|columns| columns.map(|column| column.numbers))
            .map_err(|fault| fault.key.to_owned() + &fault.message)
    }

    #[test]
    fn columns_are_found_by_name_number_and_order() {
        let expected = Ok([vec![0.0, 0.5], vec![1.0, -2e3]]);
        assert_eq!(read("0,1\n0.5,-2e3\n", [None, None]), expected);
        assert_eq!(read("# measured\n\nt;x;F\n0;9;1\n0.5;9;-2e3", [Some("t"), Some("F")]), expected);
        assert_eq!(read("1 0 7\n-2e3 0.5 7", [Some("2"), Some("1")]), expected);
        assert_eq!(read("t [ms],F_kN\n0,1e-3\n500,-2", [None, None]), expected);
        assert_eq!(read("\"t [s]\",\"F [N]\"\r\n0,1\r\n0.5,-2e3\r\n", [None, Some("F [N]")]), expected);
    }

    #[test]
    fn files_of_instruments_are_read() {
        let expected = Ok([vec![0.0, 0.5], vec![1.0, -2e3]]);
        for text in [
            "\u{feff}Time (msec);Force / kN\n0;0,001\n500;-2",
            "t;F\nms;kN\n0;0,001\n500;-2,0e0",
            "Time\tForce\n[ms]\t[kN]\n0\t0.001\n500\t-2",
            "0,0 1,0\n0,5 -2000,0",
            "0, 1\n0.5, -2e3",
            "\"t\",\"F, left\"\n\"0,0\",\"1,0\"\n\"0,5\",\"-2000,0\"",
            "t,F,\n0,1,\n0.5,-2000,\n",
            "# Rate: 1000\nt,F\n# more\n0,1\n\n0.5,-2e3",
            "t,F,state\n0,1,ok\n0.5,-2e3,ok",
            "ms,kN\n0,1e-3\n500,-2",
        ] {
            assert_eq!(read(text, [None, None]), expected, "{text:?}");
        }
        let lbf = read("Time (msec);Force (lbf)\n0;0\n1;10\n", [None, None]).expect("the trap");
        assert_eq!(lbf, [vec![0.0, 1e-3], vec![0.0, 10.0 * 4.448_221_615_260_5]]);
    }

    #[test]
    fn faults_tell_line_and_columns() {
        for (text, wanted, words) in [
            ("", [None, None], "file has no line of numbers"),
            ("t,F\n", [None, None], "file:1: no line of numbers follows"),
            ("t,F\n0,1\n", [None, None], "file has fewer than two"),
            ("t,F\n0,1\n1,x\n", [None, None], "file:3: \"x\" is no number"),
            ("t,F\n0,1\n1\n", [None, None], "file:3: 1 columns, column 2 is wanted"),
            ("t,F\n0,1\n0,2\n", [None, None], "file:3: times must rise, 0.0 is followed by 0.0"),
            ("t,F\n0,1\n1,inf\n", [None, None], "is no number"),
            (
                "t [ms],F [lb]\n0,1\n1,2\n",
                [None, None],
                "file:1, column \"F [lb]\": \"lb\" is no unit of this column",
            ),
            ("t,F\nms,V\n0,1\n1,2\n", [None, None], "file:2, column \"V\": \"V\" is no unit"),
            (
                "t,F [kN]\ns,N\n0,1\n1,2\n",
                [None, None],
                "file:2, column \"N\": its name has another unit, \"F [kN]\"",
            ),
            ("Date: today\nt,F\n0,1\n1,2\n", [None, None], "file:1: \"Date: today\" stands above the names"),
            ("Rate,1000\nt,F\ns,N\n0,1\n1,2\n", [None, None], "file:1: \"Rate,1000\" stands above the names"),
            ("t,F\n0,1\nend\n", [None, None], "file:3: \"end\" is no number"),
            // Commas for both, thousands, two kinds of numbers.
            (
                "t,F\n0,000,1,5\n0,001,2,5\n",
                [None, None],
                "file:2: the line has 4 cells, the names are 2: commas within numbers",
            ),
            ("t;F\n0,5;1.5\n1,5;2\n", [None, None], "file:2: \"0,5\" has a comma where \"1.5\" has a point"),
            ("t;F\n0;1.234,5\n1;2\n", [None, None], "file:2: \"1.234,5\" is no number"),
            (
                "Time ms F kN\n0 1\n1 2\n",
                [None, None],
                "file:2: the line has 2 cells, the names are 4: put names",
            ),
            ("Rate,1000\nt,F\n0,1\n1,2\n", [None, None], "file:2, column \"t\""),
            ("t\n0 1\n1 2\n", [None, None], "file:2: the line has 2 cells, the names are 1: put names"),
            ("t,F\n0,1\n1,2\n", [None, Some("G")], "value_column has no column \"G\", its columns are t, F"),
            (
                "0,1\n1,2\n",
                [Some("3"), None],
                "time_column has no column \"3\", its columns are numbered 1 to 2",
            ),
        ] {
            let found = read(text, wanted).expect_err(text);
            assert!(found.contains(words), "{text:?}: {found}");
        }
    }
}
