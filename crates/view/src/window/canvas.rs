//! Mouse and keyboard of the picture, as the state machine takes them.

use crate::camera::Button;
use crate::keys::{Key, KeyPress};
use crate::state::Input;
use eframe::egui::{self, Event, PointerButton};
use penombre_math::Vec2;
use std::collections::BTreeSet;

/// Points of a touchpad's scroll that count as one step of a wheel.
const POINTS_PER_STEP: f32 = 50.0;

/// A drag that began in the picture.
#[derive(Clone, Copy, Debug)]
struct Drag {
    button: Button,
    /// Where the mouse was last, points.
    at: egui::Pos2,
}

/// Turns the window's events into inputs. Every movement counts by itself, for turning is not the same in one step as
/// in two.
#[derive(Debug, Default)]
pub struct Canvas {
    drag: Option<Drag>,
    /// Keys that are down, by their place on the keyboard: what a place types changes with Shift.
    held: BTreeSet<egui::Key>,
}

/// Where the picture is, and who may hear.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// The picture, points.
    pub rect: egui::Rect,
    /// Pixels per point.
    pub scale: f32,
    /// True if the mouse is over the picture and nothing lies on top.
    pub hovered: bool,
    /// True if the keyboard belongs to no field.
    pub keyboard: bool,
}

impl Canvas {
    /// The inputs of a frame, in order.
    pub fn inputs(&mut self, events: &[Event], place: &Place) -> Vec<Input> {
        let mut inputs = Vec::new();
        let mut repeated = false;
        for event in events {
            match event {
                Event::Key { pressed: true, repeat, key, physical_key, modifiers } => {
                    // The text of a key that is held down follows its event.
                    repeated = physical_key.map_or(*repeat, |place| !self.held.insert(place));
                    if place.keyboard && !repeated {
                        inputs.extend(key_press(*key, *modifiers).map(Input::Key));
                    }
                }
                Event::Key { pressed: false, physical_key: Some(place), .. } => {
                    self.held.remove(place);
                }
                Event::Text(text) if place.keyboard && !repeated => {
                    inputs.extend(text.chars().map(|c| Input::Key(KeyPress::char(c))));
                }
                Event::PointerButton { pos, button, pressed, .. } => {
                    self.button(*pos, *button, *pressed, place);
                }
                Event::PointerMoved(pos) => inputs.extend(self.moved(*pos, place)),
                Event::MouseWheel { unit, delta, modifiers, .. } if place.hovered && !modifiers.command => {
                    let steps = match unit {
                        egui::MouseWheelUnit::Point => delta.y / POINTS_PER_STEP,
                        egui::MouseWheelUnit::Line | egui::MouseWheelUnit::Page => delta.y,
                    };
                    inputs.push(Input::Wheel(steps));
                }
                Event::WindowFocused(false) => *self = Self::default(),
                _ => {}
            }
        }
        inputs
    }

    fn button(&mut self, at: egui::Pos2, button: PointerButton, pressed: bool, place: &Place) {
        let button = match button {
            PointerButton::Primary => Button::Left,
            PointerButton::Middle => Button::Middle,
            PointerButton::Secondary => Button::Right,
            _ => return,
        };
        if pressed && self.drag.is_none() && place.hovered && place.rect.contains(at) {
            self.drag = Some(Drag { button, at });
        } else if !pressed && self.drag.is_some_and(|drag| drag.button == button) {
            self.drag = None;
        }
    }

    fn moved(&mut self, to: egui::Pos2, place: &Place) -> Option<Input> {
        let drag = self.drag.as_mut()?;
        let from = std::mem::replace(&mut drag.at, to);
        let pixels = |p: egui::Vec2| Vec2::new(p.x, p.y) * place.scale;
        Some(Input::Drag {
            button: drag.button,
            from: pixels(from - place.rect.min),
            to: pixels(to - place.rect.min),
            window: pixels(place.rect.size()),
        })
    }
}

/// What a key means that types no text: keys that do come as text.
fn key_press(key: egui::Key, modifiers: egui::Modifiers) -> Option<KeyPress> {
    if modifiers.command {
        let name = key.symbol_or_name();
        let mut letters = name.chars();
        // Ctrl with plus, minus and 0 is the size of the window's text.
        return match (letters.next(), letters.next()) {
            (Some(c), None) if c.is_ascii_alphabetic() => Some(KeyPress::ctrl(c.to_ascii_lowercase())),
            _ => None,
        };
    }
    match key {
        egui::Key::Escape => Some(KeyPress::key(Key::Escape)),
        egui::Key::Home => Some(KeyPress::key(Key::Home)),
        _ if is_other(key) => Some(KeyPress::key(Key::Other)),
        // It comes as text, moves the keyboard between fields, or only changes what others mean.
        _ => None,
    }
}

