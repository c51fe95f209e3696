//! `direct`: light that surfaces emit, and what reaches them from lights without a detour.
//!
//! The path tracer with paths of two segments: from the camera to a surface, and from there to a light. Each light is sought
//! both from a direction towards it and where the surface scatters by chance, weighed by the power heuristic \[Veach1997\].
//! Mirrors and glass are not followed: they show the lights, an environment among them, and nothing else. `max_depth` 1
//! leaves what surfaces emit. The same bits as `path` with `max_depth = 2` and no parameters.
//!
//! ```toml
//! [render]
//! integrator = "direct"
//! ```

use super::{AnyIntegrator, PathTracer, Worker};
use crate::registry::Context;
use crate::scene::Scene;
use penombre_scene::params::Params;
use penombre_scene::{Node, ParamSpec, Role, SceneDescription};

/// Path segments: to a surface, and on to a light.
const SEGMENTS: u32 = 2;

/// Direct light.
#[derive(Debug)]
pub struct Direct(Box<dyn AnyIntegrator>);

impl Direct {
    /// Its name in scene files.
    pub const NAME: &'static str = "direct";

    /// The parameters of `[integrator.direct]`: none.
    pub const SCHEMA: &'static [ParamSpec] = &[];

    /// Checks the `[integrator.direct]` node, if there is one. `max_depth` limits the path segments further.
    pub fn build(context: &mut Context<'_, '_>, max_depth: u32) -> Box<dyn AnyIntegrator> {
        if let Some(id) = context.description.find(Role::Integrator, Self::NAME) {
            let node: &Node = context.description.node(id);
            let _: Params = context.decode(node, Self::SCHEMA);
        }
        // Without the scene's parameters of `path`.
        let none = SceneDescription::default();
        let mut plain = Context {
            description: &none,
            assets: context.assets,
            out: &mut *context.out,
            node: context.node,
        };
        Box::new(Self(PathTracer::build(&mut plain, max_depth.min(SEGMENTS))))
    }
}

impl AnyIntegrator for Direct {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn worker<'a>(&'a self, scene: &'a Scene) -> Box<dyn Worker + 'a> {
        self.0.worker(scene)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::record;
    use crate::testing::{from_toml, plan, rendered, set, small};
    use penombre_lab::{Moments, t_test};
    use std::f64::consts::PI;

    fn digest(integrator: &str, max_depth: i64) -> String {
        let mut d = small("cornell", 24, 8);
        set(&mut d, Role::Render, "", "integrator", integrator);
        set(&mut d, Role::Render, "", "max_depth", max_depth);
        if integrator == Direct::NAME {
            // Parameters of `path` are none of `direct`.
            set(&mut d, Role::Integrator, "path", "clamp", 1e-3);
            set(&mut d, Role::Integrator, "path", "roulette_depth", 1i64);
        }
        rendered(plan(&d)).image().digest()
    }

    #[test]
    fn the_bits_are_those_of_paths_of_two_segments() {
        assert_eq!(digest("direct", 16), digest("path", 2));
        assert_eq!(digest("direct", 1), digest("path", 1));
        assert_ne!(digest("direct", 2), digest("path", 3));
    }

    /// A floor under a square light of radiance 3 W/(sr·m²) at 2 m, seen at its middle; `more` is added to the scene.
    fn lit(material: &str, more: &str) -> Moments {
        let (plan, out) = from_toml(&format!(
            "[render]\nintegrator = \"direct\"\nsize = [1, 1]\npixel_jitter = false\nsampler = \"independent\"\n\
             [camera.main]\ntype = \"perspective\"\nposition = [0, 1, 3]\ntarget = [0, 0, 0]\nfov = 0.1\n\
             [material.it]\n{material}\n\
             [shape.floor]\ntype = \"quad\"\norigin = [-9, 0, -9]\nsides = [[0, 0, 18], [18, 0, 0]]\nmaterial = \"it\"\n\
             [light.lamp]\ntype = \"quad\"\norigin = [-1, 2, -1]\nsides = [[2, 0, 0], [0, 0, 2]]\nradiance = [3, 3, 3]\n\
             {more}"
        ));
        let plan = plan.unwrap_or_else(|| panic!("{out:?}"));
        let one = |k| record(&plan.scene, &*plan.integrator, &plan.job, [0, 0], k).radiance.to_rgb()[0];
        (0..8192).map(|k| f64::from(one(k))).collect()
    }

    /// Four times the form factor of a parallel rectangle above a corner, half the edge by height a = ½:
    /// F = (1/2π)·2·a/√(1 + a²)·atan(a/√(1 + a²)); the floor reflects ρ·L·4F.
    #[test]
    fn a_square_lamp_gives_its_form_factor() {
        let a = 0.5 / 1.25f64.sqrt();
        let expected = 0.6 * 3.0 * 4.0 * a * a.atan() / PI;
        let found = lit("type = \"diffuse\"\ncolor = [0.6, 0.6, 0.6]", "");
        let test = t_test(&found, expected);
        assert!(test.p_value > 0.01, "{test:?}: {found:?}, expected {expected}");
        assert!(found.variance_of_mean().sqrt() < 0.01 * expected);
    }

    #[test]
    fn mirrors_show_lights_and_nothing_else() {
        let mirror = "type = \"mirror\"";
        let wall = "[shape.wall]\ntype = \"quad\"\norigin = [-9, 0, -2]\nsides = [[18, 0, 0], [0, 9, 0]]";
        let exact = |m: Moments| [m.mean(), m.variance()];
        assert_eq!(exact(lit(mirror, wall)), [0.0; 2]);
        let sky = "[light.sky]\ntype = \"environment\"\nradiance = [0.25, 0.25, 0.25]";
        assert_eq!(exact(lit(mirror, sky)), [0.25, 0.0]);
    }
}
