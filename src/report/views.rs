//! The worst views as a viewer: original and stand-in under one slider, the difference beside them. Without a script they stand side by side.

use super::{
    Certificate, Shown, View,
    markup::{Attribute, Markup},
    numbers::count,
    pictures::data_uri,
};

/// `prefix` tells the views of several certificates apart.
pub fn views(m: &mut Markup, certificate: &Certificate, prefix: &str) {
    m.element("div", &[("class", "viewer")], |m| {
        if certificate.views.len() > 1 {
            m.element("nav", &[("aria-label", "Views")], |m| {
                for (k, view) in certificate.views.iter().enumerate() {
                    let href = format!("#{prefix}{k}");
                    m.with_text("a", &[("href", &href)], view.titles.first().map_or("", |t| t));
                }
            });
        }
        for (k, view) in certificate.views.iter().enumerate() {
            m.element("section", &[("class", "view"), ("id", &format!("{prefix}{k}"))], |m| one(m, view));
        }
    });
    if !certificate.legend.is_empty() && certificate.views.iter().any(|v| matches!(v.shown, Shown::Compared { .. })) {
        m.element("p", &[("class", "legend")], |m| {
            for ([r, g, b], text) in &certificate.legend {
                m.element("span", &[], |m| {
                    m.element("i", &[("style", &format!("background:rgb({r},{g},{b})"))], |_| {}).text(text);
                });
            }
        });
    }
    if !certificate.other_pictures.is_empty() {
        let rest = count(certificate.other_pictures.len(), "more picture");
        m.element("p", &[("class", "dim")], |m| {
            m.text(&format!("{rest} beside this page: "));
            for (k, path) in certificate.other_pictures.iter().enumerate() {
                m.text(if k == 0 { "" } else { ", " });
                link(m, path);
            }
        });
    }
}

fn one(m: &mut Markup, view: &View) {
    m.element("h4", &[], |m| {
        for (k, title) in view.titles.iter().enumerate() {
            m.raw(if k == 0 { "" } else { "<span class=\"sep\"> · </span>" }).text(title);
        }
    });
    if !view.place.is_empty() {
        m.with_text("p", &[("class", "dim")], &view.place);
    }
    match &view.shown {
        Shown::Compared { size, original, stand_in, difference } => {
            let [width, height] = size.map(|s| s.to_string());
            let pictures: [(&str, &str, &Vec<u8>); 3] = [
                ("original", "original", original),
                ("stand-in", "stand-in", stand_in),
                ("difference", "difference", difference),
            ];
            m.element("div", &[("class", "panels"), ("data-width", &width), ("data-height", &height)], |m| {
                for (class, name, png) in pictures {
                    picture(m, class, name, [&width, &height], png);
                }
            });
        }
        Shown::Alone { size, picture: png } => {
            let [width, height] = size.map(|s| s.to_string());
            m.element("div", &[("class", "alone")], |m| picture(m, "alone", "", [&width, &height], png));
        }
    }
}

fn picture(m: &mut Markup, class: &str, name: &str, [width, height]: [&str; 2], png: &[u8]) {
    m.element("figure", &[("class", class)], |m| {
        let uri = data_uri(png);
        let all: [Attribute; 5] =
            [("src", &uri), ("alt", name), ("width", width), ("height", height), ("draggable", "false")];
        m.void("img", &all);
        if !name.is_empty() {
            m.with_text("figcaption", &[], name);
        }
    });
}

/// A link to a file beside the page.
pub fn link(m: &mut Markup, path: &str) {
    // A path is no address: what means something in one is written as its bytes.
    let mut href = String::from("./");
    for byte in path.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' | b'/' => href.push(char::from(byte)),
            _ => href += &format!("%{byte:02X}"),
        }
    }
    m.with_text("a", &[("href", &href)], path);
}
