//! The choice among emitters, lights at infinity, what scenes say of light.

use super::super::{Choice, halve};
use super::*;
use crate::testing::builtin;

#[test]
fn one_light_is_chosen_for_certain_and_none_if_none_is_sampled() {
    assert!(matches!(Choice::new(&[]), Choice::None));
    assert!(matches!(Choice::new(&[0.0, 0.0]), Choice::None));
    assert!(matches!(Choice::new(&[0.0, 3.0, 0.0]), Choice::Only(1)));
    let both = Choice::new(&[1.0, 3.0]);
    let shares = [0, 1, 2].map(|i| both.probability(i));
    assert!(
        (shares[0] - 0.25).abs() < 1e-6 && shares[0] + shares[1] == 1.0 && shares[2] == 0.0,
        "{shares:?}"
    );
    let only = Choice::new(&[0.0, 3.0]);
    assert_eq!([0, 1, 2].map(|i| only.probability(i)), [0.0, 1.0, 0.0]);
    assert_eq!(only.sample(0.99), Some((1, 1.0)));
}

#[test]
fn lights_at_infinity_leave_half_to_the_others() {
    let mut powers = [8.0, 1.0, 1.0, 8.0];
    halve(&mut powers, &[0, 3]);
    assert_eq!(powers, [1.0, 1.0, 1.0, 1.0]);
    let mut weak = [0.5, 3.0];
    halve(&mut weak, &[0]);
    assert_eq!(weak, [0.5, 3.0]);
    let mut alone = [8.0, 0.0];
    halve(&mut alone, &[0]);
    assert_eq!(alone, [8.0, 0.0]);
}

#[test]
fn constant_light_from_infinity_is_left_to_scattered_rays() {
    let sky = || light("constant", "sky").with("radiance", [1.0, 2.0, 3.0]);
    let alone = scene([sky()]);
    assert_eq!(alone.sample_light(Vec3::ZERO, 0.5, Vec2::splat(0.5)), None);
    let found: Vec<_> = alone.escaped(Vec3::Y).collect();
    assert_eq!(found.len(), 1);
    assert_eq!((found[0].radiance.to_rgb(), found[0].pdf), ([1.0, 2.0, 3.0], 0.0));
    let with_lamp = scene([sky(), light("point", "lamp").with("position", [0.0, 0.0, 2.0])]);
    let sample = with_lamp.sample_light(Vec3::ZERO, 0.99, Vec2::splat(0.5)).unwrap();
    assert_eq!((sample.pdf, sample.is_delta), (1.0, true));
    assert_eq!(scene([light("point", "lamp").with("position", [0.0; 3])]).escaped(Vec3::Y).count(), 0);
}

#[test]
fn a_scene_that_shines_by_its_materials_has_light() {
    let warned = |material: Node, solid: bool| {
        let mut d = SceneDescription::default();
        d.add(material);
        d.add(shape("sphere", "ball", "glow"));
        let mut out = Diagnostics::default();
        Scene::build(&d, &Assets::default(), (1.0, solid), &mut out).unwrap();
        out.iter().any(|d| d.code == "scene::no-light")
    };
    for solid in [false, true] {
        assert!(!warned(glow("glow", [1.0; 3], false), solid));
        assert!(warned(glow("glow", [0.0; 3], false), solid));
    }
}

#[test]
fn shapes_are_taken_over_while_the_surfaces_of_lights_stay() {
    let build = |d: &SceneDescription, previous: Option<&Scene>, solid: bool| {
        let (mut out, assets) = (Diagnostics::default(), Assets::default());
        match previous {
            None => Scene::build(d, &assets, (1.0, solid), &mut out).unwrap(),
            Some(previous) => Scene::update(previous, d, &assets, (1.0, solid), &mut out).unwrap(),
        }
    };
    let cornell = builtin("cornell");
    let lamp = cornell.of_role(Role::Light).next().unwrap().0;
    let changed = |param: &str, value: Value| {
        let mut d = cornell.clone();
        d.node_mut(lamp).set(param, value);
        d
    };
    let first = build(&cornell, None, true);
    let brighter = build(&changed("radiance", [20.0; 3].into()), Some(&first), true);
    assert!(brighter.shares_shapes(&first));
    let up = |scene: &Scene| scene.sample_light(Vec3::ZERO, 0.5, Vec2::splat(0.5)).unwrap().radiance;
    assert_eq!(up(&brighter).to_rgb(), [20.0; 3]);
    let at = seen(&brighter, Vec3::ZERO, Vec3::Y).unwrap();
    assert_eq!(brighter.emitted(&at).to_rgb(), [20.0; 3]);
    assert!(!build(&changed("origin", [-0.5, 1.4, -0.5].into()), Some(&first), true).shares_shapes(&first));
    assert!(!build(&cornell, Some(&first), false).shares_shapes(&first), "its light is no surface there");
    let classic = build(&cornell, None, false);
    assert!(build(&cornell, Some(&classic), false).shares_shapes(&classic));
    assert!(!build(&cornell, Some(&classic), true).shares_shapes(&classic));
}
