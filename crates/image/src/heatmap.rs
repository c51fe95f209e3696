//! False colours for maps of errors.

use crate::image::Image;
use penombre_math::color::srgb_decode_u8;

/// Anchors of the colour scale in sRGB: black, violet, red, orange, pale yellow. The lightness rises all the way, so it
/// reads in grey and for colour-blind eyes too.
const SCALE: [[u8; 3]; 7] = [
    [0, 0, 4],
    [45, 17, 96],
    [114, 31, 129],
    [183, 55, 121],
    [241, 96, 93],
    [254, 175, 119],
    [252, 253, 191],
];

/// A colour picture of a map's first channel: 0 is black, `top` and above pale yellow, NaN green. The colours are linear
/// light, made for [`ToneCurve::Srgb`](crate::ToneCurve::Srgb).
#[must_use]
pub fn heatmap(map: &Image, top: f32) -> Image {
    let data = map.pixels().flat_map(|pixel| color(pixel[0] / top)).collect();
    Image::from_data(map.width(), map.height(), 3, data).expect("three samples for each pixel")
}

fn color(value: f32) -> [f32; 3] {
    if value.is_nan() {
        return [0.0, 1.0, 0.0];
    }
    let last = SCALE.len() - 1;
    let place = value.clamp(0.0, 1.0) * last as f32;
    let index = (place as usize).min(last - 1);
    let part = place - index as f32;
    std::array::from_fn(|c| {
        let [low, high] = [index, index + 1].map(|i| srgb_decode_u8(SCALE[i][c]));
        low + (high - low) * part
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use penombre_math::color::luminance;

    #[test]
    fn lightness_rises_with_the_value() {
        let map = Image::from_data(101, 1, 1, (0..101).map(|i| i as f32 * 0.03).collect()).unwrap();
        let picture = heatmap(&map, 3.0);
        let light: Vec<f32> = picture.rgb_pixels().map(luminance).collect();
        assert!(light.windows(2).all(|w| w[0] < w[1]), "{light:?}");
    }

    #[test]
    fn ends_and_odd_values() {
        let values = vec![-1.0, 0.0, 2.0, 9.0, f32::INFINITY, f32::NAN];
        let picture = heatmap(&Image::from_data(6, 1, 1, values).unwrap(), 2.0);
        assert_eq!(picture.rgb(0, 0), picture.rgb(1, 0));
        assert_eq!(picture.rgb(2, 0), SCALE[6].map(srgb_decode_u8));
        assert_eq!(picture.rgb(2, 0), picture.rgb(3, 0));
        assert_eq!(picture.rgb(2, 0), picture.rgb(4, 0));
        assert_eq!(picture.rgb(5, 0), [0.0, 1.0, 0.0]);
    }
}
