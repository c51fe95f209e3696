use super::*;
use crate::description::{Role, Value};
use crate::schema::{Kind, ParamDefault, Range};
use penombre_math::{DVec3, color::srgb_decode_u8};

const SCHEMA: &[ParamSpec] = &[
    ParamSpec::with_default("on", Kind::Bool, ParamDefault::Bool(true), "Switch."),
    ParamSpec::with_default("count", Kind::Int(Range::closed(1.0, 100.0)), ParamDefault::Int(7), "How many."),
    ParamSpec::with_default("radius", Kind::Float(Range::POSITIVE), ParamDefault::Float(2.0), "The radius.")
        .unit("m"),
    ParamSpec::with_default(
        "far",
        Kind::Float(Range::POSITIVE.or_infinite()),
        ParamDefault::Float(9.0),
        "OFF is far.",
    ),
    ParamSpec::with_default("scale", Kind::Vec2(Range::ANY), ParamDefault::Vec2([8.0, 4.0]), "Scale."),
    ParamSpec::with_default(
        "size",
        Kind::Int2(Range::closed(1.0, 1e6)),
        ParamDefault::Vec2([48.0, 32.0]),
        "Width and height.",
    ),
    ParamSpec::optional("target", Kind::Vec3, "What is looked at."),
    ParamSpec::with_default("up", Kind::Direction, ParamDefault::Vec3([0.0, 1.0, 0.0]), "Up."),
    ParamSpec::optional("sides", Kind::Sides, ""),
    ParamSpec::with_default("tint", Kind::Color(Range::UNIT), ParamDefault::Color([0.5; 3]), "Tint."),
    ParamSpec::with_default(
        "diffuse",
        Kind::ColorTexture(Range::UNIT),
        ParamDefault::Color([0.25; 3]),
        "Paint.",
    ),
    ParamSpec::with_default("rough", Kind::FloatTexture(Range::UNIT), ParamDefault::Float(0.125), "Rough."),
    ParamSpec::with_default("wrap", Kind::Choice(&["repeat", "clamp"]), ParamDefault::Text("repeat"), "How."),
    ParamSpec::optional("note", Kind::Text, ""),
    ParamSpec::optional("file", Kind::File, ""),
    ParamSpec::optional("material", Kind::Reference(Role::Material), ""),
    ParamSpec::optional("transform", Kind::Transform, ""),
    ParamSpec::optional("transforms", Kind::Transforms, ""),
    ParamSpec::optional("points", Kind::Vec3List, ""),
    ParamSpec::optional("uvs", Kind::Vec2List, ""),
    ParamSpec::optional("colors", Kind::ColorList, ""),
    ParamSpec::optional("faces", Kind::Faces, ""),
];

fn scene() -> SceneDescription {
    let mut scene = SceneDescription::default();
    scene.add(Node::new(Role::Texture, "checker", "checks"));
    scene.add(Node::new(Role::Material, "phong", "red"));
    scene
}

/// Decodes a node with these parameters; the messages as `code message | help`.
fn decode(entries: Vec<(&str, Value)>) -> (Params, Vec<String>) {
    let node = entries.into_iter().fold(Node::new(Role::Shape, "thing", "it"), |n, (k, v)| n.with(k, v));
    let mut out = Diagnostics::default();
    let params = Params::decode(&node, SCHEMA, &scene(), &mut out);
    (params, out.iter().map(|d| format!("{} {} | {}", d.code, d.message, d.help)).collect())
}

fn good(entries: Vec<(&str, Value)>) -> Params {
    let (params, faults) = decode(entries);
    assert_eq!(faults, [""; 0]);
    params
}

/// The one fault of one parameter; it must contain every one of the words.
fn fault(name: &str, value: impl Into<Value>, words: &[&str]) -> Params {
    let (params, faults) = decode(vec![(name, value.into())]);
    assert_eq!(faults.len(), 1, "{faults:?}");
    assert!(!faults[0].ends_with("| "), "no help: {faults:?}");
    for word in words {
        assert!(faults[0].contains(word), "{:?} has no {word:?}", faults[0]);
    }
    params
}

fn table<const N: usize>(entries: [(&str, Value); N]) -> Value {
    entries.into()
}

