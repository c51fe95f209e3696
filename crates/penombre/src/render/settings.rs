//! `[render]`: what a scene file asks for; the command line overrides.

use super::Job;
use crate::film::{FilterKind, PixelFilter};
use crate::integrator::PathTracer;
use crate::registry::Context;
use crate::sampler::SamplerKind;
use penombre_scene::params::Params;
use penombre_scene::{Kind, ParamDefault, ParamSpec, Range, Role, Span};

/// Largest edge of an image, pixels.
const MOST_PIXELS: f64 = 65536.0;

/// The parameters of `[render]`, checked.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderSettings {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Place of that size.
    pub size_span: Span,
    /// Samples per pixel.
    pub spp: u32,
    /// Name of the integrator.
    pub integrator: String,
    /// Place of that name.
    pub integrator_span: Span,
    /// Most path segments between camera and light.
    pub max_depth: u32,
    /// Seed of all sample points.
    pub seed: u64,
    /// The family of sample points.
    pub sampler: SamplerKind,
    /// Index of the camera among the scene's cameras.
    pub camera: u32,
    /// True: rays go through random points of the pixel; false: through its centre.
    pub pixel_jitter: bool,
    /// Where around the pixel they go.
    pub filter: PixelFilter,
}

/// Edge of the tiles unless told otherwise, pixels.
const DEFAULT_TILE: u32 = 16;

/// Radii and deviations of filters, pixels.
const FILTER_SIZES: Range = Range::closed(0.01, 16.0);

impl RenderSettings {
    /// The parameters of `[render]`.
    pub const SCHEMA: &'static [ParamSpec] = &[
        ParamSpec::with_default(
            "size",
            Kind::Int2(Range::closed(1.0, MOST_PIXELS)),
            ParamDefault::Vec2([640.0, 480.0]),
            "Width and height of the image.",
        )
        .unit("pixels"),
        ParamSpec::with_default(
            "spp",
            Kind::Int(Range::closed(1.0, 16_777_216.0)),
            ParamDefault::Int(64),
            "Samples per pixel.",
        ),
        ParamSpec::with_default(
            "integrator",
            Kind::Text,
            ParamDefault::Text(PathTracer::NAME),
            "How light is computed.",
        ),
        ParamSpec::with_default(
            "max_depth",
            Kind::Int(Range::closed(1.0, 65536.0)),
            ParamDefault::Int(16),
            "Most path segments between camera and light.",
        ),
        ParamSpec::with_default(
            "seed",
            Kind::Int(Range::closed(0.0, 9.2e18)),
            ParamDefault::Int(0),
            "Another seed gives other noise.",
        ),
        ParamSpec::with_default(
            "sampler",
            Kind::Choice(SamplerKind::NAMES),
            ParamDefault::Text("sobol"),
            "Family of sample points.",
        ),
        ParamSpec::optional("camera", Kind::Reference(Role::Camera), "The camera; default: the first."),
        ParamSpec::with_default(
            "pixel_jitter",
            Kind::Bool,
            ParamDefault::Bool(true),
            "Rays through random points around the pixel instead of its centre.",
        ),
        ParamSpec::with_default(
            "filter",
            Kind::Choice(FilterKind::NAMES),
            ParamDefault::Text("box"),
            "How the density of those points falls off from the pixel's centre.",
        ),
        ParamSpec::optional(
            "filter_radius",
            Kind::Float(FILTER_SIZES),
            "Where the filter ends, in x and y; default: 0.5 for the box, the pixel itself, and 1.5 for the others.",
        )
        .unit("pixels"),
        ParamSpec::with_default(
            "filter_sigma",
            Kind::Float(FILTER_SIZES),
            ParamDefault::Float(PixelFilter::SIGMA as f64),
            "Standard deviation of the Gaussian filter.",
        )
        .unit("pixels"),
    ];

    /// A size as people type it, `WIDTHxHEIGHT`, within the range that scene files have.
    ///
    /// # Errors
    ///
    /// What was found and expected, for a person.
    pub fn parse_size(text: &str) -> Result<[u32; 2], String> {
        let parts = text.split_once(['x', 'X', '×']).ok_or("expected WIDTHxHEIGHT, for example 640x480")?;
        let edge = |s: &str| match s.trim().parse::<u32>() {
            Ok(v) if v >= 1 && f64::from(v) <= MOST_PIXELS => Ok(v),
            _ => Err(format!("found `{s}`, expected a whole number of pixels from 1 to {MOST_PIXELS}")),
        };
        Ok([edge(parts.0)?, edge(parts.1)?])
    }

    /// Decodes the `[render]` node, or takes the defaults if there is none.
    pub fn build(context: &mut Context<'_, '_>) -> Self {
        let default = penombre_scene::Node::new(Role::Render, "render", "");
        let node = context.description.of_role(Role::Render).next().map(|(_, n)| n).unwrap_or(&default);
        let p: Params = context.decode(node, Self::SCHEMA);
        let size = p.int2("size");
        Self {
            size: size.map(|v| v as u32),
            size_span: p.span("size"),
            spp: p.int("spp") as u32,
            integrator: p.text("integrator").unwrap_or(PathTracer::NAME).to_owned(),
            integrator_span: p.span("integrator"),
            max_depth: p.int("max_depth") as u32,
            seed: p.int("seed") as u64,
            sampler: SamplerKind::from_name(p.choice("sampler")),
            camera: p.reference("camera").map_or(0, |id| context.position(id)),
            pixel_jitter: p.bool("pixel_jitter"),
            filter: filter(&p),
        }
    }
}

impl RenderSettings {
    /// What is rendered, without what only a command line says.
    pub(super) fn job(&self) -> Job {
        Job {
            size: self.size,
            spp: self.spp,
            seed: self.seed,
            sampler: self.sampler,
            camera: self.camera,
            pixel_jitter: self.pixel_jitter,
            filter: self.filter,
            estimate: false,
            noise: 0.0,
            features: false,
            whole_passes: false,
            tile: DEFAULT_TILE,
            progressive: false,
        }
    }
}

fn filter(p: &Params) -> PixelFilter {
    let usual = PixelFilter::of_kind(FilterKind::from_name(p.choice("filter")));
    let radius = if p.is_given("filter_radius") { p.f64("filter_radius") as f32 } else { usual.radius };
    PixelFilter { radius, sigma: p.f64("filter_sigma") as f32, ..usual }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read_strictly() {
        assert_eq!(RenderSettings::parse_size("640x480"), Ok([640, 480]));
        assert_eq!(RenderSettings::parse_size("65536X1"), Ok([65536, 1]));
        for bad in ["640", "0x5", "x", "5x-3", "70000x2", "1e9x1"] {
            assert!(RenderSettings::parse_size(bad).is_err(), "{bad}");
        }
    }
}
