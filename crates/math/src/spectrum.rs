//! Radiance and reflectance in four lanes.

use crate::color::luminance;
use glam::Vec4;
use std::ops::{Add, AddAssign, Div, Index, Mul, MulAssign, Neg, Sub};

/// Four lanes of radiance, reflectance or throughput: linear Rec. 709 red, green, blue and an idle fourth
/// lane (held at zero) that a spectral mode will use. Integrators treat all four alike.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spectrum(Vec4);

impl Spectrum {
    /// No light.
    pub const BLACK: Self = Self(Vec4::ZERO);
    /// One in every colour lane.
    pub const WHITE: Self = Self(Vec4::new(1.0, 1.0, 1.0, 0.0));

    /// From linear Rec. 709.
    pub const fn rgb(r: f32, g: f32, b: f32) -> Self {
        Self(Vec4::new(r, g, b, 0.0))
    }

    /// From linear Rec. 709.
    pub const fn from_rgb(rgb: [f32; 3]) -> Self {
        Self::rgb(rgb[0], rgb[1], rgb[2])
    }

    /// The same value in every colour lane.
    pub const fn splat(v: f32) -> Self {
        Self::rgb(v, v, v)
    }

    /// To linear Rec. 709.
    pub fn to_rgb(self) -> [f32; 3] {
        [self.0.x, self.0.y, self.0.z]
    }

    /// True if every lane is zero.
    pub fn is_black(self) -> bool {
        self.0 == Vec4::ZERO
    }

    /// True if no lane is NaN or infinite.
    pub fn is_finite(self) -> bool {
        self.0.is_finite()
    }

    /// The largest lane.
    pub fn max_component(self) -> f32 {
        self.0.max_element()
    }

    /// Relative luminance Y of linear Rec. 709 (ITU-R BT.709).
    pub fn luminance(self) -> f32 {
        luminance(self.to_rgb())
    }

    /// Each colour lane limited to `lo..=hi`.
    pub fn clamp(self, lo: f32, hi: f32) -> Self {
        Self(self.0.clamp(Self::splat(lo).0, Self::splat(hi).0))
    }
}

impl Add for Spectrum {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self(self.0 + o.0)
    }
}
impl AddAssign for Spectrum {
    fn add_assign(&mut self, o: Self) {
        self.0 += o.0;
    }
}
impl Sub for Spectrum {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Self(self.0 - o.0)
    }
}
impl Neg for Spectrum {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0)
    }
}
impl Mul for Spectrum {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        Self(self.0 * o.0)
    }
}
impl MulAssign for Spectrum {
    fn mul_assign(&mut self, o: Self) {
        self.0 *= o.0;
    }
}
impl Mul<f32> for Spectrum {
    type Output = Self;
    fn mul(self, s: f32) -> Self {
        Self(self.0 * s)
    }
}
impl Mul<Spectrum> for f32 {
    type Output = Spectrum;
    fn mul(self, s: Spectrum) -> Spectrum {
        s * self
    }
}
impl Div<f32> for Spectrum {
    type Output = Self;
    fn div(self, s: f32) -> Self {
        Self(self.0 / s)
    }
}
impl Index<usize> for Spectrum {
    type Output = f32;
    fn index(&self, lane: usize) -> &f32 {
        &self.0[lane]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arithmetic_is_by_lane_and_leaves_the_idle_lane_zero() {
        let (a, b) = (Spectrum::rgb(1.0, 2.0, 4.0), Spectrum::rgb(0.5, 0.25, 2.0));
        let mut c = a;
        c += b;
        c *= b;
        for (found, expected) in [
            (a + b, [1.5, 2.25, 6.0]),
            (a - b, [0.5, 1.75, 2.0]),
            (a * b, [0.5, 0.5, 8.0]),
            (a * 2.0, [2.0, 4.0, 8.0]),
            (2.0 * a, [2.0, 4.0, 8.0]),
            (a / 2.0, [0.5, 1.0, 2.0]),
            (-a, [-1.0, -2.0, -4.0]),
            (c, [0.75, 0.5625, 12.0]),
            (Spectrum::from_rgb([3.0, 4.0, 5.0]), [3.0, 4.0, 5.0]),
            (Spectrum::splat(7.0), [7.0; 3]),
            (a.clamp(1.5, 3.0), [1.5, 2.0, 3.0]),
        ] {
            assert_eq!((found.to_rgb(), found[3]), (expected, 0.0));
            assert_eq!([found[0], found[1], found[2]], expected);
        }
    }

    #[test]
    fn predicates_and_measures() {
        assert!(Spectrum::BLACK.is_black() && !Spectrum::rgb(0.0, 0.0, 1e-30).is_black());
        assert!(Spectrum::WHITE.is_finite());
        for odd in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert!((0..3).all(|i| {
                let mut rgb = [0.5; 3];
                rgb[i] = odd;
                !Spectrum::from_rgb(rgb).is_finite()
            }));
        }
        assert_eq!(Spectrum::rgb(0.1, 0.7, 0.3).max_component(), 0.7);
        assert!((Spectrum::WHITE.luminance() - 1.0).abs() < 1e-6);
        assert_eq!(Spectrum::rgb(0.0, 1.0, 0.0).luminance(), 0.7152);
    }
}
