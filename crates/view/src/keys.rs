//! Which key does what: one table, from which the help text is made as well.
//!
//! The course's keys come first and win. Any key that is not in the table shows the help, as in the course.

/// A key as the keyboard's layout says it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Key {
    /// A key that types a character, Shift applied: `'+'`, `'?'`, `'r'`.
    Char(char),
    /// Esc.
    Escape,
    /// Home.
    Home,
    /// Any other key. Keys that only modify others are not to be reported.
    Other,
}

/// A key with the modifier that counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KeyPress {
    /// The key.
    pub key: Key,
    /// True with Ctrl (or the command key of macOS) held.
    pub ctrl: bool,
}

impl KeyPress {
    /// A character alone.
    pub const fn char(c: char) -> Self {
        Self { key: Key::Char(c), ctrl: false }
    }

    /// A character with Ctrl.
    pub const fn ctrl(c: char) -> Self {
        Self { key: Key::Char(c), ctrl: true }
    }

    /// A key alone.
    pub const fn key(key: Key) -> Self {
        Self { key, ctrl: false }
    }

    fn name(&self) -> String {
        let name = match self.key {
            Key::Char(c) if self.ctrl => c.to_uppercase().to_string(),
            Key::Char(c) => c.to_string(),
            Key::Escape => "Esc".to_owned(),
            Key::Home => "Home".to_owned(),
            Key::Other => "any other key".to_owned(),
        };
        if self.ctrl { format!("Ctrl-{name}") } else { name }
    }
}

/// What keys do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// Renders and saves.
    Render,
    /// The next of the course's scenes.
    NextScene,
    /// The one before.
    PreviousScene,
    /// Wireframe on or off.
    Wireframe,
    /// Full screen on or off.
    Fullscreen,
    /// Ends the program.
    Quit,
    /// Cancels a render, or ends the program if there is none.
    CancelOrQuit,
    /// Shows all of the scene.
    Frame,
    /// The scene's own camera.
    Home,
    /// Looks from the front.
    Front,
    /// Looks from the right.
    Right,
    /// Looks from above.
    Top,
    /// Opens a file.
    Open,
    /// Saves the image.
    Save,
    /// Shows the help.
    Help,
}

/// A line of the table.
#[derive(Clone, Copy, Debug)]
pub struct Binding {
    /// The keys; any of them does it.
    pub keys: &'static [KeyPress],
    /// What they do.
    pub command: Command,
    /// What they do, for a person.
    pub help: &'static str,
}

/// Every binding, in the order of the help.
pub const BINDINGS: &[Binding] = &[
    bind(&[KeyPress::char('r')], Command::Render, "render from here, write rendu.ppm and rendu.png"),
    bind(&[KeyPress::char('+')], Command::NextScene, "next scene of the course"),
    bind(&[KeyPress::char('-')], Command::PreviousScene, "previous scene of the course"),
    bind(&[KeyPress::char('w')], Command::Wireframe, "wireframe on, off"),
    bind(&[KeyPress::char('f')], Command::Fullscreen, "full screen on, off"),
    bind(&[KeyPress::key(Key::Escape)], Command::CancelOrQuit, "cancel what goes on; else quit"),
    bind(&[KeyPress::char('q'), KeyPress::ctrl('q')], Command::Quit, "quit"),
    bind(&[KeyPress::char('.')], Command::Frame, "show all of the scene"),
    bind(&[KeyPress::key(Key::Home)], Command::Home, "back to the scene's camera"),
    bind(&[KeyPress::char('1')], Command::Front, "look from the front"),
    bind(&[KeyPress::char('3')], Command::Right, "look from the right"),
    bind(&[KeyPress::char('7')], Command::Top, "look from above"),
    bind(&[KeyPress::ctrl('o')], Command::Open, "open a file (or drop one on the window)"),
    bind(&[KeyPress::ctrl('s')], Command::Save, "save the image"),
    bind(&[KeyPress::char('?'), KeyPress::key(Key::Other)], Command::Help, "this help"),
];

/// What the mouse does, in the order of the help.
const MOUSE: &[[&str; 2]] =
    &[["left drag", "turn"], ["right drag", "move the picture"], ["middle drag, wheel", "nearer, farther"]];

const fn bind(keys: &'static [KeyPress], command: Command, help: &'static str) -> Binding {
    Binding { keys, command, help }
}

/// What a key does; keys without a binding show the help. Letters count whether or not Shift or Caps Lock is on.
pub fn command(press: KeyPress) -> Command {
    let lower = |c: char| c.to_lowercase().next().unwrap_or(c);
    let press = match press.key {
        Key::Char(c) => KeyPress { key: Key::Char(lower(c)), ..press },
        _ => press,
    };
    BINDINGS.iter().find(|b| b.keys.contains(&press)).map_or(Command::Help, |b| b.command)
}

/// The help, one line for each binding.
pub fn help_text() -> String {
    let keys = |b: &Binding| b.keys.iter().map(KeyPress::name).collect::<Vec<_>>().join(", ");
    let lines = BINDINGS.iter().map(|b| [keys(b), b.help.to_owned()]);
    let mouse = MOUSE.iter().map(|line| line.map(str::to_owned));
    lines.chain(mouse).map(|[what, help]| format!("{what:<20}{help}\n")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_keys_of_the_course_win() {
        let course = [
            ('r', Command::Render),
            ('+', Command::NextScene),
            ('w', Command::Wireframe),
            ('f', Command::Fullscreen),
            ('q', Command::Quit),
            ('?', Command::Help),
        ];
        for (key, expected) in course {
            assert_eq!(command(KeyPress::char(key)), expected);
        }
        assert_eq!(command(KeyPress::key(Key::Escape)), Command::CancelOrQuit);
        assert_eq!(command(KeyPress::char('R')), Command::Render);
    }

    #[test]
    fn any_other_key_shows_the_help() {
        for press in
            [KeyPress::char('g'), KeyPress::char('2'), KeyPress::ctrl('r'), KeyPress::key(Key::Other)]
        {
            assert_eq!(command(press), Command::Help);
        }
    }

    #[test]
    fn no_key_has_two_meanings_and_all_are_in_the_help() {
        let all: Vec<KeyPress> = BINDINGS.iter().flat_map(|b| b.keys).copied().collect();
        for (i, press) in all.iter().enumerate() {
            assert!(!all[..i].contains(press), "{press:?}");
        }
        let help = help_text();
        for binding in BINDINGS {
            let line = help.lines().find(|l| l.split_at(20).1 == binding.help).unwrap();
            assert!(binding.keys.iter().all(|k| line.contains(&k.name())), "{line}");
        }
        assert_eq!(help.lines().count(), BINDINGS.len() + 3);
        assert!(help.contains("Ctrl-S"));
    }
}
