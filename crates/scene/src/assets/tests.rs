use super::*;
use crate::Severity;
use crate::description::{Node, Role, Value};
use crate::diagnostic::Diagnostic;
use crate::span::Span;
use penombre_image::WriteOptions;
use std::fs;

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

struct Run {
    folder: tempfile::TempDir,
    scene: SceneDescription,
    sources: Sources,
    out: Diagnostics,
    assets: Assets,
}

impl Run {
    /// Writes the files and a two-pixel image `t.ppm`, then loads the nodes.
    fn new(files: &[(&str, &str)], nodes: Vec<Node>) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for (name, text) in files {
            fs::write(folder.path().join(name), text).expect("written");
        }
        fs::write(folder.path().join("t.ppm"), "P3\n2 1\n255\n255 0 0 0 0 255\n").expect("written");
        let mut scene = SceneDescription::default();
        for node in nodes {
            scene.add(node);
        }
        let (sources, out) = (Sources::default(), Diagnostics::default());
        let mut run = Self { folder, scene, sources, out, assets: Assets::default() };
        run.load();
        run
    }

    fn load(&mut self) {
        let folders = Folders { root: self.folder.path().to_owned(), asset_roots: Vec::new() };
        self.assets = Assets::load(&mut self.scene, &folders, &mut self.sources, &mut self.out);
    }

    fn codes(&self) -> Vec<&str> {
        self.out.iter().map(|d| d.code).collect()
    }

    fn shape(&self, name: &str) -> NodeId {
        self.scene.find(Role::Shape, name).expect("there")
    }
}

fn mesh(name: &str, file: &str) -> Node {
    Node::new(Role::Shape, "mesh", name).with("file", file)
}

#[test]
fn a_file_is_read_once_and_its_materials_are_shared() {
    let files = [
        ("m.obj", format!("mtllib m.mtl\n{TRIANGLE}usemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\n")),
        ("m.mtl", "newmtl a\nmap_Kd t.ppm\nnewmtl b\nKd 1 0 0\n".to_owned()),
    ];
    let files: Vec<(&str, &str)> = files.iter().map(|(n, t)| (*n, t.as_str())).collect();
    let own = mesh("three", "m.obj").with("material", "x");
    let texture = Node::new(Role::Texture, "image", "again").with("file", "./t.ppm");
    let mut run = Run::new(&files, vec![mesh("one", "m.obj"), mesh("two", "./m.obj"), own, texture]);
    assert!(run.out.is_empty(), "{:?}", run.out);
    let [one, two, three] = ["one", "two", "three"].map(|n| run.shape(n));
    let file = run.assets.mesh(one).expect("read");
    assert!(Arc::ptr_eq(file, run.assets.mesh(two).expect("read")));
    assert!(Arc::ptr_eq(file, run.assets.mesh(three).expect("read")));
    let slots = run.assets.slot_materials(one).to_vec();
    let names: Vec<&str> = slots.iter().map(|id| run.scene.node(*id).name.as_str()).collect();
    assert_eq!(names, ["one/a", "one/b"]);
    assert_eq!(run.assets.slot_materials(two), slots);
    assert!(run.assets.slot_materials(three).is_empty());
    let [mine, again] = ["one/a", "again"].map(|n| run.scene.find(Role::Texture, n).expect("there"));
    assert!(Arc::ptr_eq(run.assets.image(mine).expect("read"), run.assets.image(again).expect("read")));
    // A byte for each sample of the two pixels.
    let image_bytes = 2 * u64::from(run.assets.image(again).expect("read").channels());
    assert_eq!(run.assets.bytes(), image_bytes + 3 * 12 + 2 * 12 + 2 * 4);
    let hashes: Vec<_> = run.assets.content_hashes().collect();
    assert_eq!(hashes.len(), 5);
    assert_eq!(hashes[0].1, *blake3::hash(files[0].1.as_bytes()).as_bytes());
    // Loading the completed description again adds nothing.
    let before = run.scene.clone();
    run.load();
    assert!(run.out.is_empty() && run.scene == before);
    assert_eq!(run.assets.slot_materials(one), slots);
    assert!(run.assets.image(mine).is_some());
}

