//! What a parameter may hold: a kind's JSON schema, read once and made quick to walk.

use serde_json::Value;
use std::collections::BTreeMap;

/// The key of a schema that says a number's unit: `#[schemars(extend("x-unit" = "texels"))]`.
const UNIT: &str = "x-unit";

/// Nesting of schemas that is followed; below it serde alone judges.
const DEPTH: u32 = 16;

/// A parameter's type.
#[derive(Clone, Debug)]
pub enum Ty {
    /// Judged by serde alone.
    Any,
    Bool,
    Integer {
        min: i128,
        max: i128,
        /// Such as `texels`; empty where there is none.
        unit: String,
    },
    /// A finite number; bounds with whether they themselves are excluded.
    Number {
        min: Option<(f64, bool)>,
        max: Option<(f64, bool)>,
        unit: String,
    },
    Text,
    /// A file of the outside world.
    Path,
    /// One of these words.
    Word(Vec<String>),
    List {
        first: Vec<Ty>,
        rest: Box<Ty>,
        min: usize,
        max: usize,
    },
    Table {
        fields: BTreeMap<String, Ty>,
        required: Vec<String>,
        rest: Option<Box<Ty>>,
    },
    OneOf(Vec<Ty>),
}

impl Ty {
    /// The type that `schema` describes; `root` holds its definitions.
    pub fn of(schema: &Value, root: &Value) -> Self {
        read(schema, root, 0)
    }

    /// The type of a list's items, where the list says their unit.
    fn in_unit(mut self, name: &str) -> Self {
        if let Self::Integer { unit, .. } | Self::Number { unit, .. } = &mut self
            && !name.is_empty()
        {
            name.clone_into(unit);
        }
        self
    }

    /// The first number in `value` that is out of its range, in words. Everything else is serde's to judge.
    pub fn out_of_range(&self, value: &Value) -> Option<String> {
        let refuse = || Some(format!("expected {}, found {value}", self.describe()));
        match (self, value) {
            (Self::Integer { min, max, .. }, Value::Number(n)) => {
                let fits = n.as_i128().is_none_or(|v| v >= *min && v <= *max);
                if fits { None } else { refuse() }
            }
            (Self::Number { min, max, .. }, Value::Number(n)) => {
                let fits = n.as_f64().is_none_or(|v| lies_within(v, *min, *max));
                if fits { None } else { refuse() }
            }
            (Self::List { first, rest, .. }, Value::Array(items)) => {
                items.iter().enumerate().find_map(|(i, item)| first.get(i).unwrap_or(rest).out_of_range(item))
            }
            (Self::Table { fields, rest, .. }, Value::Object(members)) => members.iter().find_map(|(name, value)| {
                let wrong = fields.get(name).or(rest.as_deref())?.out_of_range(value)?;
                Some(format!("`{name}`: {wrong}"))
            }),
            (Self::OneOf(types), _) => {
                let wrong: Option<Vec<String>> = types.iter().map(|ty| ty.out_of_range(value)).collect();
                wrong.and_then(|wrong| wrong.into_iter().next())
            }
            _ => None,
        }
    }

