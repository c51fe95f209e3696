//! Every material that an OBJ file's library may ask for is one that can be built and rendered.
#![allow(clippy::unwrap_used, reason = "a test may fail anywhere")]

use penombre::{Event, Observer, Plan, Render};
use penombre_scene::Role;
use penombre_scene::load::{LoadOptions, load};
use std::ops::ControlFlow;

struct Quiet;

impl Observer for Quiet {
    fn on(&self, _: Event<'_>) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

#[test]
fn materials_of_libraries_are_built_and_rendered() {
    for integrator in ["path", "classic"] {
        let sets = ["size=[44,12]".to_owned(), "spp=4".to_owned(), format!("integrator=\"{integrator}\"")];
        let sets = sets.map(|set| format!("render.{set}")).to_vec();
        let options = LoadOptions { sets, ..LoadOptions::default() };
        let mut loaded = load("tests/data/looks.obj", &options);
        // The library also asks for what cannot be, and is told so.
        let told = loaded.diagnostics.iter().filter(|d| d.code != "mtl::number");
        assert_eq!(told.count(), 0, "{:?}", loaded.diagnostics);
        let types = loaded.description.of_role(Role::Material).map(|(_, node)| node.type_name.clone());
        let mut types: Vec<String> = types.collect();
        types.sort();
        types.dedup();
        assert_eq!(types, ["glass", "metal", "mirror", "mix", "phong", "rough_glass"]);
        let plan = Plan::new(&loaded.description, &loaded.assets, &mut loaded.diagnostics);
        assert!(!loaded.diagnostics.has_errors(), "{:?}", loaded.diagnostics);
        let mut render = Render::new(plan.unwrap());
        render.run(2, &Quiet);
        let image = render.image();
        assert!(image.to_data().iter().all(|v| v.is_finite() && *v >= 0.0));
        assert!(image.to_data().iter().any(|v| *v > 0.0));
    }
}