/// True for keys that a person presses for what they do and that type nothing.
fn is_other(key: egui::Key) -> bool {
    use egui::Key as K;
    let named = [K::ArrowUp, K::ArrowDown, K::ArrowLeft, K::ArrowRight, K::Insert, K::Delete];
    let paging = [K::End, K::PageUp, K::PageDown, K::Backspace];
    let function = key.name().strip_prefix('F').is_some_and(|n| n.parse::<u8>().is_ok());
    named.contains(&key) || paging.contains(&key) || function
}

#[cfg(test)]
mod tests {
    use super::*;
    use eframe::egui::{Modifiers, pos2, vec2};

    fn place() -> Place {
        let rect = egui::Rect::from_min_size(pos2(10.0, 0.0), vec2(240.0, 240.0));
        Place { rect, scale: 2.0, hovered: true, keyboard: true }
    }

    fn key(key: egui::Key, repeat: bool, modifiers: Modifiers) -> Event {
        Event::Key { key, physical_key: None, pressed: true, repeat, modifiers }
    }

    fn button(pressed: bool, at: egui::Pos2) -> Event {
        let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
        Event::PointerButton { pos: at, button, pressed, modifiers }
    }

    #[test]
    fn keys_come_once() {
        let events = [
            key(egui::Key::R, false, Modifiers::NONE),
            Event::Text("r".into()),
            key(egui::Key::R, true, Modifiers::NONE),
            Event::Text("r".into()),
            key(egui::Key::S, false, Modifiers::COMMAND),
            key(egui::Key::Escape, false, Modifiers::NONE),
            key(egui::Key::ArrowUp, false, Modifiers::NONE),
            key(egui::Key::F5, false, Modifiers::NONE),
        ];
        let found: Vec<KeyPress> = Canvas::default()
            .inputs(&events, &place())
            .iter()
            .map(|input| match input {
                Input::Key(press) => *press,
                other => panic!("{other:?}"),
            })
            .collect();
        let expected = [
            KeyPress::char('r'),
            KeyPress::ctrl('s'),
            KeyPress::key(Key::Escape),
            KeyPress::key(Key::Other),
            KeyPress::key(Key::Other),
        ];
        assert_eq!(found, expected);
        let deaf = Place { keyboard: false, ..place() };
        assert!(Canvas::default().inputs(&events, &deaf).is_empty());
    }

    /// Shift goes up before the key that it changed: the next press counts all the same, and Shift alone does nothing.
    #[test]
    fn shifted_keys_come_once_each_time() {
        let mut canvas = Canvas::default();
        let event = |key, physical, pressed| Event::Key {
            key,
            physical_key: Some(physical),
            pressed,
            // What egui says here cannot be relied on.
            repeat: pressed && key == egui::Key::Plus,
            modifiers: Modifiers::NONE,
        };
        for _ in 0..3 {
            let events = [
                event(egui::Key::ShiftLeft, egui::Key::ShiftLeft, true),
                event(egui::Key::Plus, egui::Key::Equals, true),
                Event::Text("+".into()),
                event(egui::Key::Plus, egui::Key::Equals, true),
                Event::Text("+".into()),
                event(egui::Key::ShiftLeft, egui::Key::ShiftLeft, false),
                event(egui::Key::Equals, egui::Key::Equals, false),
            ];
            let found = canvas.inputs(&events, &place());
            assert!(matches!(found[..], [Input::Key(press)] if press == KeyPress::char('+')), "{found:?}");
        }
    }

    #[test]
    fn every_movement_of_a_drag_counts_in_pixels() {
        let mut canvas = Canvas::default();
        let events = [
            Event::PointerMoved(pos2(5.0, 5.0)),
            button(true, pos2(20.0, 20.0)),
            Event::PointerMoved(pos2(30.0, 25.0)),
            Event::PointerMoved(pos2(300.0, 25.0)),
            button(false, pos2(300.0, 25.0)),
            Event::PointerMoved(pos2(40.0, 25.0)),
        ];
        let found: Vec<(Vec2, Vec2)> = canvas
            .inputs(&events, &place())
            .iter()
            .map(|input| match input {
                Input::Drag { from, to, window, button: Button::Left } => {
                    assert_eq!(*window, Vec2::splat(480.0));
                    (*from, *to)
                }
                other => panic!("{other:?}"),
            })
            .collect();
        let (a, b, c) = (Vec2::new(20.0, 40.0), Vec2::new(40.0, 50.0), Vec2::new(580.0, 50.0));
        assert_eq!(found, [(a, b), (b, c)]);
        // A drag that begins on the panel is none of the picture's.
        let outside = [button(true, pos2(400.0, 20.0)), Event::PointerMoved(pos2(30.0, 25.0))];
        assert!(canvas.inputs(&outside, &place()).is_empty());
    }
}
