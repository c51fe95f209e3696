//! Tubes of light through spheres: how a thin bundle of rays that leaves one point widens on its way.
//!
//! At a sphere the plane of incidence contains the centre, so a chain of bounces off one sphere stays in one plane, and the
//! bundle's widths in that plane and across it do not mix. Source: Coddington's equations (\[Stavroudis1972\], in
//! wavefront curvatures, positive where the bundle widens).

/// Widths per radian and wavefront curvatures, in the plane of incidence and across it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tube {
    /// Metres per radian at the start; negative behind a focus.
    widths: [f32; 2],
    /// Widening per metre and width, 1/m.
    curvatures: [f32; 2],
}

impl Tube {
    /// Of no width.
    pub const ZERO: Self = Self { widths: [0.0; 2], curvatures: [0.0; 2] };

    /// After the first `distance` metres.
    #[inline]
    pub fn start(distance: f32) -> Self {
        Self { widths: [distance; 2], curvatures: [1.0 / distance; 2] }
    }

    /// After `distance` metres more.
    #[inline]
    pub fn advance(self, distance: f32) -> Self {
        let spread = self.curvatures.map(|c| 1.0 + distance * c);
        Self {
            widths: [self.widths[0] * spread[0], self.widths[1] * spread[1]],
            curvatures: [self.curvatures[0] / spread[0], self.curvatures[1] / spread[1]],
        }
    }

    /// Mirrored by the outside of a sphere of that radius; `cos` is that of the angle of incidence.
    #[inline]
    pub fn mirrored(self, cos: f32, radius: f32) -> Self {
        let bend = 2.0 / radius;
        let [tangential, sagittal] = self.curvatures;
        Self { curvatures: [tangential + bend / cos, sagittal + bend * cos], ..self }
    }

    /// Refracted by a sphere of that radius, counted negative from within; `eta` is the index behind the boundary over that
    /// before it, the cosines are those before and behind.
    #[inline]
    pub fn refracted(self, cos: f32, cos_t: f32, eta: f32, radius: f32) -> Self {
        let power = (cos - eta * cos_t) / radius;
        let [tangential, sagittal] = self.curvatures;
        Self {
            widths: [self.widths[0] * (cos_t / cos), self.widths[1]],
            curvatures: [(cos * cos * tangential + power) / (eta * cos_t * cos_t), (sagittal + power) / eta],
        }
    }

    /// Area across the bundle per solid angle at its start, m²/sr.
    #[inline]
    pub fn area(&self) -> f32 {
        (self.widths[0] * self.widths[1]).abs()
    }

    /// Solid angle that the bundle opens up to per solid angle at its start.
    #[inline]
    pub fn solid_angle(&self) -> f32 {
        let [t, s] = [0, 1].map(|i| self.widths[i] * self.curvatures[i]);
        (t * s).abs()
    }
}
