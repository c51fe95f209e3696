//! The window's camera: the course's, for any scene.
//!
//! The view matrix is T(x, y, z) · T(0, 0, −zoom) · R, where R is the trackball's rotation. In the course the
//! rotation is about the world's origin and a unit of pan or zoom is a metre. In general scenes the rotation
//! is about a pivot (what the scene's camera looks at), pan and zoom are in units of [`CourseCamera::scale`],
//! and the scene's camera gives the orientation before the first turn: the start is the scene's own view with
//! the course's numbers (zoom 3.0, z −3.1, total 6.1), and in the course's scenes pivot, scale and orientation
//! are the origin, 1 and the identity.
//!
//! Eye space is right-handed: x to the right, y up, looking along −z.

use crate::trackball::{Turn, window_point};
use penombre_math::{Bounds3, DMat3, DVec3, Vec2, float};

/// Zoom at the start.
pub const START_ZOOM: f64 = 3.0;
/// Shift along the view at the start.
pub const START_Z: f64 = -3.1;
/// Pixels of a drag per unit of pan and zoom, whatever the size of the window.
const PIXELS_PER_UNIT: f64 = 480.0;
/// A step of the wheel changes the distance by this power of two.
const WHEEL_OCTAVES: f32 = 0.15;
/// What lies in the near plane to the last bit counts as in front of it, as for the ray tracer; relative to the
/// depth.
const NEAR_SLACK: f64 = 1e-5;
/// Near plane of rasterisers, in parts of the distance, where the camera has none: perspective depth needs one.
const LEAST_NEAR: f64 = 1e-3;
/// Part of the picture that [`CourseCamera::frame`] leaves free.
const FRAME_MARGIN: f64 = 1.05;

/// How depth becomes size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lens {
    /// A pinhole camera.
    Perspective {
        /// Field of view from the lower to the upper edge, degrees.
        fov: f64,
    },
    /// Parallel rays.
    Orthographic {
        /// Height of the view, metres.
        height: f64,
    },
}

/// A camera as scene files have it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LookAt {
    /// The eye, metres.
    pub position: DVec3,
    /// A point in the middle of the image.
    pub target: DVec3,
    /// A direction that points up in the image.
    pub up: DVec3,
    /// How depth becomes size.
    pub lens: Lens,
    /// Smallest visible depth, metres; 0 or more.
    pub near: f64,
    /// Largest visible depth, metres; may be infinite.
    pub far: f64,
}

/// A mouse button of the course's bindings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Button {
    /// Turns.
    Left,
    /// Zooms: down is away.
    Middle,
    /// Pans.
    Right,
}

/// Views along an axis, with the middle of the picture kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AxisView {
    /// From +z, y up.
    Front,
    /// From +x, y up.
    Right,
    /// From +y, −z up.
    Top,
}

/// The camera of the course with its mouse, for any scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CourseCamera {
    turn: Turn,
    /// World to eye before any turn.
    base: DMat3,
    /// Pan and shift along the view, in units of `scale`.
    pan: DVec3,
    zoom: f64,
    pivot: DVec3,
    scale: f64,
    lens: Lens,
    near: f64,
    far: f64,
}

impl CourseCamera {
    /// The start in the view of a scene's camera. The pivot is its target, or, if that lies outside of `bounds` (a
    /// target that only gives a direction), the point of the view's axis that is nearest to the middle of the
    /// scene. The scale makes the distance to the pivot 6.1 units.
    pub fn of_look_at(look: &LookAt, bounds: &Bounds3) -> Self {
        let forward = (look.target - look.position).normalize_or(DVec3::NEG_Z);
        let right = forward.cross(look.up).normalize_or(forward.any_orthonormal_vector());
        let up = right.cross(forward);
        let pivot = pivot(look, forward, bounds);
        let distance = (pivot - look.position).length();
        Self {
            turn: Turn::default(),
            base: DMat3::from_cols(right, up, -forward).transpose(),
            pan: DVec3::new(0.0, 0.0, START_Z),
            zoom: START_ZOOM,
            pivot,
            scale: distance / (START_ZOOM - START_Z),
            lens: look.lens,
            near: look.near,
            far: look.far,
        }
    }