#[test]
fn absent_parameters_have_their_defaults() {
    let p = good(vec![]);
    assert!(p.bool("on"));
    assert_eq!((p.int("count"), p.f32("radius"), p.f64("radius")), (7, 2.0, 2.0));
    assert_eq!((p.vec2("scale"), p.int2("size")), (Vec2::new(8.0, 4.0), [48, 32]));
    assert_eq!((p.opt_vec3("target"), p.vec3("up")), (None, Vec3::Y));
    assert_eq!((p.color("tint"), p.color_texture("diffuse")), ([0.5; 3], ColorInput::Constant([0.25; 3])));
    assert_eq!((p.float_texture("rough"), p.choice("wrap")), (FloatInput::Constant(0.125), "repeat"));
    assert_eq!((p.text("note"), p.file("file"), p.reference("material")), (None, None, None));
    assert_eq!((p.transform("transform"), p.transforms("transforms")), (DAffine3::IDENTITY, vec![]));
    assert!(p.vec3_list("points").is_empty() && p.faces("faces").is_empty());
    assert!(!p.is_given("radius"));
}

#[test]
fn given_parameters_are_decoded_and_whole_numbers_are_numbers() {
    let p = good(vec![
        ("on", false.into()),
        ("count", 3.into()),
        ("radius", 4.into()),
        ("far", f64::INFINITY.into()),
        ("scale", [1, 2].into()),
        ("size", [640, 480].into()),
        ("target", [1.0, 2.0, 3.0].into()),
        ("sides", vec![Value::from([1, 0, 0]), [0, 0, 2].into()].into()),
        ("tint", "#ff8000".into()),
        ("diffuse", table([("texture", "checks".into())])),
        ("rough", table([("texture", "checks".into())])),
        ("wrap", "clamp".into()),
        ("material", "red".into()),
        ("uvs", vec![Value::from([0, 1]), [0.5, 0.25].into()].into()),
        ("colors", vec![Value::from([0, 1, 0]), "#000".into(), 0.5.into()].into()),
        ("faces", vec![Value::from([0, 1, 2]), [3, 2, 1, 0].into()].into()),
    ]);
    assert!(!p.bool("on") && p.is_given("on"));
    assert_eq!((p.int("count"), p.f32("radius"), p.f32("far")), (3, 4.0, f32::INFINITY));
    assert_eq!((p.vec2("scale"), p.int2("size")), (Vec2::new(1.0, 2.0), [640, 480]));
    assert_eq!(p.opt_vec3("target"), Some(Vec3::new(1.0, 2.0, 3.0)));
    assert_eq!(p.sides("sides"), [Vec3::X, Vec3::new(0.0, 0.0, 2.0)]);
    assert_eq!(p.color("tint"), [1.0, srgb_decode_u8(128), 0.0]);
    assert_eq!(p.color_texture("diffuse"), ColorInput::Texture(NodeId(0)));
    assert_eq!(p.float_texture("rough"), FloatInput::Texture(NodeId(0)));
    assert_eq!((p.choice("wrap"), p.reference("material")), ("clamp", Some(NodeId(1))));
    assert_eq!(p.vec2_list("uvs"), [Vec2::new(0.0, 1.0), Vec2::new(0.5, 0.25)]);
    assert_eq!(p.color_list("colors"), [[0.0, 1.0, 0.0], [0.0; 3], [0.5; 3]]);
    assert_eq!(p.faces("faces"), [vec![0, 1, 2], vec![3, 2, 1, 0]]);
}

#[test]
fn all_faults_of_a_node_are_reported() {
    let (_, faults) = decode(vec![
        ("radus", 1.into()),
        ("count", "three".into()),
        ("radius", (-1).into()),
        ("target", [0.0, f64::NAN, f64::INFINITY].into()),
        ("material", "rad".into()),
    ]);
    assert_eq!(faults.len(), 6, "{faults:?}");
    assert!(faults[0].starts_with("scene::unknown-parameter unknown parameter `radus` of `shape.it`"));
    assert!(faults[0].contains("did you mean `radius`?") && faults[0].contains("count"));
}

