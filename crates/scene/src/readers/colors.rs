//! Colours of mesh files: display colours, made linear.

use penombre_math::color::srgb_decode;

/// The range of the colours of a file, seen from all of them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct ColorScale {
    seen: bool,
    fraction: bool,
    largest: f32,
}

impl ColorScale {
    /// Looks at a colour. `whole`: its numbers were written without a point.
    pub fn see(&mut self, color: [f32; 3], whole: bool) {
        self.seen = true;
        self.fraction |= !whole;
        self.largest = color.into_iter().fold(self.largest, f32::max);
    }

    /// True if there was a colour.
    pub fn is_used(self) -> bool {
        self.seen
    }

    /// True if the colours go to 255: some value is above 1 and none has a point.
    pub fn is_bytes(self) -> bool {
        self.largest > 1.0 && !self.fraction
    }
}

/// A display colour (sRGB) as linear Rec. 709. What is not finite becomes white, which changes no material; values
/// are limited to what a display has.
pub(super) fn linear(color: [f32; 3], scale: ColorScale) -> [f32; 3] {
    if !color.iter().all(|c| c.is_finite()) {
        return [1.0; 3];
    }
    let unit = if scale.is_bytes() { 255.0 } else { 1.0 };
    color.map(|c| srgb_decode((c / unit).clamp(0.0, 1.0)))
}