    /// One movement of the mouse with a button held. `from`, `to`, `window`: pixels, y down.
    pub fn drag(&mut self, button: Button, from: Vec2, to: Vec2, window: Vec2) {
        let by = (to - from).as_dvec2() / PIXELS_PER_UNIT;
        if !by.is_finite() {
            return;
        }
        match button {
            Button::Left => {
                let drag = Turn::of_drag(window_point(from, window), window_point(to, window));
                self.turn = self.turn.then(drag);
            }
            Button::Right => {
                self.pan.x += by.x;
                self.pan.y -= by.y;
            }
            Button::Middle => self.move_away(by.y),
        }
    }

    /// Turns of the wheel; positive (away from the hand) is nearer. The distance never reaches 0.
    pub fn wheel(&mut self, steps: f32) {
        if steps.is_finite() {
            let factor = f64::from(float::exp2(-WHEEL_OCTAVES * steps.clamp(-20.0, 20.0)));
            self.move_away((self.zoom - self.pan.z) * (factor - 1.0));
        }
    }

    fn move_away(&mut self, units: f64) {
        let before = self.zoom - self.pan.z;
        self.zoom += units;
        // Parallel rays show no distance: the height of the view changes in its place.
        if let Lens::Orthographic { height } = &mut self.lens {
            let ratio = (before + units) / before;
            if ratio > 0.0 && ratio.is_finite() {
                *height *= ratio;
            }
        }
    }

    /// Moves so that all of `bounds` is in view, keeping the direction; the pivot becomes the middle of the box.
    /// `aspect`: width of the picture by its height. Nothing happens for an empty box.
    pub fn frame(&mut self, bounds: &Bounds3, aspect: f64) {
        let radius = f64::from(bounds.size().length()) * 0.5;
        if bounds.is_empty() || !bounds.is_finite() || radius <= 0.0 {
            return;
        }
        let narrow = aspect.clamp(0.01, 1.0);
        let distance = match &mut self.lens {
            Lens::Perspective { fov } => {
                let tangent = float::tan_degrees(*fov * 0.5) * narrow;
                // The sine of half the narrower field of view.
                radius * FRAME_MARGIN * (1.0 + tangent * tangent).sqrt() / tangent
            }
            Lens::Orthographic { height } => {
                *height = 2.0 * radius * FRAME_MARGIN / narrow;
                3.0 * radius
            }
        };
        // What the near plane cuts away would not be in view.
        let distance = distance.max(self.near + radius);
        self.pivot = bounds.center().as_dvec3();
        (self.pan, self.zoom) = (DVec3::new(0.0, 0.0, START_Z), START_ZOOM);
        self.scale = distance / (START_ZOOM - START_Z);
    }

    /// Looks along an axis at the pivot, from the same distance.
    pub fn look_along(&mut self, view: AxisView) {
        let (right, up, back) = match view {
            AxisView::Front => (DVec3::X, DVec3::Y, DVec3::Z),
            AxisView::Right => (DVec3::NEG_Z, DVec3::Y, DVec3::X),
            AxisView::Top => (DVec3::X, DVec3::NEG_Z, DVec3::Y),
        };
        self.turn = Turn::default();
        self.base = DMat3::from_cols(right, up, back).transpose();
        (self.pan.x, self.pan.y) = (0.0, 0.0);
    }

    /// World to eye, the turning part.
    pub fn rotation(&self) -> DMat3 {
        self.turn.rotation() * self.base
    }

    /// The trackball's turns since the start.
    pub fn turn(&self) -> Turn {
        self.turn
    }

    /// Pan (x, y) and shift along the view (z), in units of [`CourseCamera::scale`].
    pub fn pan(&self) -> DVec3 {
        self.pan
    }

    /// Zoom, in units of [`CourseCamera::scale`].
    pub fn zoom(&self) -> f64 {
        self.zoom
    }

    /// Metres per unit of pan and zoom; 1 in the course's scenes.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// Depth of the pivot, metres; negative once the zoom has gone through it.
    pub fn distance(&self) -> f64 {
        (self.zoom - self.pan.z) * self.scale
    }