#[test]
fn wrong_types_say_what_was_found_and_expected() {
    fault("on", 1, &["scene::wrong-type", "`on` of `shape.it` is 1, expected true or false"]);
    fault("on", "false", &["is the text \"false\"", "| write false without quotes"]);
    fault("radius", "-1e3", &["| write -1e3 without quotes"]);
    fault("size", vec![Value::from(1), "2".into()], &["`size[1]`", "| write 2 without quotes"]);
    fault("count", 3.0, &["is 3.0, expected a whole number from 1 to 100", "write 3"]);
    fault("count", 3.5, &["is 3.5, expected a whole number"]);
    let p = fault("radius", "one", &["is the text \"one\", expected a number greater than 0 m"]);
    assert_eq!(p.f32("radius"), 2.0, "the default stands in");
    fault("target", 3, &["is 3, expected three numbers, [x, y, z]"]);
    fault("target", [1, 2], &["scene::wrong-length", "is a list with 2 entries, expected three numbers"]);
    fault("wrap", "clam", &["expected \"repeat\" or \"clamp\"", "did you mean `clamp`?"]);
    fault("note", 3, &["expected a text"]);
    fault(
        "transform",
        table([("scale", 2.into())]),
        &["is a table, expected a list of steps", "{ scale = 2 }"],
    );
    fault("points", vec![Value::from([0, 0, 0]), 1.into()], &["`points[1]` of `shape.it` is 1"]);
    fault("faces", vec![Value::from([0, 1])], &["`faces[0]`", "three or more indices"]);
    fault("faces", vec![Value::from([0, 1, -1])], &["`faces[0][2]`", "is -1"]);
    fault("note", vec![Value::from(1); 3], &["a list with 3 entries"]);
    fault("on", "x".repeat(500), &["xxx…"]);
}

#[test]
fn the_help_tells_what_a_parameter_means() {
    fault("on", 1, &["| `on` (default true): switch"]);
    fault("count", 0, &["| `count` (default 7): how many"]);
    fault("radius", -1, &["| `radius` (m, default 2): the radius"]);
    fault("far", -1, &["| `far` (default 9): OFF is far"]);
    fault("size", 1, &["| `size` (default [48, 32]): width and height"]);
    fault("target", 1, &["| `target`: what is looked at"]);
    fault("up", [0, 0, 0], &["| `up` (default [0, 1, 0]): up"]);
    fault("tint", -0.5, &["| `tint` (default [0.5, 0.5, 0.5]): tint"]);
    fault("wrap", 1, &["| `wrap` (default \"repeat\"): how"]);
    let angle = table([("rotate", [0, 1, 0].into()), ("angle", true.into())]);
    fault("transform", vec![angle], &["`transform[0].angle`", "| write [{ scale = 2 }, "]);
    let mut out = Diagnostics::default();
    Params::decode(&Node::new(Role::Material, "mirror", "m").with("x", 1), &[], &scene(), &mut out);
    assert_eq!(out.iter().next().unwrap().help, "materials of type mirror have no parameters");
}

#[test]
fn ranges_are_checked_before_and_after_rounding() {
    fault("radius", 0, &["scene::out-of-range", "is 0, expected a number greater than 0 m"]);
    fault("radius", -1, &["is -1"]);
    fault("radius", f64::NAN, &["is nan"]);
    fault("radius", f64::INFINITY, &["is inf"]);
    let p = fault("radius", f64::MAX, &["is above 1.79e308, expected a number greater than 0 m", "3.4e38"]);
    assert_eq!(p.f32("radius"), 2.0);
    let p = fault("radius", 1e300, &["is 1e300", "single precision, which ends at 3.4e38"]);
    assert_eq!(p.f32("radius"), 2.0);
    fault("radius", 1e-60, &["is 1e-60", "excluded end of the range"]);
    fault("far", f64::NEG_INFINITY, &["is -inf"]);
    fault("far", f64::NAN, &["is nan"]);
    fault("target", [0.0, f64::NAN, 0.0], &["`target[1]`", "expected a finite number"]);
    fault("target", [1e39, 0.0, 0.0], &["`target[0]`", "3.4e38"]);
    fault("count", 101, &["is 101, expected a whole number from 1 to 100"]);
    fault("size", [640, 0], &["`size[1]`", "is 0"]);
    fault("rough", 1.5, &["from 0 to 1"]);
    assert_eq!(good(vec![("radius", 1e-45.into())]).f32("radius"), f32::from_bits(1));
    assert_eq!(good(vec![("tint", 1.into())]).color("tint"), [1.0; 3]);
}

