//! The panel beside the picture: every value of the render, its figures, and the command that does the same.

use crate::progressive::Figures;
use crate::session::{Session, Settings};
use crate::state::{Mode, PanelChange, Viewer};
use eframe::egui::{self, Ui};
use penombre::integrator::{Classic, TYPES};
use penombre_image::ToneCurve;

/// Width of the panel with its margins, points.
pub const WIDTH: f32 = 280.0;
/// Space around the panel's contents, points.
const MARGIN: i8 = 8;

/// What was done in the panel.
#[derive(Clone, Debug, PartialEq)]
pub enum Done {
    /// A value changed.
    Changed(PanelChange),
    /// A button that does what a key does.
    Key(crate::keys::KeyPress),
}

/// What the panel shows besides the state.
pub struct Shown<'a> {
    /// The scene, once one is loaded.
    pub session: Option<&'a Session>,
    /// The command that gives the same image, or why there is none.
    pub command: Option<&'a Result<String, String>>,
    /// True while an image is written.
    pub saving: bool,
}

/// Draws the panel at the right edge.
pub fn show(ui: &mut Ui, viewer: &Viewer, shown: &Shown<'_>) -> Vec<Done> {
    let frame = egui::Frame::side_top_panel(ui.style()).inner_margin(MARGIN);
    let panel = egui::Panel::right("panel").resizable(false).frame(frame);
    let contents = |ui: &mut Ui| {
        let area = egui::ScrollArea::vertical().auto_shrink(false);
        area.show(ui, |ui| {
            let mut done = Vec::new();
            buttons(ui, viewer, &mut done);
            ui.separator();
            progress(ui, viewer, shown);
            ui.separator();
            values(ui, viewer, shown.session, &mut done);
            switches(ui, viewer, &mut done);
            notes(ui, viewer, shown);
            ui.separator();
            command(ui, viewer, shown);
            done
        })
        .inner
    };
    panel.exact_size(WIDTH).show(ui, contents).inner
}

fn buttons(ui: &mut Ui, viewer: &Viewer, done: &mut Vec<Done>) {
    use crate::keys::{Key, KeyPress};
    ui.horizontal(|ui| {
        let (text, press, hint) = match viewer.is_busy() {
            true => ("Stop", KeyPress::key(Key::Escape), "Esc"),
            false => ("Render", KeyPress::char('r'), "r"),
        };
        let mut button = |ui: &mut Ui, text: &str, hint: &str, press: KeyPress| {
            if ui.button(text).on_hover_text(format!("key: {hint}")).clicked() {
                done.push(Done::Key(press));
            }
        };
        button(ui, text, hint, press);
        button(ui, "Open…", "Ctrl-O", KeyPress::ctrl('o'));
        ui.add_enabled_ui(viewer.has_picture(), |ui| button(ui, "Save…", "Ctrl-S", KeyPress::ctrl('s')));
        button(ui, "?", "?", KeyPress::char('?'));
    });
}

/// How far the render is.
fn progress(ui: &mut Ui, viewer: &Viewer, shown: &Shown<'_>) {
    let (word, figures) = match viewer.mode() {
        Mode::Raster => ("preview", None),
        Mode::Rendering(None) => ("starting", None),
        Mode::Rendering(Some(figures)) => ("rendering", Some(figures)),
        Mode::Rendered(figures) => ("image", Some(figures)),
    };
    let (word, figures) = if viewer.loading().is_some() { ("loading", None) } else { (word, figures) };
    let beyond = viewer.is_busy() && matches!(viewer.mode(), Mode::Rendered(_));
    let room = egui::vec2(ui.available_width(), ui.spacing().interact_size.y);
    match figures {
        Some(f) => {
            let part = (f.spp / f64::from(f.target.max(1))) as f32;
            let (part, text) = match beyond {
                true => (1.0, format!("{word}: {:.0} spp, going on", f.spp.floor())),
                false => (part, format!("{word}: {:.0} of {} spp", f.spp.floor(), f.target)),
            };
            ui.add_sized(room, egui::ProgressBar::new(part).text(text))
        }
        // As high, so that nothing moves.
        None => ui.add_sized(room, egui::Label::new(word)),
    };
    let open = |f: Figures| Figures { seconds_left: if beyond { 0.0 } else { f.seconds_left }, ..f };
    ui.label(figures.map_or_else(String::new, |figures| rate(&open(figures))));
    if shown.saving {
        ui.label("saving …");
    } else if let Some(notice) = viewer.notice() {
        ui.label(notice);
    }
}

