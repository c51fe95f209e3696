//! Complex indices of refraction of metals for linear Rec. 709 red, green and blue.
//!
//! Made from measured spectra: \[Johnson1972\] (gold, silver, copper), \[Johnson1974\] (chromium, iron, nickel,
//! titanium), \[Rakic1995\] (aluminium), as collected by \[RefractiveIndex\]. Fresnel's reflectance of the spectrum
//! under illuminant D65, by the CIE 1931 colour matching functions in steps of 10 nm, gives a reflectance in Rec. 709
//! for each angle, white being (1, 1, 1). n and k of each lane are the pair whose reflectance comes nearest to it over
//! cos θ (least squares, cosine-weighted). Nearest is within 0.007 at each of 20 angles; for all but gold and copper
//! within 0.0012. Gold's red exceeds 1 (it lies outside of Rec. 709) and is held at 1.
//!
//! These are no means of the spectra of n and k: those give reflectances that are off by several hundredths.

/// A metal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metal {
    /// English name, in lower case.
    pub name: &'static str,
    /// Chemical symbol.
    pub symbol: &'static str,
    /// Index of refraction of red, green, blue.
    pub n: [f32; 3],
    /// Extinction coefficient of red, green, blue.
    pub k: [f32; 3],
}

/// The known metals.
pub const METALS: &[Metal] = &[
    metal("aluminium", "Al", [1.5, 0.985, 0.606], [7.652, 6.549, 5.349]),
    metal("chromium", "Cr", [3.25, 3.12, 2.29], [3.287, 3.336, 3.117]),
    metal("copper", "Cu", [0.229, 1.05, 1.3], [3.42, 2.625, 2.363]),
    metal("gold", "Au", [0.182, 0.497, 1.48], [30.87, 2.257, 1.776]),
    metal("iron", "Fe", [2.92, 2.92, 2.55], [3.077, 2.937, 2.75]),
    metal("nickel", "Ni", [2.04, 1.9, 1.73], [4.204, 3.57, 2.896]),
    metal("silver", "Ag", [0.0568, 0.0551, 0.0432], [4.499, 3.549, 2.591]),
    metal("titanium", "Ti", [2.75, 2.51, 2.24], [3.844, 3.397, 3.015]),
];

const fn metal(name: &'static str, symbol: &'static str, n: [f32; 3], k: [f32; 3]) -> Metal {
    Metal { name, symbol, n, k }
}

impl Metal {
    /// The metal of a name or symbol.
    pub fn find(name: &str) -> Option<&'static Self> {
        METALS.iter().find(|m| m.name == name || m.symbol == name)
    }
}

#[cfg(test)]
mod tests {
    use super::super::fresnel;
    use super::*;

    #[test]
    fn reflectances_are_those_of_the_spectra() {
        // Rec. 709 reflectance at normal incidence, integrated from the measured spectra.
        for (name, expected) in [
            ("Au", [1.0374f32, 0.7286, 0.3646]),
            ("Ag", [0.9894, 0.9839, 0.9779]),
            ("Cu", [0.9317, 0.6225, 0.5224]),
            ("Al", [0.9073, 0.9159, 0.9223]),
            ("Cr", [0.5496, 0.5560, 0.5543]),
            ("Fe", [0.5297, 0.5132, 0.4942]),
            ("Ti", [0.6186, 0.5794, 0.5425]),
            ("Ni", [0.6971, 0.6405, 0.5633]),
        ] {
            let m = Metal::find(name).unwrap();
            let found = fresnel::conductor(1.0, m.n, m.k).to_rgb();
            for (f, e) in found.into_iter().zip(expected) {
                assert!((f - e.min(1.0)).abs() < 0.0015, "{name}: {found:?}");
            }
        }
        assert_eq!(METALS.len(), 8);
        assert_eq!(Metal::find("gold"), Metal::find("Au"));
        assert_eq!(Metal::find("unobtainium"), None);
    }

    /// Measured values at single wavelengths near the middle of a lane must be in its neighbourhood.
    #[test]
    fn silver_is_near_its_spectrum() {
        let silver = Metal::find("Ag").unwrap(); // 549 nm: 0.06 + 3.586i
        assert!((silver.n[1] - 0.06).abs() < 0.01 && (silver.k[1] - 3.586).abs() < 0.05);
    }
}
