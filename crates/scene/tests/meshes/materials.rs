//! What becomes of materials of MTL files.

use crate::common::{Read, counts};
use crate::obj::{numbers, obj_with};
use penombre_scene::{MeshFile, Node, ValueKind};

const TRIANGLE: &str = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n";

fn read(library: &str) -> Read {
    let images = ["a.png", "b.png", "c.png", "d.png", "e.png", "f.png"].map(|name| (name, ""));
    let library = format!("newmtl m\n{library}\n");
    obj_with(TRIANGLE, &[[("a.mtl", library.as_str())].as_slice(), &images].concat())
}

/// The mesh file of a library without fault.
fn file(library: &str) -> MeshFile {
    let read = read(library);
    assert_eq!(counts(&read.out), [0; 3], "{library}: {:?}", read.messages());
    read.file().clone()
}

fn types(file: &MeshFile) -> Vec<(&str, &str)> {
    file.materials.iter().map(|m| (m.name.as_str(), m.type_name.as_str())).collect()
}

fn words(node: &Node, name: &str) -> String {
    match &node.param(name).unwrap().value.kind {
        ValueKind::String(text) => text.clone(),
        ValueKind::Table(table) => match &table[0].value.kind {
            ValueKind::String(text) => format!("{}={text}", table[0].name),
            other => panic!("{other:?}"),
        },
        other => panic!("{other:?}"),
    }
}

#[test]
fn plain_materials_are_phong_ones() {
    for library in [
        "Kd 1 0 0\nKs 0 1 0\nNs 30",
        "Ka 1 1 1\nKd 1 0 0\nKs 0 1 0\nNs 30\nNi 1.5\nd 1\nTr 0\nTf 1 1 1\nKe 0 0 0\nillum 2\nPm 0\nPs 0\naniso 0",
        "Kd 1 0 0\nKs 0 1 0\nNs 30\nillum 7\nNi 1.5\nd 1",
        "Kd 1 0 0\nKs 0 1 0\nNs 30\nillum 4\nNi 1\nTf 1 1 1",
    ] {
        let file = file(library);
        assert_eq!(types(&file), [("mesh/m", "phong")], "{library}");
        let names: Vec<&str> = file.materials[0].params.iter().map(|p| p.name.as_str()).collect();
        assert_eq!(names, ["diffuse", "specular", "shininess", "ambient"], "{library}");
        assert_eq!(numbers(&file.materials[0], "specular"), [0.0, 1.0, 0.0]);
    }
}

#[test]
fn transparency_in_two_words() {
    let opacity = |library: &str| numbers(&file(library).materials[0], "opacity")[0];
    assert_eq!(opacity("d 0.25"), 0.25);
    assert_eq!(opacity("Tr 0.25"), 0.75);
    assert_eq!(opacity("Tr 0.75\nd 0.25"), 0.25);
    let read = read("Tr 0.5\nd 0.25");
    assert_eq!(
        read.only(),
        "warning mtl::transparency a.mtl:3:3 `m` has `d 0.25` and `Tr 0.5`, expected `Tr` to be 1 − `d`: `Tr` is not used"
    );
    assert_eq!(numbers(&read.file().materials[0], "opacity"), [0.25]);
}

#[test]
fn faults_of_numbers_are_told() {
    let cases = [
        ("d 0", "warning mtl::transparency a.mtl:2:3 `m` is wholly transparent: its faces are not seen"),
        ("Tr 1", "warning mtl::transparency a.mtl:2:4 `m` is wholly transparent: its faces are not seen"),
        ("d 7", "warning mtl::number a.mtl:2:3 `d` is 7, expected 0 to 1"),
        ("Kd 5 5 5", "warning mtl::number a.mtl:2:4 `Kd` is 5.0, expected numbers from 0 to 1"),
        ("Ks 0 1.5 2", "warning mtl::number a.mtl:2:4 `Ks` is 1.5, expected numbers from 0 to 1"),
        ("Ni 0", "warning mtl::number a.mtl:2:4 `Ni` is 0, expected a number above 0, at most 1000"),
        ("Ni 1e30", "warning mtl::number a.mtl:2:4 `Ni` is 1e30, expected a number above 0, at most 1000"),
        ("illum x", "warning mtl::number a.mtl:2:7 `illum` is `x`, expected a whole number from 0 to 10"),
        ("illum 11", "warning mtl::number a.mtl:2:7 `illum` is `11`, expected a whole number from 0 to 10"),
        ("illum -1", "warning mtl::number a.mtl:2:7 `illum` is `-1`, expected a whole number from 0 to 10"),
        ("illum 2.5", "warning mtl::number a.mtl:2:7 `illum` is `2.5`, expected a whole number from 0 to 10"),
        ("illum", "warning mtl::numbers a.mtl:2:1 `illum` has no number, expected one from 0 to 10"),
        ("Pm", "warning mtl::numbers a.mtl:2:1 `Pm` has no number, expected one from 0 to 1"),
        ("d -halo 0.5", "warning mtl::option a.mtl:2:3 the option `-halo` is not applied by this version"),
        (
            "map_d -imfchan z a.png",
            "warning mtl::option a.mtl:2:7 the option `-imfchan` is not applied by this version",
        ),
        ("map_Ke", "warning mtl::map a.mtl:2:1 `map_Ke` names no file"),
        ("map_d no.png", "warning mtl::image a.mtl:2:7 there is no file `no.png`: the plain opacity is used"),
        (
            "map_Pr a.png",
            "warning mtl::left-out a.mtl:2:8 maps of the roughness are rendered for metal and glass alone, and left out here",
        ),
        (
            "disp a.png\ndisp b.png",
            "warning mtl::left-out a.mtl:2:1 `disp`: displacement maps are not rendered and left out",
        ),
        (
            "Pc 0.5\nPcr 0.1\naniso 0.2",
            "warning mtl::left-out a.mtl:2:1 `Pc`: clear coats and anisotropy are not rendered and left out",
        ),
    ];
    for (library, expected) in cases {
        assert_eq!(read(library).only(), expected, "{library}");
    }
    assert_eq!(numbers(&read("Kd 5 0.5 2").file().materials[0], "diffuse"), [1.0, 0.5, 1.0]);
    // An image may tell where the surface is.
    assert_eq!(types(&file("d 0\nmap_d a.png")), [("mesh/m", "phong")]);
}