#[test]
fn a_mesh_whose_users_have_materials_adds_none() {
    let text = format!("mtllib no.mtl\n{TRIANGLE}usemtl a\nf 1 2 3\n");
    let run = Run::new(&[("m.obj", &text)], vec![mesh("one", "m.obj").with("material", "x")]);
    assert_eq!(run.scene.len(), 1);
    assert!(run.assets.mesh(run.shape("one")).is_some());
}

#[test]
fn a_material_of_the_scene_stands_in() {
    let text = format!("{TRIANGLE}f 1 2 3\n");
    let own = Node::new(Role::Material, "mirror", "one/default");
    let run = Run::new(&[("m.obj", &text)], vec![mesh("one", "m.obj"), own]);
    let slot = run.assets.slot_materials(run.shape("one"))[0];
    assert_eq!(run.scene.node(slot).type_name, "mirror");
    assert_eq!(run.scene.len(), 2);
}

#[test]
fn an_image_that_cannot_be_decoded_gives_the_plain_colour() {
    let text = format!("mtllib m.mtl\n{TRIANGLE}usemtl a\nf 1 2 3\n");
    let library = "newmtl a\nKd 0.25 0.5 1\nmap_Kd bad.png\n";
    let files = [("m.obj", text.as_str()), ("m.mtl", library), ("bad.png", "\u{89}PNG and no more")];
    let run = Run::new(&files, vec![mesh("one", "m.obj")]);
    assert_eq!(run.codes(), ["mtl::image"]);
    assert!(!run.out.has_errors());
    let place = run.sources.locate(run.out.iter().next().expect("one").span).expect("a place");
    assert_eq!((place.name, place.line, place.column), ("m.mtl", 3, 8));
    let slot = run.scene.node(run.assets.slot_materials(run.shape("one"))[0]);
    let plain: Value = [0.25, 0.5, 1.0].into();
    assert_eq!(slot.param("diffuse").expect("given").value, plain);
    assert_eq!(slot.param("ambient").expect("given").value, plain);
    assert_eq!(run.scene.of_role(Role::Texture).count(), 0);
}

#[test]
fn faults_of_nodes_are_errors() {
    let texture = |name: &str, file: &str| Node::new(Role::Texture, "image", name).with("file", file);
    let files = [("mesh.obj", "f"), ("m.3ds", "M"), ("bad.png", "no image")];
    let nodes = vec![
        mesh("missing", "mash.obj"),
        mesh("format", "m.3ds"),
        mesh("outside", "../x.obj"),
        texture("a", "bad.png"),
        texture("b", "no.png"),
        Node::new(Role::Shape, "mesh", "odd").with("file", 3),
    ];
    let run = Run::new(&files, nodes);
    let codes = ["asset::missing", "asset::mesh-format", "asset::outside", "asset::missing", "asset::image"];
    assert_eq!(run.codes(), codes);
    let first = run.out.iter().next().expect("some");
    assert!(first.help.starts_with("did you mean `mesh.obj`?"), "{}", first.help);
    assert_eq!(run.assets.content_hashes().count(), 0);
}

#[test]
fn names_are_relative_to_the_file_that_says_them() {
    let mut run = Run::new(&[], Vec::new());
    let sub = run.folder.path().join("sub");
    fs::create_dir(&sub).expect("made");
    fs::write(sub.join("m.obj"), format!("{TRIANGLE}f 1 2 3\n")).expect("written");
    let file = run.sources.add(&sub.join("part.toml"), "part.toml", "");
    let mut node = mesh("one", "m.obj");
    node.span = Span { file, start: 0, len: 0 };
    run.scene.add(node);
    run.load();
    assert!(run.out.is_empty() && run.assets.mesh(run.shape("one")).is_some());
}

