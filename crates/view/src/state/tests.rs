//! Tests of the state machine.

use super::*;
use crate::keys::Key;
use penombre_math::{DVec3, Vec3};

const BOX: Bounds3 = Bounds3 { min: Vec3::splat(-2.0), max: Vec3::splat(2.0) };

/// A viewer that shows a built-in scene, 480 × 480.
fn showing(scene: &str) -> Viewer {
    let source = Source::builtin(scene);
    let (mut viewer, actions) = Viewer::new(WINDOW_SIZE, source.clone());
    assert_eq!(actions, [Action::LoadScene(source.clone())]);
    let camera = *viewer.camera();
    viewer.handle(Input::Loaded { source, camera, bounds: BOX });
    viewer
}

fn key(viewer: &mut Viewer, c: char) -> Vec<Action> {
    viewer.handle(Input::Key(KeyPress::char(c)))
}

fn escape(viewer: &mut Viewer) -> Vec<Action> {
    viewer.handle(Input::Key(KeyPress::key(Key::Escape)))
}

fn turn(viewer: &mut Viewer) -> Vec<Action> {
    let (from, to, window) = (Vec2::splat(100.0), Vec2::splat(140.0), Vec2::splat(480.0));
    viewer.handle(Input::Drag { button: Button::Left, from, to, window })
}

fn news(viewer: &mut Viewer, id: u64, event: RenderEvent) -> Vec<Action> {
    viewer.handle(Input::Render { id, event })
}

fn picture(stage: Stage) -> RenderEvent {
    RenderEvent::Picture(stage, Figures::default())
}

/// The number of the render that is started.
fn started(actions: &[Action]) -> Option<u64> {
    actions.iter().find_map(|a| match a {
        Action::StartRender { id, .. } => Some(*id),
        _ => None,
    })
}

fn saves(actions: &[Action]) -> usize {
    actions.iter().filter(|a| matches!(a, Action::SaveImage { .. })).count()
}

#[test]
fn plus_and_minus_go_round_the_scenes_of_the_course() {
    let mut viewer = showing("sphere");
    for expected in ["square", "cornell", "sphere", "square"] {
        let source = Source::builtin(expected);
        assert!(key(&mut viewer, '+').contains(&Action::LoadScene(source.clone())));
        // The old scene stays until the new one is there.
        assert_ne!(viewer.source(), Some(&source));
        let camera = *viewer.camera();
        viewer.handle(Input::Loaded { source: source.clone(), camera, bounds: BOX });
        assert_eq!((viewer.source(), viewer.loading()), (Some(&source), None));
    }
    assert!(key(&mut viewer, '-').contains(&Action::LoadScene(Source::builtin("sphere"))));
    // Twice in a row, before the first has come.
    assert!(key(&mut viewer, '-').contains(&Action::LoadScene(Source::builtin("cornell"))));
    // The one that was given up is not shown when it comes.
    let camera = *viewer.camera();
    viewer.handle(Input::Loaded { source: Source::builtin("sphere"), camera, bounds: BOX });
    assert_eq!(viewer.source(), Some(&Source::builtin("square")));
}

#[test]
fn r_renders_what_is_seen_and_saves_when_complete() {
    let mut viewer = showing("cornell");
    turn(&mut viewer);
    viewer.handle(Input::Resize([300, 200]));
    let camera = *viewer.camera();
    let actions = key(&mut viewer, 'r');
    let [Action::StartRender { id, setup, beyond: false }, Action::Redraw] = &actions[..] else {
        panic!("{actions:?}")
    };
    assert_eq!((setup.size, setup.camera), ([300, 200], camera));
    assert_eq!(viewer.mode(), Mode::Rendering(None));
    for stage in [Stage::Coarse, Stage::Refining] {
        assert_eq!(news(&mut viewer, *id, picture(stage)), [Action::Redraw]);
        assert!(matches!(viewer.mode(), Mode::Rendering(Some(_))) && viewer.has_picture());
    }
    let save = |path: &str| Action::SaveImage { path: path.into(), course_ppm: true };
    let actions = news(&mut viewer, *id, picture(Stage::Complete));
    assert_eq!(actions, [save("rendu.ppm"), save("rendu.png"), Action::Redraw]);
    assert!(matches!(viewer.mode(), Mode::Rendered(_)));
    // Once only.
    assert_eq!(news(&mut viewer, *id, picture(Stage::Beyond)), [Action::Redraw]);
    news(&mut viewer, *id, RenderEvent::Finished);
    assert_eq!(viewer.next_tick(5.0), None, "idle");
    // Again: another render.
    assert!(started(&key(&mut viewer, 'r')) > Some(*id));
}

