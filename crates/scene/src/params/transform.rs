//! Transforms: lists of steps, composed in double precision.

use super::decode::{Decoder, Step};
use super::expect::TRANSFORM_HELP;
use crate::description::{Param, Value, ValueKind};
use crate::schema::{Kind, Range};
use penombre_math::float::sin_cos_degrees;
use penombre_math::{DAffine3, DMat3, DVec3, Transform};

/// The keys that name a step.
const STEPS: [&str; 4] = ["translate", "scale", "rotate", "matrix"];
const KEYS: [&str; 5] = ["translate", "scale", "rotate", "angle", "matrix"];

/// A determinant below this, against the product of the columns' lengths, is rounding noise.
const FLAT: f64 = 1e-13;

impl Decoder<'_> {
    /// A list of steps, the first applied first; the whole must be invertible.
    pub fn transform(&mut self, value: &Value) -> Option<DAffine3> {
        let ValueKind::Array(steps) = &value.kind else { return self.wrong_type(&Kind::Transform, value) };
        let step = |(i, v)| self.within(Step::Index(i), |d| d.step(v));
        let steps: Vec<Option<DAffine3>> = steps.iter().enumerate().map(step).collect();
        let map = steps.into_iter().try_fold(DAffine3::IDENTITY, |all, step| step.map(|s| s * all))?;
        if Transform::new(map).is_none() {
            let message = format!(
                "{} leaves single precision: it or its inverse has numbers beyond 3.4e38",
                self.place()
            );
            self.report("scene::singular-transform", value.span, message).help("make its steps less extreme");
            return None;
        }
        Some(map)
    }

    fn step(&mut self, value: &Value) -> Option<DAffine3> {
        let ValueKind::Table(entries) = &value.kind else {
            self.fault("scene::wrong-type", value, "a step such as { translate = [1, 0, 0] }")
                .help(TRANSFORM_HELP);
            return None;
        };
        if self.unknown_entries(entries, &KEYS) {
            return None;
        }
        let given: Vec<&Param> = entries.iter().filter(|e| STEPS.contains(&e.name.as_str())).collect();
        let [step] = given[..] else {
            let count = if given.is_empty() { "none" } else { "several" };
            let message =
                format!("{} has {count} of translate, scale, rotate and matrix, expected one", self.place());
            self.report("scene::bad-transform", value.span, message).help(TRANSFORM_HELP);
            return None;
        };
        let angle = entries.iter().find(|e| e.name == "angle");
        match step.name.as_str() {
            "rotate" => self.rotation(value, step, angle),
            _ if angle.is_some() => {
                let message = format!("{} has an angle, which belongs to rotate", self.place());
                self.report("scene::bad-transform", value.span, message).help(TRANSFORM_HELP);
                None
            }
            "translate" => {
                let by = self.within(Step::Key("translate"), |d| d.triple(&step.value))?;
                Some(DAffine3::from_translation(by))
            }
            "scale" => self.within(Step::Key("scale"), |d| d.scaling(&step.value)),
            _ => self.within(Step::Key("matrix"), |d| d.matrix(&step.value)),
        }
    }

    fn triple(&mut self, value: &Value) -> Option<DVec3> {
        self.numbers::<3>(value, &Kind::Vec3, &Range::ANY).map(DVec3::from_array)
    }

    fn rotation(&mut self, value: &Value, step: &Param, angle: Option<&Param>) -> Option<DAffine3> {
        let axis = self.within(Step::Key("rotate"), |d| {
            let axis = d.triple(&step.value)?;
            if axis == DVec3::ZERO {
                let message = format!("{} is [0, 0, 0], expected the axis of the rotation", d.place());
                let help = "[0, 1, 0] turns about the y axis, which points up";
                d.report("scene::zero-direction", step.value.span, message).help(help);
                return None;
            }
            Some(axis)
        });
        let Some(angle) = angle else {
            let message = format!("{} rotates without an angle", self.place());
            let help = "add the angle in degrees: { rotate = [0, 1, 0], angle = 30 }";
            self.report("scene::bad-transform", value.span, message).help(help);
            return None;
        };
        let degrees = self.within(Step::Key("angle"), |d| d.number(&angle.value, &Range::ANY));
        Some(rotation(axis?, degrees?))
    }

    fn scaling(&mut self, value: &Value) -> Option<DAffine3> {
        let by = match value.kind {
            ValueKind::Array(_) => self.triple(value)?,
            _ => DVec3::splat(self.number(value, &Range::ANY)?),
        };
        if by.to_array().contains(&0.0) {
            let message = format!("{} scales by zero, which flattens everything", self.place());
            let help = "use a small number instead, or a flat shape such as quad or disk";
            self.report("scene::singular-transform", value.span, message).help(help);
            return None;
        }
        Some(DAffine3::from_scale(by))
    }

    /// Sixteen numbers, row by row; the last row is 0, 0, 0, 1.
    fn matrix(&mut self, value: &Value) -> Option<DAffine3> {
        const EXPECTED: &str = "16 numbers, row by row";
        const HELP: &str = "write { matrix = [1, 0, 0, x,  0, 1, 0, y,  0, 0, 1, z,  0, 0, 0, 1] }";
        let ValueKind::Array(list) = &value.kind else {
            self.fault("scene::wrong-type", value, EXPECTED).help(HELP);
            return None;
        };
        if list.len() != 16 {
            self.fault("scene::wrong-length", value, EXPECTED).help(HELP);
            return None;
        }
        let part = |(i, v)| self.within(Step::Index(i), |d| d.number(v, &Range::ANY));
        let parts: Vec<Option<f64>> = list.iter().enumerate().map(part).collect();
        let m: Vec<f64> = parts.into_iter().collect::<Option<_>>()?;
        if m[12..] != [0.0, 0.0, 0.0, 1.0] {
            let message = format!("the last row of {} is not 0, 0, 0, 1", self.place());
            let help = "give the matrix row by row, the translation in the entries 4, 8 and 12";
            self.report("scene::bad-transform", value.span, message).help(help);
            return None;
        }
        let column = |i: usize| DVec3::new(m[i], m[4 + i], m[8 + i]);
        let linear = DMat3::from_cols(column(0), column(1), column(2));
        let lengths = column(0).length() * column(1).length() * column(2).length();
        if linear.determinant().abs() <= FLAT * lengths {
            let message = format!("{} is singular: it flattens everything", self.place());
            self.report("scene::singular-transform", value.span, message)
                .help("its first three columns must not lie in one plane");
            return None;
        }
        Some(DAffine3 { matrix3: linear, translation: column(3) })
    }
}

/// The rotation about an axis through the origin, counter-clockwise seen from the axis' tip (Rodrigues).
fn rotation(axis: DVec3, degrees: f64) -> DAffine3 {
    let (sin, cos) = sin_cos_degrees(degrees);
    // Scaled first, so that no square overflows or vanishes.
    let a = axis / axis.abs().max_element();
    let a = a / a.length();
    let image = |v: DVec3| v * cos + a.cross(v) * sin + a * (a.dot(v) * (1.0 - cos));
    DAffine3 {
        matrix3: DMat3::from_cols(image(DVec3::X), image(DVec3::Y), image(DVec3::Z)),
        translation: DVec3::ZERO,
    }
}
