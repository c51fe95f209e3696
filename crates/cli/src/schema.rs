//! `penombre schema`: the scene format as a JSON Schema, for editors of TOML and JSON.

use crate::{Exit, terminal};
use penombre::camera::AnyCamera;
use penombre::light::AnyLight;
use penombre::material::AnyMaterial;
use penombre::render::NODE_SCHEMAS;
use penombre::scene::INSTANCE_SCHEMA;
use penombre::shape::AnyShape;
use penombre::texture::AnyTexture;
use penombre::{TypeInfo, integrator};
use penombre_scene::native::FORMAT_VERSION;
use penombre_scene::{Kind, ParamDefault, ParamSpec, Range, Role};
use serde_json::{Map, Value, json};

/// Prints it.
pub fn run() -> Exit {
    let text = serde_json::to_string_pretty(&schema()).unwrap_or_default();
    terminal::out(&text);
    Exit::Done
}

/// The schema, draft 7: what editors' servers know.
fn schema() -> Value {
    let mut roles = Map::new();
    roles.insert(
        "penombre".to_owned(),
        json!({ "const": FORMAT_VERSION, "description": "Version of the scene format." }),
    );
    roles.insert(
        "include".to_owned(),
        json!({ "type": "array", "items": { "type": "string" }, "description": "Scene files that belong to it." }),
    );
    roles.insert(
        "$schema".to_owned(),
        json!({ "type": "string", "description": "In JSON: where this schema lies, for editors." }),
    );
    for role in Role::ALL {
        roles.insert(role.name().to_owned(), of_role(role));
    }
    json!({
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "A scene of penombre",
        "type": "object",
        "required": ["penombre"],
        "properties": roles,
        "additionalProperties": false,
        "definitions": definitions(),
    })
}

/// Values that recur.
fn definitions() -> Value {
    let vec3 = list(&json!({ "type": "number" }), 3);
    let step = |key: &str, value: Value| object(&[(key, value)], &[key]);
    let angle = json!({ "type": "number", "description": "Degrees." });
    json!({
        "vec3": vec3,
        "transform": { "type": "array", "items": { "anyOf": [
            step("translate", vec3.clone()),
            step("scale", json!({ "anyOf": [{ "type": "number" }, vec3] })),
            object(&[("rotate", vec3), ("angle", angle)], &["rotate", "angle"]),
            step("matrix", list(&json!({ "type": "number" }), 16)),
        ] } },
        "texture": object(&[("texture", json!({ "type": "string", "description": "Name of a texture." }))], &["texture"]),
    })
}

fn of_role(role: Role) -> Value {
    let named = |each: Value| json!({ "type": "object", "additionalProperties": each });
    match role {
        Role::Render => {
            NODE_SCHEMAS.iter().find(|(r, _)| *r == role).map_or(Value::Null, |(_, s)| params(s, None))
        }
        Role::Integrator => {
            let each: Map<String, Value> = integrator::TYPES
                .iter()
                .map(|(name, schema)| ((*name).to_owned(), params(schema, None)))
                .collect();
            json!({ "type": "object", "properties": each, "additionalProperties": false })
        }
        Role::Instance => named(params(INSTANCE_SCHEMA, None)),
        Role::Camera => named(types(AnyCamera::TYPES)),
        Role::Texture => named(types(AnyTexture::TYPES)),
        Role::Material => named(types(AnyMaterial::TYPES)),
        Role::Shape => named(types(AnyShape::TYPES)),
        Role::Light => named(types(AnyLight::TYPES)),
    }
}

/// A node of one of the types.
fn types(types: &[TypeInfo]) -> Value {
    json!({ "type": "object", "required": ["type"], "anyOf": types.iter().map(|t| params(t.schema, Some(t))).collect::<Vec<_>>() })
}

/// A table with these parameters, and with the `type` if there is one.
fn params(schema: &[ParamSpec], of: Option<&TypeInfo>) -> Value {
    let mut properties = Map::new();
    let mut required = Vec::new();
    if let Some(info) = of {
        let names: Vec<&str> = [info.name].into_iter().chain(info.aliases.iter().copied()).collect();
        properties.insert("type".to_owned(), json!({ "enum": names }));
        required.push("type");
    }
    for spec in schema {
        properties.insert(spec.name.to_owned(), of_param(spec));
        if spec.default == ParamDefault::Required {
            required.push(spec.name);
        }
    }
    json!({ "type": "object", "properties": properties, "required": required, "additionalProperties": false })
}

