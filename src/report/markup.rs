//! HTML that is well formed and escaped by construction: only texts of the program itself go in as they are, and every element is closed
//! where its contents end.

/// A document under way.
#[derive(Default)]
pub struct Markup {
    out: String,
}

/// Name and value.
pub type Attribute<'a> = (&'static str, &'a str);

impl Markup {
    /// Text of the program, as it is.
    pub fn raw(&mut self, text: &'static str) -> &mut Self {
        self.out.push_str(text);
        self
    }

    /// Any text, escaped. Characters that no document may hold show as U+FFFD.
    pub fn text(&mut self, text: &str) -> &mut Self {
        for c in text.chars() {
            match c {
                '&' => self.out.push_str("&amp;"),
                '<' => self.out.push_str("&lt;"),
                '>' => self.out.push_str("&gt;"),
                '"' => self.out.push_str("&quot;"),
                '\'' => self.out.push_str("&#39;"),
                '\n' | '\t' => self.out.push(c),
                c if c.is_control() => self.out.push('\u{fffd}'),
                c => self.out.push(c),
            }
        }
        self
    }

    /// An element with what `inside` writes.
    pub fn element(
        &mut self,
        tag: &'static str,
        attributes: &[Attribute],
        inside: impl FnOnce(&mut Self),
    ) -> &mut Self {
        self.void(tag, attributes);
        inside(self);
        self.out.push_str("</");
        self.out.push_str(tag);
        self.out.push('>');
        self
    }

    /// An element that holds a text.
    pub fn with_text(&mut self, tag: &'static str, attributes: &[Attribute], text: &str) -> &mut Self {
        self.element(tag, attributes, |m| {
            m.text(text);
        })
    }

    /// An element that can hold nothing, such as `img`.
    pub fn void(&mut self, tag: &'static str, attributes: &[Attribute]) -> &mut Self {
        self.out.push('<');
        self.out.push_str(tag);
        for (name, value) in attributes {
            self.out.push(' ');
            self.out.push_str(name);
            self.out.push_str("=\"");
            self.text(value);
            self.out.push('"');
        }
        self.out.push('>');
        self
    }

    /// The head of a table: titles and classes of its columns.
    pub fn heads(&mut self, columns: &[(&str, &str)]) -> &mut Self {
        self.element("thead", &[], |m| {
            m.element("tr", &[], |m| {
                for (title, class) in columns {
                    m.with_text("th", &[("class", class), ("scope", "col")], title);
                }
            });
        })
    }

    pub fn finish(self) -> String {
        self.out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_cannot_become_markup() {
        let mut m = Markup::default();
        let evil = "</script><b a='\"'>&\u{0}";
        m.element("p", &[("title", evil)], |m| {
            m.text(evil).void("img", &[("alt", "é")]);
        });
        let escaped = "&lt;/script&gt;&lt;b a=&#39;&quot;&#39;&gt;&amp;\u{fffd}";
        assert_eq!(m.finish(), format!("<p title=\"{escaped}\">{escaped}<img alt=\"é\"></p>"));
    }
}