#[test]
fn a_complete_picture_that_was_missed_is_saved_all_the_same() {
    let mut viewer = showing("cornell");
    viewer.handle(Input::Panel(PanelChange::Beyond(true)));
    let id = started(&key(&mut viewer, 'r')).unwrap();
    assert_eq!(saves(&news(&mut viewer, id, picture(Stage::Beyond))), 2);
}

#[test]
fn moving_goes_back_to_raster_at_once_and_old_news_are_ignored() {
    let mut viewer = showing("cornell");
    let id = started(&key(&mut viewer, 'r')).unwrap();
    news(&mut viewer, id, picture(Stage::Refining));
    assert_eq!(turn(&mut viewer), [Action::CancelRender, Action::Redraw]);
    assert_eq!(viewer.mode(), Mode::Raster);
    assert_eq!(news(&mut viewer, id, picture(Stage::Complete)), []);
    assert_eq!(viewer.mode(), Mode::Raster);
    // Not live: it stays there.
    assert_eq!(viewer.handle(Input::Tick(100.0)), []);
    assert_eq!(viewer.handle(Input::Tick(200.0)), []);
}

#[test]
fn the_live_render_starts_when_the_camera_rests() {
    let mut viewer = showing("cornell");
    viewer.handle(Input::Panel(PanelChange::Live(true)));
    assert_eq!(viewer.next_tick(1.0), Some(0.0), "at once, to tell when the rest began");
    assert_eq!(started(&viewer.handle(Input::Tick(1.0))), None);
    assert!((viewer.next_tick(1.02).unwrap() - (REST - 0.02)).abs() < 1e-9);
    assert_eq!(started(&viewer.handle(Input::Tick(1.02))), None, "not rested long enough");
    turn(&mut viewer);
    assert_eq!(started(&viewer.handle(Input::Tick(1.06))), None, "it has moved");
    let id = started(&viewer.handle(Input::Tick(1.2))).unwrap();
    assert_eq!(viewer.next_tick(1.3), None);
    // It writes no file, unless r is pressed meanwhile.
    assert_eq!(saves(&news(&mut viewer, id, picture(Stage::Complete))), 0);
    turn(&mut viewer);
    viewer.handle(Input::Tick(2.0));
    let id = started(&viewer.handle(Input::Tick(3.0))).unwrap();
    assert_eq!(key(&mut viewer, 'r'), [], "the same image is on its way");
    assert_eq!(saves(&news(&mut viewer, id, picture(Stage::Complete))), 2);
    // A value of the panel starts it anew.
    let actions = viewer.handle(Input::Panel(PanelChange::Phase(Some(2))));
    assert!(actions.contains(&Action::CancelRender) && viewer.mode() == Mode::Raster);
    viewer.handle(Input::Tick(4.0));
    assert!(started(&viewer.handle(Input::Tick(5.0))).is_some());
    assert_eq!(viewer.setup().settings.phase, Some(2));
}

