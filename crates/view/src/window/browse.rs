//! The dialogue for files: a path to type, and the folder to choose from.
//!
//! It is drawn in the window, so it works wherever the window does: with no desktop, no portal, over a network.

use eframe::egui;
use penombre_image::Format;
use std::path::{Path, PathBuf};

/// Most entries of a folder that are listed.
const MOST_ENTRIES: usize = 2000;

/// What the file is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// A scene to open: it must exist.
    Open,
    /// A place for an image: an existing file is asked about.
    Save,
}

/// How the dialogue ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Choice {
    /// This file.
    File(PathBuf),
    /// None.
    Closed,
}

/// An open dialogue.
#[derive(Debug)]
pub struct Browser {
    purpose: Purpose,
    folder: PathBuf,
    /// What stands in the field: a path from the folder, or an absolute one.
    text: String,
    entries: Vec<Entry>,
    /// What is wrong with the choice, for a person.
    fault: String,
    /// The existing file that the next confirmation replaces.
    replace: Option<PathBuf>,
    /// True until the field has the keyboard.
    fresh: bool,
}

#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Entry {
    /// Folders come first.
    is_file: bool,
    name: String,
}

impl Browser {
    /// Opens the dialogue in a folder with a proposal.
    pub fn new(purpose: Purpose, folder: &Path, proposal: &str) -> Self {
        let mut browser = Self {
            purpose,
            folder: PathBuf::new(),
            text: proposal.to_owned(),
            entries: Vec::new(),
            fault: String::new(),
            replace: None,
            fresh: true,
        };
        browser.enter(folder);
        browser
    }

    /// What the file is for.
    pub fn purpose(&self) -> Purpose {
        self.purpose
    }

    /// Draws it; the choice, once there is one.
    pub fn show(&mut self, ctx: &egui::Context) -> Option<Choice> {
        let title = match self.purpose {
            Purpose::Open => "Open a scene",
            Purpose::Save => "Save the image",
        };
        let modal = egui::Modal::new(egui::Id::unique("files")).show(ctx, |ui| {
            ui.set_width((ui.ctx().content_rect().width() - 60.0).clamp(160.0, 460.0));
            ui.heading(title);
            self.contents(ui)
        });
        let closed = modal.should_close().then_some(Choice::Closed);
        modal.inner.or(closed)
    }

    fn contents(&mut self, ui: &mut egui::Ui) -> Option<Choice> {
        ui.horizontal(|ui| {
            if ui.button("Up").on_hover_text("the folder above").clicked()
                && let Some(above) = self.folder.parent().map(Path::to_owned)
            {
                self.enter(&above);
            }
            ui.label(self.folder.display().to_string());
        });
        let chosen = self.list(ui);
        let field = egui::TextEdit::singleline(&mut self.text).desired_width(f32::INFINITY).id_salt("path");
        let mut output = field.show(ui);
        output.response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::TextInput, true, "File name"));
        if std::mem::take(&mut self.fresh) {
            output.response.request_focus();
            select_all(ui.ctx(), &mut output, &self.text);
        }
        let enter = output.response.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter));
        if !self.fault.is_empty() {
            ui.colored_label(ui.visuals().warn_fg_color, &self.fault);
        }
        let mut choice = None;
        ui.horizontal(|ui| {
            let word = match (self.purpose, &self.replace) {
                (Purpose::Open, _) => "Open",
                (Purpose::Save, None) => "Save",
                (Purpose::Save, Some(_)) => "Replace",
            };
            if ui.button(word).clicked() || enter || chosen {
                choice = self.confirm();
                self.fresh = choice.is_none();
            }
            if ui.button("Cancel").clicked() {
                choice = Some(Choice::Closed);
            }
        });
        choice
    }

    /// The folder's entries; true if a file was chosen for good.
    fn list(&mut self, ui: &mut egui::Ui) -> bool {
        let (mut entered, mut chosen) = (None, false);
        let height = (ui.ctx().content_rect().height() - 220.0).clamp(40.0, 260.0);
        egui::ScrollArea::vertical().max_height(height).min_scrolled_height(height).show(ui, |ui| {
            ui.set_min_size(egui::vec2(ui.available_width(), height));
            for entry in &self.entries {
                let shown = if entry.is_file { entry.name.clone() } else { format!("{}/", entry.name) };
                let label = egui::Button::selectable(self.text == entry.name, shown).truncate();
                let response = ui.add(label);
                if entry.is_file && response.clicked() {
                    self.text.clone_from(&entry.name);
                    self.replace = None;
                }
                chosen |= entry.is_file && response.double_clicked();
                if !entry.is_file && response.clicked() {
                    entered = Some(self.folder.join(&entry.name));
                }
            }
        });
        if let Some(folder) = entered {
            self.enter(&folder);
        }
        chosen
    }

    /// Goes to a folder, if it can be read.
    fn enter(&mut self, folder: &Path) {
        self.replace = None;
        let folder = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
        match entries(&folder, self.purpose) {
            Ok(entries) => (self.folder, self.entries, self.fault) = (folder, entries, String::new()),
            Err(error) => self.fault = format!("{}: {error}", folder.display()),
        }
    }

    /// What the field names: a folder is entered, an existing image asked about once.
    fn confirm(&mut self) -> Option<Choice> {
        let path = self.folder.join(self.text.trim());
        if self.text.trim().is_empty() || path.is_dir() {
            self.enter(&path);
            self.text.clear();
            return None;
        }
        let folder = path.parent().is_some_and(Path::is_dir);
        match self.purpose {
            Purpose::Save if !folder => {
                self.fault = format!("there is no folder for {}", path.display());
                None
            }
            Purpose::Save if let Err(error) = Format::from_path(&path) => {
                self.fault = error.to_string();
                None
            }
            Purpose::Open if !path.exists() => {
                self.fault = format!("there is no file {}", path.display());
                None
            }
            Purpose::Save if path.exists() && self.replace.as_ref() != Some(&path) => {
                self.fault = format!("{} exists: once more to replace it", path.display());
                self.replace = Some(path);
                None
            }
            _ => Some(Choice::File(path)),
        }
    }
}