fn of_param(spec: &ParamSpec) -> Value {
    let mut value = of_kind(&spec.kind);
    let unit = if spec.unit.is_empty() { String::new() } else { format!(" Unit: {}.", spec.unit) };
    value["description"] = format!("{}{unit}", spec.doc).into();
    let default = match spec.default {
        ParamDefault::Required | ParamDefault::Absent => return value,
        ParamDefault::Bool(v) => json!(v),
        ParamDefault::Int(v) => json!(v),
        // No number of JSON is infinite.
        ParamDefault::Float(v) if !v.is_finite() => return value,
        ParamDefault::Float(v) => json!(v),
        ParamDefault::Vec2(v) => json!(v),
        ParamDefault::Vec3(v) => json!(v),
        ParamDefault::Color(v) => json!(v.map(|c| f64::from(c.to_string().parse::<f32>().unwrap_or(c)))),
        ParamDefault::Text(v) => json!(v),
    };
    value["default"] = default;
    value
}

fn of_kind(kind: &Kind) -> Value {
    let vec3 = || json!({ "$ref": "#/definitions/vec3" });
    match kind {
        Kind::Bool => json!({ "type": "boolean" }),
        Kind::Int(range) => number("integer", range),
        Kind::Float(range) => number("number", range),
        Kind::Vec2(range) => list(&number("number", range), 2),
        Kind::Int2(range) => list(&number("integer", range), 2),
        Kind::Vec3 | Kind::Direction => json!({ "allOf": [vec3()] }),
        Kind::Sides => list(&vec3(), 2),
        Kind::Color(range) => json!({ "anyOf": color(range) }),
        Kind::ColorTexture(range) => {
            let mut any = color(range);
            any.push(json!({ "$ref": "#/definitions/texture" }));
            json!({ "anyOf": any })
        }
        Kind::FloatTexture(range) => {
            json!({ "anyOf": [number("number", range), { "$ref": "#/definitions/texture" }] })
        }
        Kind::Choice(words) => json!({ "enum": words }),
        Kind::Text | Kind::File | Kind::Reference(_) => json!({ "type": "string" }),
        Kind::Transform => json!({ "allOf": [{ "$ref": "#/definitions/transform" }] }),
        Kind::Transforms => json!({ "type": "array", "items": { "$ref": "#/definitions/transform" } }),
        Kind::Vec3List => json!({ "type": "array", "items": vec3() }),
        Kind::Vec2List => json!({ "type": "array", "items": list(&json!({ "type": "number" }), 2) }),
        Kind::ColorList => json!({ "type": "array", "items": { "anyOf": color(&Range::ANY) } }),
        Kind::Faces => {
            let index = json!({ "type": "integer", "minimum": 0 });
            json!({ "type": "array", "items": { "type": "array", "items": index, "minItems": 3 } })
        }
    }
}

/// Three numbers, one for grey, or an sRGB code.
fn color(range: &Range) -> Vec<Value> {
    let each = number("number", range);
    vec![list(&each, 3), each, json!({ "type": "string", "pattern": "^#([0-9a-fA-F]{3}|[0-9a-fA-F]{6})$" })]
}

/// A list of so many.
fn list(item: &Value, count: usize) -> Value {
    json!({ "type": "array", "items": item, "minItems": count, "maxItems": count })
}

fn object(properties: &[(&str, Value)], required: &[&str]) -> Value {
    let each: Map<String, Value> =
        properties.iter().map(|(key, value)| ((*key).to_owned(), value.clone())).collect();
    json!({ "type": "object", "properties": each, "required": required, "additionalProperties": false })
}

/// Limits that only say "finite" are left out.
fn number(of: &str, range: &Range) -> Value {
    let mut value = json!({ "type": of });
    let limit = |v: f64| if of == "integer" && v.abs() < 1e15 { json!(v as i64) } else { json!(v) };
    if range.min > f64::MIN {
        value[if range.min_open { "exclusiveMinimum" } else { "minimum" }] = limit(range.min);
    }
    if range.max < f64::MAX {
        value[if range.max_open { "exclusiveMaximum" } else { "maximum" }] = limit(range.max);
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_type_and_parameter_is_in_it() {
        let schema = schema();
        let materials = &schema["properties"]["material"]["additionalProperties"]["anyOf"];
        assert_eq!(materials.as_array().unwrap().len(), AnyMaterial::TYPES.len());
        let phong = &materials[0];
        assert_eq!(phong["properties"]["type"]["enum"][0], AnyMaterial::TYPES[0].name);
        for spec in AnyMaterial::TYPES[0].schema {
            assert!(phong["properties"][spec.name]["description"].as_str().unwrap().starts_with(spec.doc));
        }
        assert_eq!(
            schema["properties"]["integrator"]["properties"]["path"]["properties"]["roulette_depth"]["default"],
            5
        );
        assert_eq!(schema["properties"]["render"]["properties"]["size"]["maxItems"], 2);
    }

    #[test]
    fn ranges_become_limits() {
        assert_eq!(number("number", &Range::ANY), json!({ "type": "number" }));
        assert_eq!(number("number", &Range::POSITIVE), json!({ "type": "number", "exclusiveMinimum": 0.0 }));
        assert_eq!(
            number("integer", &Range::closed(1.0, 9.0)),
            json!({ "type": "integer", "minimum": 1, "maximum": 9 })
        );
    }
}
