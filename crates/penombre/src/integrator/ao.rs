//! `ao`: ambient occlusion, the share of the sky that each surface sees.
//!
//! The fraction of directions, weighed by their cosine to the shading normal on the side of the viewer, in which nothing
//! stands within `distance`: the diffuse reflection of a white surface under an even white sky. Grey, from 0 to 1.
//! Directions that point below the true surface count as blocked. Every surface blocks alike, of whatever material,
//! those of lights too; holes and cut-outs let rays pass. Where the camera sees nothing the image is black.
//!
//! ```toml
//! [integrator.ao]
//! distance = 0.5          # metres; without end unless given
//! ```

use super::wavefront::Batched;
use super::{AnyIntegrator, Arrivals, Integrator, PathPlace, Step};
use crate::bsdf::sampling::cosine_hemisphere;
use crate::registry::Context;
use crate::sampler::Dimension;
use crate::scene::Scene;
use penombre_bvh::Ray;
use penombre_math::{Frame, Spectrum};
use penombre_scene::params::Params;
use penombre_scene::{Kind, Node, ParamSpec, Range, Role};

/// Number of the only node of a sample's ray tree.
const ROOT: u32 = 1;

/// Ambient occlusion.
#[derive(Clone, Debug, PartialEq)]
pub struct AmbientOcclusion {
    distance: f32,
}

impl AmbientOcclusion {
    /// Its name in scene files.
    pub const NAME: &'static str = "ao";

    /// The parameters of `[integrator.ao]`.
    pub const SCHEMA: &'static [ParamSpec] = &[ParamSpec::optional(
        "distance",
        Kind::Float(Range::POSITIVE.or_infinite()),
        "What stands farther away blocks nothing; default: everything blocks.",
    )
    .unit("m")];

    /// Decodes the `[integrator.ao]` node, or takes the defaults if there is none.
    pub fn build(context: &mut Context<'_, '_>) -> Box<dyn AnyIntegrator> {
        let default = Node::new(Role::Integrator, Self::NAME, Self::NAME);
        let found = context.description.find(Role::Integrator, Self::NAME);
        let node = found.map_or(&default, |id| context.description.node(id));
        let p: Params = context.decode(node, Self::SCHEMA);
        let distance = p.opt_f32("distance").unwrap_or(f32::INFINITY);
        Box::new(Batched(Self { distance }, Self::NAME))
    }
}

impl Integrator for AmbientOcclusion {
    type Path = ();
    type Memory = ();

    fn start(&self) {}

    fn shade(&self, _: &Scene, arrivals: &Arrivals<'_, ()>, (): &mut (), out: &mut Step<'_, ()>) {
        for index in 0..arrivals.len() {
            let arrival = arrivals.get(index, out);
            let Some(at) = arrival.at else { continue };
            let u = arrival.sampler.get_2d(Dimension::of_node(ROOT, 0));
            let wi = Frame::from_z(at.facing_normal()).to_world(cosine_hemisphere(u.to_array()));
            if wi.dot(at.facing_geometric_normal()) > 0.0 {
                let ray = Ray::new(at.origin_toward(wi), wi, 0.0, self.distance);
                out.add_if_visible(Spectrum::WHITE, |rays| rays.push(ray));
            }
        }
    }

    fn place(&self, (): &()) -> PathPlace {
        PathPlace { depth: 0, node: ROOT, weight: Spectrum::WHITE, origin: "camera" }
    }
}

#[cfg(test)]
mod tests {
    use crate::Plan;
    use crate::render::record;
    use crate::testing::from_toml;
    use penombre_lab::{sidak, z_test};

    /// A camera that looks at one point of the floor at the origin.
    const HEAD: &str = "[render]\nintegrator = \"ao\"\nsize = [1, 1]\nspp = 1\npixel_jitter = false\n\
        sampler = \"independent\"\n[camera.main]\ntype = \"perspective\"\nposition = [0, 0.5, 0.3]\ntarget = [0, 0, 0]\nfov = 1\n";
    const FLOOR: &str =
        "[shape.floor]\ntype = \"quad\"\norigin = [-1e4, 0, -1e4]\nsides = [[0, 0, 2e4], [2e4, 0, 0]]\n";
    /// One metre from the point, √3 m high.
    const WALL: &str = "[shape.wall]\ntype = \"quad\"\norigin = [-1, 0, -1e4]\nsides = [[0, 0, 2e4], [0, 1.7320508075688772, 0]]\n";
    const SAMPLES: u32 = 20_000;

    fn mean(scene: &str) -> f64 {
        let (plan, out) = from_toml(&format!("{HEAD}{scene}"));
        let plan: Plan = plan.unwrap_or_else(|| panic!("{out:?}"));
        let one = |k| record(&plan.scene, &*plan.integrator, &plan.job, [0, 0], k).radiance.to_rgb();
        let sum = (0..SAMPLES).map(one).fold(0.0, |sum, [r, g, b]| {
            assert!(r == g && g == b && (r == 0.0 || r == 1.0));
            sum + f64::from(r)
        });
        sum / f64::from(SAMPLES)
    }

    #[test]
    fn a_plane_sees_the_whole_sky() {
        assert_eq!(mean(FLOOR), 1.0);
    }

    #[test]
    fn inside_a_sphere_there_is_no_sky() {
        let ball = "[shape.ball]\ntype = \"sphere\"\nradius = 2\n";
        assert_eq!(mean(ball), 0.0);
        assert_eq!(mean(&format!("[integrator.ao]\ndistance = 1e-3\n{ball}")), 1.0);
    }

    #[test]
    fn nothing_is_black() {
        assert_eq!(mean("[shape.ball]\ntype = \"sphere\"\ncenter = [0, 9, 0]\n"), 0.0);
    }

    /// The form factor of an endless strip from φ₁ to φ₂ off the normal is (sin φ₂ − sin φ₁)/2: a wall of height h at
    /// distance d takes (1 − d/√(d² + h²))/2 = 1/4.
    #[test]
    fn a_wall_takes_its_form_factor() {
        let close = |scene: &str| {
            let test = z_test(mean(scene), 0.25 * 0.75 / f64::from(SAMPLES), 0.75);
            assert!(test.p_value > sidak(0.01, 3), "{test:?}");
        };
        close(&format!("{FLOOR}{WALL}"));
        // Also what shines blocks, and glass.
        let lamp = WALL.replace("[shape.wall]", "[light.wall]");
        close(&format!("{FLOOR}{lamp}"));
        close(&format!("{FLOOR}{WALL}material = \"glass\"\n[material.glass]\ntype = \"glass\"\n"));
        assert_eq!(mean(&format!("[integrator.ao]\ndistance = 0.999\n{FLOOR}{WALL}")), 1.0);
    }
}