    /// "a number in 0 … 1", for messages and the reference.
    pub fn describe(&self) -> String {
        match self {
            Self::Any => "any value".to_owned(),
            Self::Bool => "true or false".to_owned(),
            Self::Integer { min, max, unit } => {
                let shown = |v: &i128| (v.unsigned_abs() < u128::from(u32::MAX)).then(|| (v.to_string(), false));
                format!("a whole number{}{}", range(shown(min), shown(max)), after_space(unit))
            }
            Self::Number { min, max, unit } => {
                let shown = |bound: &Option<(f64, bool)>| bound.map(|(v, out)| (v.to_string(), out));
                format!("a number{}{}", range(shown(min), shown(max)), after_space(unit))
            }
            Self::Text => "text in quotes".to_owned(),
            Self::Path => "the path of a file, in quotes".to_owned(),
            Self::Word(words) => match &words[..] {
                [one] => format!("\"{one}\""),
                _ => words.iter().map(|w| format!("\"{w}\"")).collect::<Vec<_>>().join(" or "),
            },
            Self::List { first, rest, min, max } => {
                let count = match (min, max) {
                    (min, max) if min == max => format!("a list of {min}"),
                    (0, &usize::MAX) => "a list".to_owned(),
                    (min, &usize::MAX) => format!("a list of at least {min}"),
                    (min, max) => format!("a list of {min} to {max}"),
                };
                format!("{count}, each {}", first.first().unwrap_or(rest).describe())
            }
            Self::Table { fields, .. } => {
                let names: Vec<String> = fields.keys().map(|k| format!("{k} = …")).collect();
                format!("a table {{ {} }}", names.join(", "))
            }
            Self::OneOf(types) => types.iter().map(Self::describe).collect::<Vec<_>>().join(", or "),
        }
    }
}

/// " in 0 … 1" or " above 0 and at most 1", of bounds with whether they are excluded.
fn range(min: Option<(String, bool)>, max: Option<(String, bool)>) -> String {
    let low = |(v, out): &(String, bool)| if *out { format!("above {v}") } else { format!("of at least {v}") };
    let high = |(v, out): &(String, bool)| if *out { format!("below {v}") } else { format!("at most {v}") };
    match (&min, &max) {
        (Some((min, false)), Some((max, false))) => format!(" in {min} … {max}"),
        (Some(min), Some(max)) => format!(" {} and {}", low(min), high(max)),
        (Some(min), None) => format!(" {}", low(min)),
        (None, Some(max @ (_, false))) => format!(" of {}", high(max)),
        (None, Some(max)) => format!(" {}", high(max)),
        (None, None) => String::new(),
    }
}

fn after_space(unit: &str) -> String {
    if unit.is_empty() { String::new() } else { format!(" {unit}") }
}

/// Whether a number lies between bounds, each with whether it is excluded itself.
pub fn lies_within(value: f64, min: Option<(f64, bool)>, max: Option<(f64, bool)>) -> bool {
    let low = min.is_some_and(|(m, open)| value < m || open && value == m);
    let high = max.is_some_and(|(m, open)| value > m || open && value == m);
    !low && !high
}

fn read(schema: &Value, root: &Value, depth: u32) -> Ty {
    let next = |s: &Value| read(s, root, depth + 1);
    let number = |key: &str| schema.get(key).and_then(Value::as_f64);
    if depth > DEPTH {
        return Ty::Any;
    }
    if let Some(target) = schema.get("$ref").and_then(Value::as_str) {
        let found = target.strip_prefix('#').and_then(|pointer| root.pointer(pointer));
        return found.map_or(Ty::Any, next);
    }
    for key in ["oneOf", "anyOf"] {
        if let Some(options) = schema.get(key).and_then(Value::as_array) {
            return one_of(options.iter().filter(|s| s.get("type") != Some(&"null".into())).map(next).collect());
        }
    }
    if let Some([only]) = schema.get("allOf").and_then(Value::as_array).map(Vec::as_slice) {
        return next(only);
    }
    if let Some(word) = schema.get("const").and_then(Value::as_str) {
        return Ty::Word(vec![word.to_owned()]);
    }
    if let Some(words) = schema.get("enum").and_then(Value::as_array) {
        return Ty::Word(words.iter().filter_map(Value::as_str).map(str::to_owned).collect());
    }
    match schema.get("type") {
        Some(Value::String(name)) => plain(name, schema, root, depth),
        // An Option: what it holds, or nothing, which a file says by leaving the key out.
        Some(Value::Array(names)) => {
            let names = names.iter().filter_map(Value::as_str).filter(|n| *n != "null");
            one_of(names.map(|name| plain(name, schema, root, depth)).collect())
        }
        _ if number("minimum").is_some() || number("maximum").is_some() => plain("number", schema, root, depth),
        _ => Ty::Any,
    }
}