    /// World to eye, the shift after the turn.
    fn translation(&self) -> DVec3 {
        let shift = (self.pan - DVec3::new(0.0, 0.0, self.zoom)) * self.scale;
        shift - self.rotation() * self.pivot
    }

    /// The same view as scene files describe it.
    pub fn look_at(&self) -> LookAt {
        let to_world = self.rotation().transpose();
        let position = to_world * -self.translation();
        let (up, forward) = (to_world.y_axis, -to_world.z_axis);
        // Any depth before the eye serves; the pivot's is the natural one.
        let depth = self.distance().max(self.scale);
        LookAt {
            position,
            target: position + forward * depth,
            up,
            lens: self.lens,
            near: self.near,
            far: self.far,
        }
    }

    /// World to eye, columns first, for `matrix * column vector`.
    pub fn view_matrix(&self) -> [[f32; 4]; 4] {
        let (r, t) = (self.rotation(), self.translation().as_vec3());
        let column = |c: DVec3| c.as_vec3().extend(0.0).to_array();
        [column(r.x_axis), column(r.y_axis), column(r.z_axis), t.extend(1.0).to_array()]
    }

    /// Eye to clip space, columns first, with the depth range 0 (near plane) to 1 (far plane) of wgpu, Vulkan, Metal
    /// and Direct3D; not OpenGL's −1 to 1. `aspect`: width of the picture by its height.
    pub fn projection_matrix(&self, aspect: f64) -> [[f32; 4]; 4] {
        let planes = self.planes();
        let ((x, y), depth, perspective) = match self.lens {
            Lens::Perspective { fov } => {
                let y = 1.0 / float::tan_degrees(fov * 0.5);
                let scale =
                    if planes.far.is_finite() { planes.far / (planes.near - planes.far) } else { -1.0 };
                ((y / aspect, y), [scale, scale * planes.near], true)
            }
            Lens::Orthographic { height } => {
                let scale = 1.0 / (planes.near - planes.far);
                ((2.0 / (height * aspect), 2.0 / height), [scale, scale * planes.near], false)
            }
        };
        let (w_of_z, w) = if perspective { (-1.0, 0.0) } else { (0.0, 1.0) };
        [
            [x as f32, 0.0, 0.0, 0.0],
            [0.0, y as f32, 0.0, 0.0],
            [0.0, 0.0, depth[0] as f32, w_of_z],
            [0.0, 0.0, depth[1] as f32, w],
        ]
    }

    /// The depths between which a rasteriser draws. As for the ray tracer, a surface that lies in the near plane to
    /// the last bit is out of sight. Where the scene's camera has no near plane, perspective gets one close to the
    /// eye, and parallel rays get a far plane.
    pub fn planes(&self) -> Planes {
        let near = self.near * (1.0 + NEAR_SLACK);
        match self.lens {
            Lens::Perspective { .. } if near == 0.0 => {
                Planes { near: LEAST_NEAR * self.distance().abs().max(self.scale), far: self.far }
            }
            Lens::Orthographic { .. } if self.far.is_infinite() => {
                Planes { near, far: near + 1e4 * self.distance().abs().max(self.scale) }
            }
            _ => Planes { near, far: self.far },
        }
    }

    /// How depth becomes size.
    pub fn lens(&self) -> Lens {
        self.lens
    }
}

/// Depths along the viewing direction, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Planes {
    /// The smallest visible one.
    pub near: f64,
    /// The largest visible one; may be infinite for perspective.
    pub far: f64,
}

/// What the camera turns about.
fn pivot(look: &LookAt, forward: DVec3, bounds: &Bounds3) -> DVec3 {
    let slack = bounds.size() * 0.1;
    let inside = |p: DVec3| {
        let p = p.as_vec3();
        p.cmpge(bounds.min - slack).all() && p.cmple(bounds.max + slack).all()
    };
    if bounds.is_empty() || !bounds.is_finite() || inside(look.target) {
        return look.target;
    }
    let depth = (bounds.center().as_dvec3() - look.position).dot(forward);
    if depth > 0.0 { look.position + forward * depth } else { look.target }
}

#[cfg(test)]
mod tests;