#[test]
fn colors_tell_how_they_are_written() {
    fault("tint", "red", &["scene::bad-color", "is the text \"red\", expected a colour", "\"#rrggbb\""]);
    fault("tint", "#12345", &["scene::bad-color"]);
    fault("tint", [1, 1, 1, 1], &["scene::wrong-length", "is a list with 4 entries"]);
    fault("tint", [255, 0, 0], &["`tint[0]`", "is 255, expected a number from 0 to 1", "sRGB code"]);
    fault("tint", -0.5, &["is -0.5"]);
    fault("diffuse", "checks", &["write { texture = \"checks\" }"]);
    fault("diffuse", true, &["a colour or { texture = \"NAME\" }"]);
    fault(
        "diffuse",
        table([("texture", "check".into())]),
        &["scene::missing-reference", "did you mean `checks`?"],
    );
    fault("diffuse", table([]), &["is a table, expected { texture = \"NAME\" }"]);
    fault("diffuse", table([("textur", "checks".into())]), &["unknown key `textur` in `diffuse`"]);
}

#[test]
fn missing_references_suggest_a_name_of_the_role() {
    let p = fault(
        "material",
        "rad",
        &["names \"rad\", but there is no material of that name", "did you mean `red`?"],
    );
    assert_eq!(p.reference("material"), None);
    fault("material", "checks", &["materials in this scene: red"]);
}

#[test]
fn directions_and_sides_must_span_something() {
    fault("up", [0, 0, 0], &["scene::zero-direction"]);
    let tiny = good(vec![("up", [1e-40, 0.0, 1e-40].into())]).vec3("up");
    assert_eq!(tiny, Vec3::new(1.0, 0.0, 1.0));
    let huge = good(vec![("up", [3e38, 0.0, 3e38].into())]).vec3("up");
    assert_eq!(huge, Vec3::new(1.0, 0.0, 1.0));
    let sides = |a: [f64; 3], b: [f64; 3]| vec![Value::from(a), b.into()];
    fault("sides", sides([1.0, 0.0, 0.0], [0.0; 3]), &["have a zero vector"]);
    fault("sides", sides([1.0, 2.0, 3.0], [-2.0, -4.0, -6.0]), &["are parallel"]);
    good(vec![("sides", sides([1e3, 0.0, 0.0], [0.0, 1e-3, 0.0]).into())]);
}

#[test]
fn transforms_are_composed_in_file_order() {
    let steps = vec![
        table([("scale", [1, 2, 3].into())]),
        table([("rotate", [0, 0, 5].into()), ("angle", 90.into())]),
        table([("translate", [10, 0, 0].into())]),
    ];
    let map = good(vec![("transform", steps.into())]).transform("transform");
    assert_eq!(map.transform_point3(DVec3::new(1.0, 1.0, 1.0)), DVec3::new(8.0, 1.0, 3.0));
    let matrix: Vec<Value> =
        [1.0, 0.0, 0.0, 5.0, 0.0, 0.0, -1.0, 6.0, 0.0, 1.0, 0.0, 7.0, 0.0, 0.0, 0.0, 1.0]
            .map(Value::from)
            .into();
    let steps = vec![table([("matrix", matrix.into())])];
    let map = good(vec![("transform", steps.into())]).transform("transform");
    assert_eq!(map.transform_point3(DVec3::new(1.0, 2.0, 3.0)), DVec3::new(6.0, 3.0, 9.0));
    let several = vec![Value::from(vec![table([("scale", 2.into())])]), Value::from(Vec::<Value>::new())];
    let maps = good(vec![("transforms", several.into())]).transforms("transforms");
    assert_eq!(maps, [DAffine3::from_scale(DVec3::splat(2.0)), DAffine3::IDENTITY]);
}

#[test]
fn rotations_are_rotations_about_their_axis() {
    for (axis, angle) in [([1.0, 2.0, -3.0], 77.0), ([1e-30, 0.0, 1e-30], -13.5), ([0.0, 1e30, 0.0], 720.25)]
    {
        let step = table([("rotate", axis.into()), ("angle", angle.into())]);
        let map = good(vec![("transform", vec![step].into())]).transform("transform");
        let m = map.matrix3;
        assert!(
            (m * m.transpose() - penombre_math::DMat3::IDENTITY)
                .abs_diff_eq(penombre_math::DMat3::ZERO, 1e-14)
        );
        assert!((m.determinant() - 1.0).abs() < 1e-14);
        let unit = DVec3::from_array(axis) / DVec3::from_array(axis).abs().max_element();
        assert!((m * unit - unit).length() < 1e-14);
        let trace = m.x_axis.x + m.y_axis.y + m.z_axis.z;
        assert!((trace - 1.0 - 2.0 * f64::cos(angle * std::f64::consts::PI / 180.0)).abs() < 1e-13);
    }
}

