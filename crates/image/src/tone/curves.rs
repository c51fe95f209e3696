//! The formulas of the tone curves: the colour of the scene in, the light of the display out.
//!
//! Both are linear Rec. 709, but for AgX. Inputs are 0 to [`f32::MAX`]; outputs may lie a little outside of 0…1 and are
//! cut by the caller. In double precision, so that a brighter grey never comes out darker by rounding.

use penombre_math::float;

type Rgb = [f64; 3];

fn product(matrix: &[Rgb; 3], [r, g, b]: Rgb) -> Rgb {
    matrix.map(|row| row[0] * r + row[1] * g + row[2] * b)
}

/// From Rec. 709 to the inset primaries of AgX \[WrenschAgX\].
const AGX_INSET: [Rgb; 3] = [
    [0.842_479_062_253_094, 0.078_433_599_999_999_2, 0.079_223_745_147_764_3],
    [0.042_328_242_261_012_3, 0.878_468_636_469_772, 0.079_166_127_460_543_4],
    [0.042_375_654_905_705_1, 0.078_433_6, 0.879_142_973_793_104],
];

/// The inverse of [`AGX_INSET`] \[WrenschAgX\].
const AGX_OUTSET: [Rgb; 3] = [
    [1.196_879_005_120_17, -0.098_020_881_140_136_8, -0.099_029_744_079_720_5],
    [-0.052_896_851_757_456_2, 1.151_903_129_904_17, -0.098_961_176_844_843_3],
    [-0.052_971_635_514_443_8, -0.098_043_450_117_124_1, 1.151_073_672_641_16],
];

/// Black and white of AgX as powers of two: 10 stops below and 6.5 above a middle grey of 0.18.
const AGX_EV: [f64; 2] = [-12.473_93, 4.026_069];

/// The base look of AgX \[SobotkaAgX\], with the sigmoid as a polynomial of degree 6 \[WrenschAgX\]: no light yet, but
/// values for [`agx_lamp`].
pub fn agx(scene: Rgb) -> Rgb {
    let [low, high] = AGX_EV;
    let encoded = product(&AGX_INSET, scene).map(|c| {
        let stops = f64::from(float::log2(c as f32));
        agx_contrast(((stops - low) / (high - low)).clamp(0.0, 1.0))
    });
    product(&AGX_OUTSET, encoded)
}

/// The light of the display that [`agx`] makes its values for: an exponent of 2.2.
pub fn agx_lamp(value: f32) -> f32 {
    float::pow(value, 2.2)
}

/// The sigmoid of AgX from 0…1 to about 0…1 \[WrenschAgX\]: rises everywhere.
pub fn agx_contrast(x: f64) -> f64 {
    let high = (15.5 * x - 40.14) * x + 31.96;
    (((high * x - 6.868) * x + 0.4298) * x + 0.1191) * x - 0.002_32
}

/// From Rec. 709 to the space of the ACES reference rendering transform \[HillACES\].
const ACES_IN: [Rgb; 3] =
    [[0.597_19, 0.354_58, 0.048_23], [0.076, 0.908_34, 0.015_66], [0.028_4, 0.133_83, 0.837_77]];

/// From the space of the ACES output device transform to Rec. 709 \[HillACES\].
const ACES_OUT: [Rgb; 3] =
    [[1.604_75, -0.531_08, -0.073_67], [-0.102_08, 1.108_13, -0.006_05], [-0.003_27, -0.072_76, 1.076_02]];

/// ACES: Hill's fit of its rendering and output transforms for sRGB displays \[HillACES\].
pub fn aces(scene: Rgb) -> Rgb {
    let fit =
        |v: f64| (v * (v + 0.024_578_6) - 0.000_090_537) / (v * (0.983_729 * v + 0.432_951) + 0.238_081);
    product(&ACES_OUT, product(&ACES_IN, scene).map(fit))
}

/// The tone mapper of the Khronos specification PBR Neutral \[KhronosNeutral2024\], in its symbols.
pub fn pbr_neutral(scene: Rgb) -> Rgb {
    /// Reflectance that coats of index 1.5 add to a base colour.
    const F90: f64 = 0.04;
    /// Where highlights begin to be compressed.
    const KS: f64 = 0.8 - F90;
    /// How fast compressed highlights lose colour.
    const KD: f64 = 0.15;
    let x = scene[0].min(scene[1]).min(scene[2]);
    let f = if x <= 2.0 * F90 { x - x * x / (4.0 * F90) } else { F90 };
    let base = scene.map(|c| c - f);
    let p = base[0].max(base[1]).max(base[2]);
    if p <= KS {
        return base;
    }
    let pn = 1.0 - (1.0 - KS) * (1.0 - KS) / (p + 1.0 - 2.0 * KS);
    let g = 1.0 / (KD * (p - pn) + 1.0);
    base.map(|c| c * (pn / p) * g + pn * (1.0 - g))
}

/// Hable's curve of Uncharted 2 \[Hable2010\]: exposure bias 2, white point 11.2. White is thus reached at 5.6.
pub fn filmic(scene: Rgb) -> Rgb {
    const BIAS: f64 = 2.0;
    const WHITE: f64 = 11.2;
    // Beyond white there is nothing to see, and the quotient stays finite.
    scene.map(|c| hable((BIAS * c).min(WHITE)) / hable(WHITE))
}

/// The curve before it is scaled to the white point.
fn hable(x: f64) -> f64 {
    // In the words of the source: shoulder strength, linear strength, linear angle, toe strength, numerator, denominator.
    let [a, b, c, d, e, f] = [0.15, 0.5, 0.1, 0.2, 0.02, 0.3];
    (x * (a * x + c * b) + d * e) / (x * (a * x + b) + d * f) - e / f
}
