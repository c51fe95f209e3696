//! What the shapes share: parameters, roundings, similarity transforms.

use crate::registry::Context;
use penombre_bvh::Ray;
use penombre_math::rounding::UNIT_ROUNDOFF;
use penombre_math::{DAffine3, DVec3, Vec3};
use penombre_scene::params::Params;
use penombre_scene::{Kind, ParamDefault, ParamSpec, Range, Role};

/// Every shape's material.
pub const MATERIAL: ParamSpec =
    ParamSpec::optional("material", Kind::Reference(Role::Material), "Name of its material.");

/// The centre of a round shape.
pub const CENTER: ParamSpec =
    ParamSpec::with_default("center", Kind::Vec3, ParamDefault::Vec3([0.0; 3]), "The point in its middle.")
        .unit("m");

/// The radius of a round shape.
pub const RADIUS: ParamSpec = ParamSpec::with_default(
    "radius",
    Kind::Float(Range::POSITIVE),
    ParamDefault::Float(1.0),
    "Distance from the centre to the edge.",
)
.unit("m");

/// Every shape's transform.
pub const TRANSFORM: ParamSpec = ParamSpec::optional(
    "transform",
    Kind::Transform,
    "Where it stands: a list of steps, applied in this order.",
);

/// Double-precision roundings, as a share of the largest number that they touch, in a shape's own arithmetic and
/// in the kernels' test of it: 2⁻⁵³ each, 16 of them.
const DOUBLE_ROUNDINGS: f64 = 1.0 / (1u64 << 49) as f64;

/// A point that was computed in double precision, rounded, with the bound per axis on how far that takes it off the
/// surface: one rounding, twice that for good measure, and those of the double-precision arithmetic with numbers up
/// to `reach`.
pub fn rounded(p: DVec3, reach: f64) -> (Vec3, Vec3) {
    let single = p.as_vec3();
    let arithmetic = (reach * DOUBLE_ROUNDINGS) as f32 + f32::MIN_POSITIVE;
    (single, single.abs() * (2.0 * UNIT_ROUNDOFF) + Vec3::splat(arithmetic))
}

/// The point of a plane at a hit, the better of two ways: `own`, from the surface's own coordinates, whose rounding
/// moves it aside by a share of the surface's `extent`; or where the ray meets the plane in double precision,
/// which moves it aside by a share of the distance. `anchor` is a point of the plane, `normal` its unit normal.
pub fn on_plane(ray: &Ray, t: f32, anchor: DVec3, normal: DVec3, extent: f64, own: DVec3) -> DVec3 {
    let (origin, dir) = (ray.origin.as_dvec3(), ray.dir.as_dvec3());
    let t = f64::from(t);
    if extent * extent <= dir.length_squared() * (t * t) {
        return own;
    }
    // Not the kernels' parameter: that is rounded, and a triangle's as coarsely as the triangle is large.
    let exact = (anchor - origin).dot(normal) / dir.dot(normal);
    let p = origin + dir * exact;
    if p.distance_squared(own) <= extent * extent { p } else { own }
}

/// The factor by which the map scales all lengths, or `None` if it does not scale them alike.
pub fn uniform_scale(map: &DAffine3) -> Option<f64> {
    let m = map.matrix3;
    let lengths = [m.x_axis.length(), m.y_axis.length(), m.z_axis.length()];
    let scale = lengths[0];
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * scale;
    let alike = near(lengths[0], lengths[1]) && near(lengths[0], lengths[2]);
    let dots = [m.x_axis.dot(m.y_axis), m.x_axis.dot(m.z_axis), m.y_axis.dot(m.z_axis)];
    let square = dots.iter().all(|d| d.abs() <= 1e-9 * scale * scale);
    (alike && square).then_some(scale)
}

/// A point of the parameters in double precision under the shape's transform, rounded to single precision.
/// Reports a fault and returns `None` if it overflows.
pub fn place(map: &DAffine3, p: Vec3, params: &Params, context: &mut Context<'_, '_>) -> Option<Vec3> {
    let placed = map.transform_point3(p.as_dvec3()).as_vec3();
    if placed.is_finite() {
        return Some(placed);
    }
    too_far(params, context);
    None
}

/// A radius under a map that scales all lengths by `scale`. Reports a fault and returns `None` if it overflows or
/// vanishes.
pub fn scaled_radius(radius: f32, scale: f64, params: &Params, context: &mut Context<'_, '_>) -> Option<f32> {
    let scaled = (f64::from(radius) * scale) as f32;
    if scaled.is_finite() && scaled > 0.0 {
        return Some(scaled);
    }
    too_far(params, context);
    None
}

/// Reports that the transform moves the shape beyond single precision.
pub fn too_far(params: &Params, context: &mut Context<'_, '_>) {
    let node = context.description.node(context.node);
    let message =
        format!("the transform moves `{}` beyond the largest number of single precision", node.path());
    context.out.error("scene::out-of-range", params.span("transform"), message).help =
        "coordinates must stay below 3.4e38".to_owned();
}