#[test]
fn images_for_every_use() {
    let file = file(
        "Ke 2 3 1\nmap_Kd a.png\nmap_Ks -o 0.5 0.25 b.png\nmap_Ke -clamp on c.png\nmap_d d.png\nPm 0.5\nmap_Pr -mm 0.1 0.5 e.png\n\
         map_Pm -imfchan b f.png",
    );
    assert_eq!(types(&file), [("mesh/m", "mix"), ("mesh/m/base", "phong"), ("mesh/m/metal", "metal")]);
    let [mix, base, metal] = &file.materials[..] else { panic!("three") };
    assert_eq!((words(mix, "a"), words(mix, "b")), ("mesh/m/base".to_owned(), "mesh/m/metal".to_owned()));
    for (node, name, texture) in [
        (base, "diffuse", "mesh/m"),
        (base, "ambient", "mesh/m"),
        (metal, "tint", "mesh/m"),
        (base, "specular", "mesh/m/specular"),
        (mix, "emission", "mesh/m/emission"),
        (mix, "opacity", "mesh/m/opacity"),
        (metal, "roughness", "mesh/m/roughness"),
        (mix, "amount", "mesh/m/metal"),
    ] {
        assert_eq!(words(node, name), format!("texture={texture}"));
        let texture = file.textures.iter().find(|t| t.node.name == texture).unwrap();
        let at = file.materials.iter().position(|m| m.name == node.name).unwrap();
        assert!(texture.uses.contains(&(at, name)), "{name}: {:?}", texture.uses);
    }
    assert_eq!(file.textures.iter().map(|t| t.uses.len()).sum::<usize>(), 8);
    let texture = |name: &str| &file.textures.iter().find(|t| t.node.name == name).unwrap().node;
    assert!(texture("mesh/m").params.len() == 1);
    assert_eq!(numbers(texture("mesh/m/specular"), "offset"), [0.5, 0.25]);
    assert_eq!(words(texture("mesh/m/emission"), "wrap"), "clamp");
    assert_eq!(numbers(texture("mesh/m/emission"), "gain"), [3.0]);
    assert_eq!(words(texture("mesh/m/opacity"), "channel"), "mask");
    for name in ["opacity", "roughness", "metal"] {
        assert_eq!(words(texture(&format!("mesh/m/{name}")), "encoding"), "linear");
    }
    assert_eq!(words(texture("mesh/m/metal"), "channel"), "blue");
    let roughness = texture("mesh/m/roughness");
    assert_eq!((numbers(roughness, "base"), numbers(roughness, "gain")), (vec![0.1], vec![0.5]));
}

#[test]
fn transparency_maps_are_inverted() {
    let file = file("map_Tr a.png");
    let texture = &file.textures[0].node;
    assert_eq!((numbers(texture, "base"), numbers(texture, "gain")), (vec![1.0], vec![-1.0]));
    assert_eq!(words(&file.materials[0], "opacity"), "texture=mesh/m/opacity");
}