#[test]
fn many_images_keep_their_nodes() {
    let mut run = Run::new(&[], Vec::new());
    for i in 0..40u32 {
        let mut image = Image::new(i + 1, 1, 3);
        image.pixel_mut(0, 0)[0] = 1.0;
        let path = run.folder.path().join(format!("{i}.png"));
        penombre_image::save(&path, &image, &WriteOptions::default()).expect("saved");
        run.scene.add(Node::new(Role::Texture, "image", i.to_string()).with("file", format!("{i}.png")));
    }
    run.load();
    for (id, node) in run.scene.of_role(Role::Texture) {
        let width = run.assets.image(id).expect("decoded").width();
        assert_eq!(width.to_string(), (node.name.parse::<u32>().expect("a number") + 1).to_string());
    }
}

#[test]
fn an_image_is_decoded_once_for_each_meaning_of_its_numbers() {
    let texture = |name: &str, encoding: &str| {
        Node::new(Role::Texture, "image", name).with("file", "p.ppm").with("encoding", encoding)
    };
    let plain = Node::new(Role::Texture, "image", "plain").with("file", "p.ppm");
    let files = [("p.ppm", "P3 1 1 255 51 102 255")];
    let run =
        Run::new(&files, vec![texture("a", "linear"), texture("b", "srgb"), plain, texture("c", "auto")]);
    assert!(run.out.is_empty(), "{:?}", run.out);
    let image = |name: &str| {
        let id = run.scene.find(Role::Texture, name).expect("there");
        run.assets.image(id).expect("decoded").clone()
    };
    assert_eq!(image("a").rgb(0, 0), [0.2, 0.4, 1.0]);
    let decoded = [0.2, 0.4, 1.0].map(penombre_math::color::srgb_decode);
    assert_eq!(image("b").rgb(0, 0), decoded);
    assert_eq!(image("plain").rgb(0, 0), decoded);
    assert!(Arc::ptr_eq(&image("plain"), &image("c")));
}

/// A square of two triangles as binary STL.
fn stl() -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend(2u32.to_le_bytes());
    for corners in [[0.0, 0.0, 1.0, 0.0, 1.0, 1.0], [0.0, 0.0, 1.0, 1.0, 0.0, 1.0f32]] {
        bytes.extend([0; 12]);
        for corner in corners.chunks_exact(2) {
            [corner[0], corner[1], 0.0].iter().for_each(|v| bytes.extend(v.to_le_bytes()));
        }
        bytes.extend([0; 2]);
    }
    bytes
}

#[test]
fn messages_come_in_the_order_of_the_nodes() {
    let broken =
        |i: usize| format!("mtllib {i}.mtl\n{TRIANGLE}f 1 2 {}\n", if i.is_multiple_of(3) { 9 } else { 3 });
    let library = "newmtl a\nKd x\nbogus 1\n";
    let text = |run: &Run| {
        let place = |d: &Diagnostic| {
            run.sources.locate(d.span).map(|l| format!("{}:{}:{}", l.name, l.line, l.column))
        };
        run.out.iter().map(|d| format!("{} {:?} {}", d.code, place(d), d.message)).collect::<Vec<_>>()
    };
    let run = || {
        let mut run = Run::new(&[], Vec::new());
        for i in 0..24 {
            let long =
                format!("{}{}", broken(i), "# more\n".repeat(if i.is_multiple_of(5) { 200_000 } else { 1 }));
            fs::write(run.folder.path().join(format!("{i}.obj")), long).expect("written");
            fs::write(run.folder.path().join(format!("{i}.mtl")), library).expect("written");
            run.scene.add(mesh(&format!("m{i}"), &format!("{i}.obj")));
            run.scene.add(mesh(&format!("missing{i}"), &format!("none{i}.obj")));
        }
        run.load();
        run
    };
    let first = text(&run());
    // Those of a file and its library are together, and files come in the order of the nodes.
    let number = |line: &String| {
        let name = line.split(&['"', '`'][..]).nth(1).expect("a name").trim_start_matches("none");
        name.split('.').next().and_then(|n| n.parse::<u32>().ok()).expect("a number")
    };
    assert!(first.len() == 64 && first.iter().map(number).is_sorted(), "{first:#?}");
    for _ in 0..3 {
        assert_eq!(text(&run()), first);
    }
}

