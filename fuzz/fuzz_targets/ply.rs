#![no_main]
use penombre_scene::readers::MeshFormat;

libfuzzer_sys::fuzz_target!(init: penombre_fuzz::begin(), |data: &[u8]| penombre_fuzz::mesh(MeshFormat::Ply, data));