#[test]
fn physical_numbers_make_metal_and_plastic() {
    let metal = file("Kd 1 0.5 0.25\nPm 1\nPr 0.25\nillum 3");
    assert_eq!(types(&metal), [("mesh/m", "metal")]);
    assert_eq!(numbers(&metal.materials[0], "tint"), [1.0, 0.5, 0.25]);
    assert_eq!(numbers(&metal.materials[0], "roughness"), [0.25]);
    // The width of the highlight of Ns: α² = 2/(Ns + 2), here 1/16, so that α = 1/4 and the roughness is 1/2.
    assert_eq!(numbers(&file("Pm 1\nNs 30").materials[0], "roughness"), [0.5]);
    let plastic = file("Kd 1 0 0\nKs 0.5 0.5 0.5\nPr 0.5\nPm 0\nillum 2");
    assert_eq!(types(&plastic), [("mesh/m", "phong")]);
    let specular = numbers(&plastic.materials[0], "specular");
    assert_eq!((specular, numbers(&plastic.materials[0], "shininess")), (vec![0.04; 3], vec![30.0]));
    assert_eq!(numbers(&file("Pr 0").materials[0], "shininess"), [1e4]);
    let both = file("Pm 0.25\nPr 1\nd 0.5\nKe 1 1 1");
    assert_eq!(types(&both), [("mesh/m", "mix"), ("mesh/m/base", "phong"), ("mesh/m/metal", "metal")]);
    assert_eq!(numbers(&both.materials[0], "amount"), [0.25]);
    assert_eq!(
        (numbers(&both.materials[0], "opacity"), numbers(&both.materials[0], "emission")),
        (vec![0.5], vec![1.0; 3])
    );
}

#[test]
fn reflecting_models_make_mirrors() {
    for model in [3, 5] {
        let whole = file(&format!("Kd 0 0 0\nKs 0.5 0.9 1\nillum {model}"));
        assert_eq!(types(&whole), [("mesh/m", "mirror")]);
        assert_eq!(numbers(&whole.materials[0], "reflectance"), [0.5, 0.9, 1.0]);
        let half = file(&format!("Kd 0.25 0.5 0.75\nKs 0.25 0.5 0.5\nillum {model}"));
        assert_eq!(types(&half), [("mesh/m", "mix"), ("mesh/m/base", "phong"), ("mesh/m/mirror", "mirror")]);
        // (1 − 1/2) of the one and 1/2 of the other are Kd and Ks, as far as a surface can send back light.
        assert_eq!(numbers(&half.materials[0], "amount"), [0.5]);
        assert_eq!(numbers(&half.materials[1], "diffuse"), [0.5, 1.0, 1.0]);
        assert_eq!(numbers(&half.materials[2], "reflectance"), [0.5, 1.0, 1.0]);
        assert_eq!(types(&file(&format!("Kd 1 1 1\nillum {model}"))), [("mesh/m", "phong")]);
    }
}

#[test]
fn refracting_models_make_glass_where_it_is_meant() {
    for model in [4, 6, 7, 9] {
        let clear = file(&format!("Kd 0.1 0.1 0.1\nNi 1.5\nTf 0.9 1 0.9\nd 0.5\nillum {model}"));
        assert_eq!(types(&clear), [("mesh/m", "glass")]);
        assert_eq!(numbers(&clear.materials[0], "ior"), [1.5]);
        assert_eq!(numbers(&clear.materials[0], "transmit"), [0.9, 1.0, 0.9]);
        assert!(clear.materials[0].param("opacity").is_none());
        assert_eq!(types(&file(&format!("Ni 1.5\nd 0\nillum {model}"))), [("mesh/m", "glass")]);
        let half = file(&format!("Kd 1 0 0\nNi 1.33\nd 0.25\nillum {model}"));
        assert_eq!(types(&half), [("mesh/m", "mix"), ("mesh/m/base", "phong"), ("mesh/m/glass", "glass")]);
        assert_eq!(numbers(&half.materials[0], "amount"), [0.75]);
        assert!(half.materials[0].param("opacity").is_none());
        let frosted = file(&format!("Ni 1.5\nTf 1 1 1\nPr 0.5\nillum {model}"));
        assert_eq!(types(&frosted), [("mesh/m", "rough_glass")]);
        assert_eq!(numbers(&frosted.materials[0], "roughness"), [0.5]);
        // Leaves: holes in what is opaque.
        let leaf = file(&format!("Ni 1.5\nmap_d a.png\nd 0.5\nillum {model}"));
        assert_eq!(types(&leaf), [("mesh/m", "phong")]);
    }
    assert_eq!(types(&file("Ni 1.5\nd 0.5\nillum 2")), [("mesh/m", "phong")]);
}

#[test]
fn names_of_parts_and_textures_are_unique() {
    let text = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\nusemtl m/base\nf 1 2 3\nusemtl m/opacity\nf 1 2 3\n";
    let library = "newmtl m\nPm 0.5\nmap_d a.png\nnewmtl m/base\nKd 1 1 1\nnewmtl m/opacity\nmap_Kd a.png\n";
    let read = obj_with(text, &[("a.mtl", library), ("a.png", "")]);
    let file = read.file();
    let names: Vec<&str> = file.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["mesh/m", "mesh/m/base-2", "mesh/m/opacity", "mesh/m/base", "mesh/m/metal"]);
    let textures: Vec<&str> = file.textures.iter().map(|t| t.node.name.as_str()).collect();
    assert_eq!(textures, ["mesh/m/opacity", "mesh/m/opacity-2"]);
    assert_eq!(words(&file.materials[2], "diffuse"), "texture=mesh/m/opacity-2");
}
