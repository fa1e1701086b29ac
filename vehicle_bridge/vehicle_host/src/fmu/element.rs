//! Variables by name, elements of arrays among them: `velocity[0]`, `pose[1,2]`, indices from 0, the
//! last one running fastest, as FMI 3.0 orders them.

use fmu_core::{Inspection, VariableRow};

/// Which element of an array, and of how many.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Element {
    pub(super) index: usize,
    pub(super) count: usize,
}

/// The variable of a name; of an array's element, the array and which element it is.
///
/// # Errors
/// In words, if there is no such variable, or a name stands for a whole array or for none of its elements.
pub(super) fn find<'a>(
    inspection: &'a Inspection,
    name: &str,
) -> Result<(&'a VariableRow, Option<Element>), String> {
    let row = |name: &str| inspection.variables.iter().find(|row| row.name == name);
    if let Some(row) = row(name) {
        if row.dimensions.is_empty() {
            return Ok((row, None));
        }
        let shape = shape(row);
        return Err(format!(
            "`{name}` is an array of {shape}: name an element, such as `{name}[0]`"
        ));
    }
    let (array, indices) = split(name).ok_or("no such variable")?;
    let row = row(array).ok_or("no such variable")?;
    let shape = shape(row);
    if row.dimensions.len() != indices.len() {
        return Err(format!("found {} indices, the array has {shape}", indices.len()));
    }
    if indices.iter().zip(&row.dimensions).any(|(index, size)| index >= size) {
        return Err(format!("indices count from 0, and the array has {shape}"));
    }
    let index = indices.iter().zip(&row.dimensions).fold(0, |at, (index, size)| at * size + index);
    Ok((row, Some(Element { index, count: row.dimensions.iter().product() })))
}

/// Elements of small arrays as variables of their own: what a map may name.
pub(super) fn expanded(rows: &[VariableRow]) -> Vec<VariableRow> {
    let element = |row: &VariableRow, i: usize| VariableRow {
        name: format!("{}[{i}]", row.name),
        ..row.clone()
    };
    rows.iter()
        .flat_map(|row| match row.dimensions[..] {
            [] => vec![row.clone()],
            [count] if count <= 16 => (0..count).map(|i| element(row, i)).collect(),
            _ => Vec::new(),
        })
        .collect()
}

/// Values an array starts with; 0 where the description gives none.
pub(super) fn starts(row: &VariableRow, count: usize) -> Vec<f64> {
    let mut all: Vec<f64> =
        row.start.split_whitespace().map(|text| text.parse().unwrap_or(0.0)).collect();
    all.resize(count, 0.0);
    all
}

/// Sizes in words: `3`, `2 x 3`.
fn shape(row: &VariableRow) -> String {
    row.dimensions.iter().map(ToString::to_string).collect::<Vec<_>>().join(" x ")
}

/// `pose[1,2]` as `pose` and its indices.
fn split(name: &str) -> Option<(&str, Vec<usize>)> {
    let (array, indices) = name.strip_suffix(']')?.rsplit_once('[')?;
    let indices: Result<_, _> = indices.split(',').map(|index| index.trim().parse()).collect();
    Some((array, indices.ok()?))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "code of tests")]
    use super::*;

    fn inside() -> Inspection {
        let row = |name: &str, dimensions: &[usize]| VariableRow {
            name: name.to_owned(),
            start: "1 2.5".to_owned(),
            dimensions: dimensions.to_vec(),
            ..VariableRow::default()
        };
        Inspection {
            attributes: Vec::new(),
            files: Vec::new(),
            variables: vec![row("v", &[3]), row("m", &[2, 3]), row("old[1]", &[])],
            model_description: String::new(),
        }
    }

    #[test]
    fn names_lead_to_elements() {
        let inside = inside();
        let index = |name: &str| find(&inside, name).unwrap().1.map(|e| (e.index, e.count));
        assert_eq!(index("v[2]"), Some((2, 3)));
        assert_eq!(index("m[1, 2]"), Some((5, 6)));
        assert_eq!(index("old[1]"), None, "a scalar that is only called so");
        for (name, message) in [
            ("v", "an array of 3: name an element, such as `v[0]`"),
            ("v[3]", "count from 0, and the array has 3"),
            ("m[1]", "found 1 indices, the array has 2 x 3"),
            ("w[0]", "no such variable"),
            ("v[x]", "no such variable"),
        ] {
            let found = find(&inside, name).unwrap_err();
            assert!(found.contains(message), "{name}: {found}");
        }
        assert_eq!(starts(&inside.variables[0], 3), [1.0, 2.5, 0.0]);
        let names: Vec<_> = expanded(&inside.variables).into_iter().map(|row| row.name).collect();
        assert_eq!(names, ["v[0]", "v[1]", "v[2]", "old[1]"]);
    }
}
