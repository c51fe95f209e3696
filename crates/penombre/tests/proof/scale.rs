//! A scene of another size gives the same picture, if the intensities of points grow with the square of its lengths.

use super::common::{Subject, by_size};
use penombre_lab::sidak;

/// Matt, metal and glass, lit by a quad, a point, a spot and a sphere; lengths times `s`.
fn scene(s: f64) -> Subject {
    let v = |x: f64, y: f64, z: f64| format!("[{:e}, {:e}, {:e}]", x * s, y * s, z * s);
    let point = 4.0 * s * s;
    let parts = [
        "[render]\nintegrator = \"path\"\nsize = [32, 32]\nmax_depth = 8\n".to_owned(),
        format!("[camera.main]\ntype = \"perspective\"\nposition = {}\ntarget = {}\nfov = 45\n", v(0.0, 1.5, 4.0), v(0.0, 0.4, 0.0)),
        "[material.matt]\ntype = \"diffuse\"\ncolor = [0.7, 0.5, 0.3]\n[material.clear]\ntype = \"glass\"\nior = 1.5\n\
         [material.rough]\ntype = \"metal\"\nmetal = \"gold\"\nalpha = 0.3\n"
            .to_owned(),
        format!("[shape.floor]\ntype = \"quad\"\norigin = {}\nsides = [{}, {}]\nmaterial = \"matt\"\n", v(-4.0, 0.0, 4.0), v(8.0, 0.0, 0.0), v(0.0, 0.0, -8.0)),
        format!("[shape.clear]\ntype = \"sphere\"\ncenter = {}\nradius = {:e}\nmaterial = \"clear\"\n", v(-0.7, 0.6, 0.0), 0.5 * s),
        format!("[shape.rough]\ntype = \"sphere\"\ncenter = {}\nradius = {:e}\nmaterial = \"rough\"\n", v(0.7, 0.5, 0.0), 0.5 * s),
        format!("[shape.tent]\ntype = \"mesh\"\npositions = [{}, {}, {}]\nfaces = [[0, 1, 2]]\nmaterial = \"matt\"\n", v(-2.0, 0.0, -1.0), v(0.0, 0.0, -2.0), v(-1.0, 1.5, -1.5)),
        format!("[light.quad]\ntype = \"quad\"\norigin = {}\nsides = [{}, {}]\nradiance = [6, 6, 6]\n", v(-0.5, 2.5, -0.5), v(1.0, 0.0, 0.0), v(0.0, 0.0, 1.0)),
        format!("[light.point]\ntype = \"point\"\nposition = {}\nintensity = [{point:e}, {point:e}, {point:e}]\n", v(-2.0, 2.0, 1.0)),
        format!("[light.spot]\ntype = \"spot\"\nposition = {}\ntarget = {}\nangle = 20\nintensity = [{point:e}, {point:e}, {point:e}]\n", v(2.0, 2.0, 1.0), v(0.0, 0.0, 0.0)),
        format!("[light.bulb]\ntype = \"sphere\"\ncenter = {}\nradius = {:e}\nradiance = [8, 8, 8]\n", v(1.5, 1.2, -0.8), 0.2 * s),
    ];
    Subject::new(&parts.concat())
}

#[test]
fn the_size_of_a_scene_does_not_matter() {
    let spp = by_size(16, 256);
    let blocks = |s: f64| scene(s).with("render", "spp", spp).blocks(8, 6);
    let expected = blocks(1.0);
    for s in [1e-6, 1e-3, 1e3, 1e6] {
        let d = blocks(s).difference(&expected);
        println!(
            "{s:e}: whole {:+.4} %, worst block {:+.3} %",
            100.0 * d.whole_relative,
            100.0 * d.worst_relative
        );
        assert!(d.p_value() > sidak(0.01, 4 * d.tests), "{s:e}: {d:?}");
        assert!(d.whole_relative.abs() < 0.01, "{s:e}: {d:?}");
    }
}