#[test]
fn escape_cancels_first_and_then_quits() {
    let mut viewer = showing("cornell");
    viewer.handle(Input::Panel(PanelChange::Live(true)));
    viewer.handle(Input::Tick(1.0));
    let id = started(&viewer.handle(Input::Tick(2.0))).unwrap();
    assert_eq!(escape(&mut viewer), [Action::CancelRender, Action::Redraw]);
    assert!(viewer.mode() == Mode::Raster && !viewer.is_live(), "else it would start again");
    assert_eq!(news(&mut viewer, id, picture(Stage::Coarse)), []);
    assert_eq!(escape(&mut viewer), [Action::Quit]);
    // Beyond the image: the image stays.
    let id = started(&key(&mut viewer, 'r')).unwrap();
    news(&mut viewer, id, picture(Stage::Complete));
    assert_eq!(escape(&mut viewer), [Action::CancelRender, Action::Redraw]);
    assert!(matches!(viewer.mode(), Mode::Rendered(_)));
    assert_eq!(escape(&mut viewer), [Action::Quit]);
    assert_eq!(key(&mut showing("sphere"), 'q'), [Action::Quit]);
}

#[test]
fn views_move_the_camera_and_home_brings_it_back() {
    let mut viewer = showing("cornell");
    let home = *viewer.camera();
    for c in ['1', '3', '.', '7'] {
        turn(&mut viewer);
        let before = *viewer.camera();
        assert_eq!(key(&mut viewer, c), [Action::Redraw]);
        assert_ne!(*viewer.camera(), before);
    }
    assert!((viewer.camera().look_at().position.y - viewer.camera().distance()).abs() < 1e-9);
    viewer.handle(Input::Key(KeyPress::key(Key::Home)));
    assert_eq!(*viewer.camera(), home);
    // Nothing to do: nothing to draw.
    assert_eq!(viewer.handle(Input::Key(KeyPress::key(Key::Home))), []);
    viewer.handle(Input::Wheel(1.0));
    assert!(viewer.camera().distance() < home.distance());
}

#[test]
fn switches_and_help() {
    let mut viewer = showing("cornell");
    assert_eq!(key(&mut viewer, 'w'), [Action::ToggleWireframe(true), Action::Redraw]);
    assert_eq!(key(&mut viewer, 'w'), [Action::ToggleWireframe(false), Action::Redraw]);
    assert_eq!(key(&mut viewer, 'f'), [Action::ToggleFullscreen(true)]);
    assert_eq!(key(&mut viewer, 'f'), [Action::ToggleFullscreen(false)]);
    for c in ['?', 'g'] {
        assert_eq!(key(&mut viewer, c), [Action::ShowHelp(true), Action::Redraw]);
        assert_eq!(key(&mut viewer, '?'), [Action::ShowHelp(false), Action::Redraw]);
    }
}

#[test]
fn files_are_opened_and_saved_and_faults_are_told() {
    let mut viewer = showing("cornell");
    assert_eq!(viewer.handle(Input::Key(KeyPress::ctrl('o'))), [Action::OpenDialog]);
    assert_eq!(viewer.handle(Input::DialogClosed), []);
    let source = Source::builtin("a.toml");
    for input in [Input::Open("a.toml".into()), Input::Drop("a.toml".into())] {
        assert!(viewer.handle(input).contains(&Action::LoadScene(source.clone())));
    }
    let message = "a.toml:1: broken".to_owned();
    viewer.handle(Input::LoadFailed { source, message: message.clone() });
    assert_eq!((viewer.message(), viewer.loading()), (Some(message.as_str()), None));
    assert_eq!(viewer.source(), Some(&Source::builtin("cornell")), "the old scene stays");
    viewer.handle(Input::MessageClosed);
    assert_eq!(viewer.message(), None);
    // Without an image there is nothing to save.
    assert_eq!(viewer.handle(Input::Key(KeyPress::ctrl('s'))), [Action::Redraw]);
    assert!(viewer.message().is_some());
    let id = started(&key(&mut viewer, 'r')).unwrap();
    news(&mut viewer, id, picture(Stage::Coarse));
    assert_eq!(viewer.handle(Input::Key(KeyPress::ctrl('s'))), [Action::SaveDialog]);
    let save = Action::SaveImage { path: "b.exr".into(), course_ppm: false };
    assert_eq!(viewer.handle(Input::SaveTo("b.exr".into())), [save]);
    viewer.handle(Input::Saved(Err("disk full".to_owned())));
    assert_eq!(viewer.message(), Some("disk full"));
    news(&mut viewer, id, RenderEvent::Failed("no such camera".to_owned()));
    assert_eq!((viewer.mode(), viewer.message()), (Mode::Raster, Some("no such camera")));
}