/// Files that can be opened.
const SCENES: [&str; 5] = ["toml", "obj", "off", "ply", "stl"];

impl Purpose {
    /// Whether a file of that name is of interest.
    fn lists(self, name: &str) -> bool {
        let path = Path::new(name);
        match self {
            Self::Open => {
                SCENES.iter().any(|scene| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(scene)))
            }
            Self::Save => Format::from_path(path).is_ok(),
        }
    }
}

/// Folders, then files of interest; hidden ones are left out.
fn entries(folder: &Path, purpose: Purpose) -> std::io::Result<Vec<Entry>> {
    let mut entries = Vec::new();
    for entry in std::fs::read_dir(folder)?.flatten().take(MOST_ENTRIES) {
        // What links lead to counts.
        let is_file = !entry.path().is_dir();
        if let Ok(name) = entry.file_name().into_string()
            && !name.starts_with('.')
            && (!is_file || purpose.lists(&name))
        {
            entries.push(Entry { is_file, name });
        }
    }
    entries.sort();
    Ok(entries)
}

/// Selects what stands in the field, so that typing replaces it.
fn select_all(ctx: &egui::Context, output: &mut egui::text_edit::TextEditOutput, text: &str) {
    use egui::text::{CCursor, CCursorRange};
    let range = CCursorRange::two(CCursor::new(0), CCursor::new(text.chars().count()));
    output.state.cursor.set_char_range(Some(range));
    output.state.clone().store(ctx, output.response.id);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_are_entered_and_files_chosen() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("sub")).unwrap();
        for name in ["b.toml", "a.toml", ".hidden", "sub/c.obj"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        let mut browser = Browser::new(Purpose::Open, folder.path(), "");
        let names = |b: &Browser| b.entries.iter().map(|e| e.name.clone()).collect::<Vec<_>>();
        assert_eq!(names(&browser), ["sub", "a.toml", "b.toml"]);
        browser.text = "sub".to_owned();
        assert_eq!(browser.confirm(), None);
        assert_eq!(names(&browser), ["c.obj"]);
        browser.text = "gone.obj".to_owned();
        assert_eq!(browser.confirm(), None);
        assert!(browser.fault.contains("there is no file"));
        browser.text = "../a.toml".to_owned();
        let Some(Choice::File(path)) = browser.confirm() else { panic!() };
        assert_eq!(path.canonicalize().unwrap(), folder.path().join("a.toml").canonicalize().unwrap());
    }

    #[test]
    fn an_existing_image_is_asked_about() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("old.png"), "").unwrap();
        let mut browser = Browser::new(Purpose::Save, folder.path(), "new.png");
        assert_eq!(browser.confirm(), Some(Choice::File(folder.path().join("new.png"))));
        browser.text = "old.png".to_owned();
        assert_eq!(browser.confirm(), None);
        assert!(browser.fault.contains("exists"));
        assert_eq!(browser.confirm(), Some(Choice::File(folder.path().join("old.png"))));
        browser.enter(&folder.path().join("nowhere"));
        assert!(browser.fault.contains("nowhere") && browser.folder == folder.path());
    }
}
