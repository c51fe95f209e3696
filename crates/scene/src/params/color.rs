//! Colours: three linear numbers, one for grey, or an sRGB code.

use super::decode::{Decoder, Step};
use super::expect::COLOR_HELP;
use crate::description::{Value, ValueKind};
use crate::schema::{Kind, Range};
use penombre_math::color::srgb_decode_u8;

impl Decoder<'_> {
    /// A colour in linear Rec. 709, each number within the range; `kind` is what messages ask for.
    pub fn color(&mut self, value: &Value, range: &Range, kind: &Kind) -> Option<[f32; 3]> {
        match &value.kind {
            ValueKind::Int(_) | ValueKind::Float(_) => self.number(value, range).map(|v| [v as f32; 3]),
            ValueKind::String(text) => self.color_code(value, text),
            ValueKind::Array(list) if list.len() == 3 => {
                let part = |(i, v)| self.within(Step::Index(i), |d| d.color_part(v, range));
                let parts: Vec<Option<f32>> = list.iter().enumerate().map(part).collect();
                Some([parts[0]?, parts[1]?, parts[2]?])
            }
            ValueKind::Array(_) => {
                self.fault("scene::wrong-length", value, "a colour of three numbers, [r, g, b]")
                    .help(COLOR_HELP);
                None
            }
            _ => self.wrong_type(kind, value),
        }
    }

    fn color_part(&mut self, value: &Value, range: &Range) -> Option<f32> {
        if let ValueKind::Int(i @ 2..=255) = value.kind
            && !range.contains(i as f64)
        {
            let expected = super::expect::expected_number(range, false, "");
            self.fault("scene::out-of-range", value, &expected).help(
                "colours here are linear numbers; for values from 0 to 255 write an sRGB code, \"#rrggbb\"",
            );
            return None;
        }
        self.number(value, range).map(|v| v as f32)
    }

    fn color_code(&mut self, value: &Value, text: &str) -> Option<[f32; 3]> {
        if let Some(codes) = codes(text) {
            return Some(codes.map(srgb_decode_u8));
        }
        let help = if self.is_texture(text) {
            format!("for the texture of that name write {{ texture = {text:?} }}")
        } else {
            COLOR_HELP.to_owned()
        };
        self.fault("scene::bad-color", value, "a colour").help(help);
        None
    }
}

/// The bytes of `#rgb` or `#rrggbb`.
fn codes(text: &str) -> Option<[u8; 3]> {
    let digits: Option<Vec<u8>> =
        text.strip_prefix('#')?.chars().map(|c| c.to_digit(16).map(|d| d as u8)).collect();
    match digits?[..] {
        [r, g, b] => Some([r * 17, g * 17, b * 17]),
        [r, r2, g, g2, b, b2] => Some([r * 16 + r2, g * 16 + g2, b * 16 + b2]),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::codes;

    #[test]
    fn reads_short_and_long_codes() {
        assert_eq!(codes("#fff"), Some([255; 3]));
        assert_eq!(codes("#1a2"), Some([0x11, 0xaa, 0x22]));
        assert_eq!(codes("#30fF0a"), Some([0x30, 0xff, 0x0a]));
        for bad in ["", "#", "fff", "#ff", "#ffff", "#ggg", "#fffffff", "#ää", "red"] {
            assert_eq!(codes(bad), None, "{bad}");
        }
    }
}