fn one_of(mut types: Vec<Ty>) -> Ty {
    if types.iter().all(|t| matches!(t, Ty::Word(_))) && !types.is_empty() {
        return Ty::Word(types.into_iter().flat_map(|t| if let Ty::Word(w) = t { w } else { Vec::new() }).collect());
    }
    match types.len() {
        0 => Ty::Any,
        1 => types.remove(0),
        _ => Ty::OneOf(types),
    }
}

fn plain(name: &str, schema: &Value, root: &Value, depth: u32) -> Ty {
    let next = |s: &Value| read(s, root, depth + 1);
    let get = |key: &str| schema.get(key);
    let number = |key: &str| get(key).and_then(Value::as_f64);
    let count = |key: &str| get(key).and_then(Value::as_u64).and_then(|v| usize::try_from(v).ok());
    let format = get("format").and_then(Value::as_str).unwrap_or_default();
    let unit = get(UNIT).and_then(Value::as_str).unwrap_or_default().to_owned();
    match name {
        "boolean" => Ty::Bool,
        "integer" => {
            let (lowest, highest) = match format {
                "uint8" => (0, u8::MAX.into()),
                "uint16" => (0, u16::MAX.into()),
                "uint32" => (0, u32::MAX.into()),
                "uint64" | "uint" => (0, u64::MAX.into()),
                "int8" => (i8::MIN.into(), i8::MAX.into()),
                "int16" => (i16::MIN.into(), i16::MAX.into()),
                "int32" => (i32::MIN.into(), i32::MAX.into()),
                _ => (i64::MIN.into(), i64::MAX.into()),
            };
            let at_least = number("minimum").map(|v| v.ceil() as i128);
            let above = number("exclusiveMinimum").map(|v| v.floor() as i128 + 1);
            let at_most = number("maximum").map(|v| v.floor() as i128);
            let below = number("exclusiveMaximum").map(|v| v.ceil() as i128 - 1);
            Ty::Integer {
                min: [at_least, above].into_iter().flatten().fold(lowest, i128::max),
                max: [at_most, below].into_iter().flatten().fold(highest, i128::min),
                unit,
            }
        }
        "number" => {
            let bound =
                |open: &str, closed: &str| number(open).map(|v| (v, true)).or(number(closed).map(|v| (v, false)));
            Ty::Number { min: bound("exclusiveMinimum", "minimum"), max: bound("exclusiveMaximum", "maximum"), unit }
        }
        "string" if format == "source-path" => Ty::Path,
        "string" => Ty::Text,
        "array" => Ty::List {
            first: get("prefixItems").and_then(Value::as_array).into_iter().flatten().map(next).collect(),
            rest: Box::new(get("items").map_or(Ty::Any, next).in_unit(&unit)),
            min: count("minItems").unwrap_or(0),
            max: count("maxItems").unwrap_or(usize::MAX),
        },
        "object" => Ty::Table {
            fields: fields(schema, &next),
            required: required(schema),
            rest: match get("additionalProperties") {
                Some(Value::Bool(false)) => None,
                Some(other) => Some(Box::new(next(other))),
                None => get("properties").is_none().then(|| Box::new(Ty::Any)),
            },
        },
        _ => Ty::Any,
    }
}

fn fields(schema: &Value, next: &dyn Fn(&Value) -> Ty) -> BTreeMap<String, Ty> {
    let fields = schema.get("properties").and_then(Value::as_object);
    fields.into_iter().flatten().map(|(name, schema)| (name.clone(), next(schema))).collect()
}

fn required(schema: &Value) -> Vec<String> {
    let names = schema.get("required").and_then(Value::as_array);
    names.into_iter().flatten().filter_map(Value::as_str).map(str::to_owned).collect()
}