#[test]
fn files_of_the_same_bytes_are_decoded_once() {
    let mut run = Run::new(&[], Vec::new());
    let (stl, obj) = (stl(), format!("{TRIANGLE}f 1 2 3\n"));
    fs::create_dir(run.folder.path().join("sub")).expect("made");
    let mut other = stl.clone();
    other[90] = 1;
    let files: [(&str, &[u8]); 7] = [
        ("a.stl", &stl),
        ("b.stl", &stl),
        ("c.stl", &other),
        ("a.obj", obj.as_bytes()),
        ("b.obj", obj.as_bytes()),
        ("sub/c.obj", obj.as_bytes()),
        ("u.ppm", b"P3\n2 1\n255\n255 0 0 0 0 255\n"),
    ];
    for (name, bytes) in files {
        fs::write(run.folder.path().join(name), bytes).expect("written");
    }
    for name in ["a.stl", "b.stl", "c.stl", "a.obj", "b.obj", "sub/c.obj"] {
        run.scene.add(mesh(name, name));
    }
    for name in ["t.ppm", "u.ppm"] {
        run.scene.add(Node::new(Role::Texture, "image", name).with("file", name));
    }
    run.load();
    assert!(run.out.is_empty(), "{:?}", run.out);
    let read = |name: &str| run.assets.mesh(run.shape(name)).expect("read").clone();
    let same = |a: &str, b: &str| Arc::ptr_eq(&read(a).mesh, &read(b).mesh);
    assert!(same("a.stl", "b.stl") && same("a.obj", "b.obj"));
    assert!(!same("a.stl", "c.stl") && !same("a.obj", "sub/c.obj"));
    // Each has a material of its own, as if it were the only one.
    let slot = |name: &str| run.scene.node(run.assets.slot_materials(run.shape(name))[0]).name.clone();
    assert_eq!([slot("a.stl"), slot("b.stl")], ["a.stl/default", "b.stl/default"]);
    let image =
        |name: &str| run.assets.image(run.scene.find(Role::Texture, name).expect("there")).expect("read");
    assert!(Arc::ptr_eq(image("t.ppm"), image("u.ppm")));
    let hashes: BTreeMap<NodeId, [u8; 32]> = run.assets.content_hashes().collect();
    assert_eq!(hashes[&run.shape("b.stl")], *blake3::hash(&stl).as_bytes());
    let memory = run.assets.memory();
    assert_eq!((memory.images, memory.triangles), (6, 2 + 2 + 2 + 3));
    assert_eq!(memory.meshes, 2 * (4 * 12 + 2 * 12) + 2 * (3 * 12 + 12));
}

#[test]
fn copies_with_faults_are_told_under_their_own_names() {
    let text = format!("{TRIANGLE}f 1 2 3\nf 1 1\n");
    let nodes = || vec![mesh("one", "a.obj"), mesh("two", "b.obj")];
    let run = Run::new(&[("a.obj", &text), ("b.obj", &text)], nodes());
    let names: Vec<&str> =
        run.out.iter().filter_map(|d| run.sources.locate(d.span)).map(|place| place.name).collect();
    assert_eq!(names, ["a.obj", "b.obj"]);
    let text = format!("mtllib m.mtl\n{TRIANGLE}usemtl a\nf 1 2 3\n");
    let run = Run::new(&[("a.obj", &text), ("b.obj", &text), ("m.mtl", "newmtl a\nKd 1 0 0\n")], nodes());
    assert!(run.out.is_empty());
    assert!(["one/a", "two/a"].iter().all(|name| run.scene.find(Role::Material, name).is_some()));
    let textures = ["a.png", "b.png"].map(|n| Node::new(Role::Texture, "image", n).with("file", n));
    let run = Run::new(&[("a.png", "no image"), ("b.png", "no image")], textures.to_vec());
    let messages: Vec<&str> = run.out.iter().map(|d| d.message.as_str()).collect();
    assert!(messages[0].contains("a.png") && messages[1].contains("b.png"), "{messages:?}");
}