#[test]
fn escape_takes_what_is_in_front_first() {
    let mut viewer = showing("cornell");
    let id = started(&key(&mut viewer, 'r')).unwrap();
    news(&mut viewer, id, picture(Stage::Refining));
    key(&mut viewer, '?');
    viewer.handle(Input::Saved(Err("disk full".to_owned())));
    assert_eq!(escape(&mut viewer), [Action::Redraw]);
    assert_eq!((viewer.message(), viewer.shows_help()), (None, true));
    assert_eq!(escape(&mut viewer), [Action::ShowHelp(false), Action::Redraw]);
    assert!(escape(&mut viewer).contains(&Action::CancelRender));
    assert_eq!(escape(&mut viewer), [Action::Quit]);
}

#[test]
fn what_was_saved_is_told_until_the_next_render() {
    let mut viewer = showing("cornell");
    viewer.handle(Input::Saved(Ok("rendu.ppm was written".to_owned())));
    assert_eq!(viewer.notice(), Some("rendu.ppm was written"));
    key(&mut viewer, 'r');
    assert_eq!(viewer.notice(), None);
}

#[test]
fn a_hidden_or_tiny_window_is_no_trouble() {
    let mut viewer = showing("cornell");
    assert_eq!(viewer.handle(Input::Resize([480, 480])), [], "the same size");
    viewer.handle(Input::Resize([0, 0]));
    assert_eq!(started(&key(&mut viewer, 'r')), None);
    assert!(viewer.aspect().is_finite() && viewer.setup().size == [1, 1]);
    key(&mut viewer, '.');
    viewer.handle(Input::Resize([1, 1]));
    assert!(started(&key(&mut viewer, 'r')).is_some());
    viewer.handle(Input::Resize([u32::MAX, 7]));
    assert_eq!(viewer.setup().size, [65536, 7]);
}

#[test]
fn the_panel_clamps_and_a_new_scene_forgets_it() {
    let mut viewer = showing("cornell");
    for change in [
        PanelChange::Phase(Some(9)),
        PanelChange::Spp(Some(0)),
        PanelChange::ShadowSamples(Some(u32::MAX)),
        PanelChange::HardShadows(Some(true)),
        PanelChange::Integrator(Some("classic".to_owned())),
        PanelChange::Exposure(f32::NAN),
        PanelChange::Tone(Some(ToneCurve::Srgb)),
    ] {
        viewer.handle(Input::Panel(change));
    }
    let expected = Settings {
        phase: Some(4),
        hard_shadows: Some(true),
        integrator: Some("classic".to_owned()),
        spp: Some(1),
        shadow_samples: Some(65536),
        exposure: 0.0,
        tone: Some(ToneCurve::Srgb),
    };
    assert_eq!(viewer.settings(), &expected);
    // Exposure and tone curve change how the image is shown and not the image.
    let id = started(&key(&mut viewer, 'r')).unwrap();
    news(&mut viewer, id, picture(Stage::Complete));
    viewer.handle(Input::Panel(PanelChange::Exposure(2.0)));
    assert!(matches!(viewer.mode(), Mode::Rendered(_)));
    assert_eq!(viewer.handle(Input::Panel(PanelChange::Phase(Some(4)))), [], "no change");
    viewer.handle(Input::Panel(PanelChange::Scene("sphere".to_owned())));
    let (source, camera) = (Source::builtin("sphere"), *viewer.camera());
    viewer.handle(Input::Loaded { source, camera, bounds: BOX });
    let kept = Settings { exposure: 2.0, tone: Some(ToneCurve::Srgb), ..Settings::default() };
    assert_eq!((viewer.settings(), viewer.mode()), (&kept, Mode::Raster));
    assert!(viewer.camera().look_at().position.distance(DVec3::new(0.0, 0.0, 6.1)) < 1e-12);
}