/// Rate and time of a render, for a person.
fn rate(figures: &Figures) -> String {
    let million = figures.samples_per_second / 1e6;
    let mut text = format!("{million:.2} Msamples/s, {} so far", duration(figures.seconds));
    if figures.seconds_left > 0.0 && figures.seconds_left.is_finite() {
        text += &format!(", {} left", duration(figures.seconds_left));
    }
    if figures.non_finite > 0 {
        text += &format!(", {} samples dropped", figures.non_finite);
    }
    text
}

fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 59.95 => format!("{s:.1} s"),
        s if s < 3600.0 => format!("{:.0} min {:02.0} s", (s / 60.0).floor(), (s % 60.0).floor()),
        s => format!("{:.0} h {:02.0} min", (s / 3600.0).floor(), (s / 60.0 % 60.0).floor()),
    }
}

/// The values of the render, as the scene has them or as they were changed.
fn values(ui: &mut Ui, viewer: &Viewer, session: Option<&Session>, done: &mut Vec<Done>) {
    let settings = viewer.settings();
    let mut change = |c: PanelChange| done.push(Done::Changed(c));
    egui::Grid::new("values").num_columns(2).show(ui, |ui| {
        labelled(ui, "scene", |ui| scenes(ui, session, &mut change));
        let Some(session) = session else { return };
        let scene = session.values();
        let integrator = settings.integrator.as_ref().unwrap_or(&scene.integrator);
        labelled(ui, "integrator", |ui| integrators(ui, integrator, &mut change));
        if integrator == Classic::NAME {
            classic(ui, settings, session, &mut change);
        }
        let mut spp = settings.spp.unwrap_or(scene.spp);
        let drag = egui::DragValue::new(&mut spp).range(1..=1 << 24).speed(1.0).update_while_editing(false);
        if labelled(ui, "samples per pixel", |ui| ui.add(drag)).changed() {
            change(PanelChange::Spp(Some(spp)));
        }
        let mut exposure = settings.exposure;
        let drag = egui::DragValue::new(&mut exposure)
            .range(-20.0..=20.0)
            .speed(0.02)
            .suffix(" EV")
            .update_while_editing(false);
        if labelled(ui, "exposure", |ui| ui.add(drag)).changed() {
            change(PanelChange::Exposure(exposure));
        }
        labelled(ui, "tone curve", |ui| tones(ui, session, settings, &mut change));
    });
}

/// A row of the grid. The label names the value for screen readers as well.
fn labelled<R: Named>(ui: &mut Ui, label: &str, add: impl FnOnce(&mut Ui) -> R) -> R {
    let label = ui.label(label);
    let result = add(ui);
    let result = result.named(label.id);
    ui.end_row();
    result
}

/// What a label can name.
trait Named {
    fn named(self, label: egui::Id) -> Self;
}

impl Named for egui::Response {
    fn named(self, label: egui::Id) -> Self {
        self.labelled_by(label)
    }
}

fn scenes(ui: &mut Ui, session: Option<&Session>, change: &mut dyn FnMut(PanelChange)) -> egui::Response {
    let combo = egui::ComboBox::from_id_salt("scene").selected_text(session.map_or("none", Session::name));
    let response = combo.show_ui(ui, |ui| {
        for name in penombre_scene::builtin::NAMES {
            let chosen = session.is_some_and(|session| session.source().scene == name);
            if ui.selectable_label(chosen, name).clicked() {
                change(PanelChange::Scene(name.to_owned()));
            }
        }
    });
    response.response
}

fn integrators(ui: &mut Ui, current: &str, change: &mut dyn FnMut(PanelChange)) -> egui::Response {
    let combo = egui::ComboBox::from_id_salt("integrator").selected_text(current);
    let response = combo.show_ui(ui, |ui| {
        for (name, _) in TYPES {
            if ui.selectable_label(current == *name, *name).clicked() {
                change(PanelChange::Integrator(Some((*name).to_owned())));
            }
        }
    });
    response.response
}