/// Keeps what it hears; refuses from the given question on.
#[derive(Default)]
struct Listener {
    heard: std::sync::Mutex<Vec<String>>,
    asked: std::sync::Mutex<Vec<AssetMemory>>,
    refuses_from: Option<usize>,
}

impl LoadObserver for Listener {
    fn approve(&self, scene: &SceneDescription, memory: &dyn Fn() -> AssetMemory) -> Option<Diagnostic> {
        assert!(!scene.is_empty());
        let mut asked = self.asked.lock().expect("whole");
        asked.push(memory());
        let refused = self.refuses_from.is_some_and(|from| asked.len() > from);
        refused.then(|| Diagnostic::new(Severity::Error, "memory::limit", Span::NONE, "too much"))
    }

    fn on(&self, event: LoadEvent<'_>) {
        let line = match event {
            LoadEvent::Found { files, bytes } => format!("found {files} {bytes}"),
            LoadEvent::Read(file) => format!("{} {} {:?}", file.name, file.bytes, file.content),
        };
        self.heard.lock().expect("whole").push(line);
    }
}

fn observed(run: &mut Run, listener: &Listener) {
    let folders = Folders { root: run.folder.path().to_owned(), asset_roots: Vec::new() };
    let (scene, sources, out) = (&mut run.scene, &mut run.sources, &mut run.out);
    run.assets = Assets::load_observed(scene, &folders, sources, out, listener);
}

const TEXTURED: [(&str, &str); 3] = [
    ("m.obj", "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n"),
    ("m.mtl", "newmtl a\nmap_Kd t.ppm\n"),
    ("copy.ppm", "P3\n2 1\n255\n255 0 0 0 0 9\n"),
];

#[test]
fn an_observer_hears_of_every_file() {
    let mut run = Run::new(&TEXTURED, Vec::new());
    let image = |name: &str, file: &str| Node::new(Role::Texture, "image", name).with("file", file);
    for node in [mesh("m", "m.obj"), image("a", "copy.ppm"), image("b", "m.mtl")] {
        run.scene.add(node);
    }
    let listener = Listener::default();
    observed(&mut run, &listener);
    let mut heard = listener.heard.into_inner().expect("whole");
    heard.sort();
    let expected = [
        "copy.ppm 25 Image { size: [2, 1] }",
        "found 1 27",
        "found 3 101",
        "m.mtl 22 Fault",
        "m.obj 54 Mesh { triangles: 1 }",
        "t.ppm 27 Image { size: [2, 1] }",
    ];
    assert_eq!(heard, expected);
    let asked = listener.asked.into_inner().expect("whole");
    let memory = run.assets.memory();
    assert_eq!(asked.len(), 2);
    assert_eq!([asked[0].images, asked[1].images, memory.images], [6, 12, 12]);
    assert!(asked.iter().all(|m| m.triangles == 1 && m.decoding > 0), "{asked:?}");
    assert_eq!((asked[1].meshes, asked[1].shapes), (memory.meshes, memory.shapes));
}

#[test]
fn an_observer_may_forbid_to_decode() {
    for refuses_from in [0, 1] {
        let mut run = Run::new(&TEXTURED, Vec::new());
        run.scene.add(mesh("m", "m.obj"));
        run.scene.add(mesh("n", "none.obj"));
        let listener = Listener { refuses_from: Some(refuses_from), ..Listener::default() };
        observed(&mut run, &listener);
        assert_eq!(run.codes(), ["asset::missing", "memory::limit"]);
        assert!(run.assets.mesh(run.shape("m")).is_none());
        let heard = listener.heard.into_inner().expect("whole");
        assert_eq!(heard.len(), 2 * refuses_from, "{heard:?}");
    }
}