/// A kind's parameters: name, type, and the names of those without default.
pub fn parameters(root: &Value) -> (BTreeMap<String, Ty>, Vec<String>) {
    (fields(root, &|schema| Ty::of(schema, root)), required(root))
}

#[cfg(test)]
mod tests {
    use super::*;
    use schemars::JsonSchema;
    use serde_json::json;

    #[derive(JsonSchema)]
    #[expect(dead_code, reason = "only its schema is used")]
    enum Policy {
        /// Documented.
        Cover,
        Quadric,
    }

    #[derive(JsonSchema)]
    #[expect(dead_code, reason = "only its schema is used")]
    struct Params {
        #[schemars(range(min = 1.0, max = 8.0))]
        factor: f64,
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        side: Option<f64>,
        #[schemars(extend("exclusiveMinimum" = 0.0, "exclusiveMaximum" = 180.0, "x-unit" = "degrees"))]
        fov: f64,
        #[schemars(range(max = 1.0), extend("exclusiveMinimum" = 0.0))]
        dot: f64,
        #[schemars(inner(range(min = 1, max = 4096)), extend("x-unit" = "pixels"))]
        size: [u32; 2],
        #[schemars(range(min = 1))]
        views: u32,
        samples: Option<u8>,
        policy: Policy,
        maybe: Option<Policy>,
        centre: [f64; 3],
        names: Vec<String>,
        seed: u64,
        path: crate::engine::node::SourcePath,
    }

    #[test]
    fn descriptions() {
        let schema = schemars::schema_for!(Params).to_value();
        let (types, required) = parameters(&schema);
        for (name, expect) in [
            ("factor", "a number in 1 … 8"),
            ("side", "a number above 0"),
            ("fov", "a number above 0 and below 180 degrees"),
            ("dot", "a number above 0 and at most 1"),
            ("size", "a list of 2, each a whole number in 1 … 4096 pixels"),
            ("views", "a whole number of at least 1"),
            ("samples", "a whole number in 0 … 255"),
            ("policy", "\"Cover\" or \"Quadric\""),
            ("maybe", "\"Cover\" or \"Quadric\""),
            ("centre", "a list of 3, each a number"),
            ("names", "a list, each text in quotes"),
            ("seed", "a whole number of at least 0"),
            ("path", "the path of a file, in quotes"),
        ] {
            let words = types[name].describe();
            // An enum's words come in the order of its schema, those without documentation first.
            let same = words == expect
                || expect.split(" or ").collect::<Vec<_>>().into_iter().rev().collect::<Vec<_>>().join(" or ") == words;
            assert!(same, "{name}: {words}");
        }
        assert!(required.contains(&"factor".to_owned()) && !required.contains(&"side".to_owned()));
    }

    #[test]
    fn numbers_out_of_range_are_found_wherever_they_are() {
        let schema = schemars::schema_for!(Params).to_value();
        let (types, _) = parameters(&schema);
        for (name, value, expect) in [
            ("factor", json!(8.0), None),
            ("factor", json!(8.5), Some("expected a number in 1 … 8, found 8.5")),
            ("side", json!(null), None),
            ("side", json!(0.0), Some("expected a number above 0, found 0.0")),
            ("fov", json!(180.0), Some("expected a number above 0 and below 180 degrees, found 180.0")),
            ("dot", json!(1.0), None),
            ("size", json!([1, 5000]), Some("expected a whole number in 1 … 4096 pixels, found 5000")),
            ("views", json!(0), Some("expected a whole number of at least 1, found 0")),
        ] {
            assert_eq!(types[name].out_of_range(&value).as_deref(), expect, "{name}");
        }
        let table = Ty::Table { fields: types, required: Vec::new(), rest: None };
        let wrong = table.out_of_range(&json!({ "dot": 0.5, "views": 0 }));
        assert_eq!(wrong.as_deref(), Some("`views`: expected a whole number of at least 1, found 0"));
    }
}