#[test]
fn bad_transforms_are_refused() {
    let step = |name: &str, value: Value| vec![table([(name, value)])];
    fault(
        "transform",
        step("scale", 0.into()),
        &["scene::singular-transform", "`transform[0].scale`", "scales by zero"],
    );
    fault("transform", step("scale", [1, 0, 1].into()), &["scales by zero"]);
    fault("transform", step("scael", 1.into()), &["unknown key `scael`", "did you mean `scale`?"]);
    fault("transform", step("rotate", [0, 1, 0].into()), &["rotates without an angle", "angle = 30"]);
    let zero_axis = vec![table([("rotate", [0, 0, 0].into()), ("angle", 3.into())])];
    fault("transform", zero_axis, &["the axis of the rotation"]);
    fault(
        "transform",
        step("translate", [1, 2].into()),
        &["`transform[0].translate`", "a list with 2 entries"],
    );
    fault("transform", step("matrix", vec![Value::from(1); 12].into()), &["expected 16 numbers"]);
    let singular: Vec<Value> = [1, 2, 3, 0, 4, 5, 6, 0, 7, 8, 9, 0, 0, 0, 0, 1].map(Value::from).into();
    fault("transform", step("matrix", singular.into()), &["is singular"]);
    let projective: Vec<Value> = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 1, 1].map(Value::from).into();
    fault("transform", step("matrix", projective.into()), &["last row"]);
    let two = vec![table([("scale", 2.into()), ("translate", [1, 0, 0].into())])];
    fault("transform", two, &["several of translate, scale, rotate and matrix"]);
    fault("transform", vec![table([])], &["none of translate"]);
    let angle = vec![table([("scale", 2.into()), ("angle", 3.into())])];
    fault("transform", angle, &["an angle, which belongs to rotate"]);
    let tiny = vec![table([("scale", 1e-30.into())]), table([("scale", 1e-30.into())])];
    fault("transform", tiny, &["leaves single precision"]);
}

#[test]
fn long_lists_with_many_faults_are_cut_short() {
    let (_, faults) = decode(vec![("points", vec![Value::from(1); 1000].into())]);
    assert_eq!(faults.len(), 21);
    assert!(faults[20].contains("more than 20 faults"), "{}", faults[20]);
}

#[test]
fn missing_parameters_are_told_with_what_they_want() {
    const REQUIRED: &[ParamSpec] = &[
        ParamSpec::required("center", Kind::Vec3, ""),
        ParamSpec::required("ior", Kind::Float(Range::closed(2.0, 4.0)), ""),
    ];
    let mut out = Diagnostics::default();
    let p = Params::decode(&Node::new(Role::Shape, "thing", "it"), REQUIRED, &scene(), &mut out);
    let messages: Vec<&str> = out.iter().map(|d| d.message.as_str()).collect();
    assert_eq!(messages[0], "`shape.it` has no parameter `center`, which it must have");
    assert_eq!(out.iter().next().unwrap().help, "add `center = …`: three numbers, [x, y, z]");
    assert_eq!(messages.len(), 2);
    assert_eq!(p.f32("ior"), 3.0, "a harmless value lies in the range");
}

#[test]
#[should_panic(expected = "`color`")]
fn getters_of_another_kind_are_a_fault_of_the_program() {
    good(vec![]).color("radius");
}

#[test]
fn thousands_of_missing_references_among_thousands_of_names_take_no_quadratic_time() {
    const SCHEMA: &[ParamSpec] = &[ParamSpec::optional("material", Kind::Reference(Role::Material), "")];
    let (mut scene, mut out) = (SceneDescription::default(), Diagnostics::default());
    let count = 20_000;
    for i in 0..count {
        scene.add(Node::new(Role::Material, "phong", format!("material-{i}")));
    }
    let begin = std::time::Instant::now();
    for i in 0..count {
        let node = Node::new(Role::Shape, "thing", format!("s{i}")).with("material", format!("materiel-{i}"));
        Params::decode(&node, SCHEMA, &scene, &mut out);
    }
    let help: Vec<&str> = out.iter().map(|d| d.help.as_str()).collect();
    assert_eq!(help.len(), count);
    assert!(help[7].starts_with("did you mean `material-7`?"), "{}", help[7]);
    assert_eq!(help[count - 1], "define it as [material.NAME] and give its name here");
    assert!(begin.elapsed().as_secs() < 20, "{:?}", begin.elapsed());
}