/// What only the course's integrator has.
fn classic(ui: &mut Ui, settings: &Settings, session: &Session, change: &mut dyn FnMut(PanelChange)) {
    let scene = session.values();
    let phase = settings.phase.unwrap_or(scene.phase);
    labelled(ui, "phase", |ui| {
        let row = ui.horizontal(|ui| {
            for (n, what) in
                [(1, "flat colour"), (2, "Phong and shadows"), (3, "and mirrors"), (4, "and glass")]
            {
                if ui.selectable_label(phase == n, n.to_string()).on_hover_text(what).clicked() {
                    change(PanelChange::Phase(Some(n)));
                }
            }
        });
        row.response
    });
    let mut hard = settings.hard_shadows.unwrap_or(scene.hard_shadows);
    if labelled(ui, "hard shadows", |ui| ui.checkbox(&mut hard, "")).changed() {
        change(PanelChange::HardShadows(Some(hard)));
    }
    // Also where no light has an area, so that the rows below stay where they are.
    let mut samples = settings.shadow_samples.or(scene.shadow_samples).unwrap_or(1);
    let able = scene.shadow_samples.is_some() && !hard;
    let drag = egui::DragValue::new(&mut samples).range(1..=65536).speed(0.2).update_while_editing(false);
    if labelled(ui, "shadow samples", |ui| ui.add_enabled(able, drag)).changed() {
        change(PanelChange::ShadowSamples(Some(samples)));
    }
}

fn tones(
    ui: &mut Ui,
    session: &Session,
    settings: &Settings,
    change: &mut dyn FnMut(PanelChange),
) -> egui::Response {
    let combo = egui::ComboBox::from_id_salt("tone").selected_text(session.tone(settings).to_string());
    let response = combo.show_ui(ui, |ui| {
        for tone in ToneCurve::NAMES.iter().filter_map(|name| name.parse::<ToneCurve>().ok()) {
            if ui.selectable_label(session.tone(settings) == tone, tone.to_string()).clicked() {
                change(PanelChange::Tone(Some(tone)));
            }
        }
    });
    response.response
}

fn switches(ui: &mut Ui, viewer: &Viewer, done: &mut Vec<Done>) {
    let mut live = viewer.is_live();
    let hint = "render whenever the camera rests";
    if ui.checkbox(&mut live, "live").on_hover_text(hint).changed() {
        done.push(Done::Changed(PanelChange::Live(live)));
    }
    let mut beyond = viewer.goes_beyond();
    let hint = "renders go on beyond the samples per pixel, until Esc";
    if ui.checkbox(&mut beyond, "go on and on").on_hover_text(hint).changed() {
        done.push(Done::Changed(PanelChange::Beyond(beyond)));
    }
    let mut wireframe = viewer.is_wireframe();
    if ui.checkbox(&mut wireframe, "wireframe").on_hover_text("key: w").changed() {
        done.push(Done::Key(crate::keys::KeyPress::char('w')));
    }
}

/// The command that gives the same image.
fn command(ui: &mut Ui, viewer: &Viewer, shown: &Shown<'_>) {
    let Some(command) = shown.command else { return };
    let beyond = viewer.goes_beyond() && matches!(viewer.mode(), Mode::Rendered(_));
    let title = match command {
        Ok(_) if beyond => "its first samples as a command",
        Ok(_) => "the same from the command line",
        Err(_) => "no command gives the same",
    };
    let text = match command {
        Ok(text) | Err(text) => text,
    };
    // A row that is too wide would widen the panel, and so change the picture's size.
    ui.horizontal_wrapped(|ui| {
        ui.label(title);
        if ui.button("Copy").clicked() {
            ui.ctx().copy_text(text.clone());
        }
    });
    ui.add(egui::Label::new(egui::RichText::new(text).monospace()).wrap().selectable(true));
}

/// What a person should know of the scene.
fn notes(ui: &mut Ui, viewer: &Viewer, shown: &Shown<'_>) {
    let Some(session) = shown.session else { return };
    let preview = session.preview().note.as_deref().filter(|_| viewer.mode() == Mode::Raster);
    let warnings = Some(session.warnings()).filter(|text| !text.is_empty());
    for note in preview.into_iter().chain(warnings) {
        ui.separator();
        ui.add(egui::Label::new(note).wrap().selectable(true));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_short() {
        assert_eq!([0.04, 59.9, 61.0, 3725.0].map(duration), ["0.0 s", "59.9 s", "1 min 01 s", "1 h 02 min"]);
    }

    #[test]
    fn the_rate_tells_what_is_left_and_what_was_dropped() {
        let mut figures =
            Figures { samples_per_second: 2.5e6, seconds: 3.0, seconds_left: 61.0, ..Figures::default() };
        assert_eq!(rate(&figures), "2.50 Msamples/s, 3.0 s so far, 1 min 01 s left");
        (figures.seconds_left, figures.non_finite) = (f64::INFINITY, 2);
        assert_eq!(rate(&figures), "2.50 Msamples/s, 3.0 s so far, 2 samples dropped");
    }
}
