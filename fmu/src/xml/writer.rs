//! As much XML as model descriptions need.

/// An XML document in the making.
#[derive(Debug)]
pub(crate) struct Xml {
    text: String,
    depth: usize,
}

/// Name and value; attributes with an empty value are left out.
pub(crate) type Attribute = (&'static str, String);

impl Xml {
    pub(crate) fn new() -> Self {
        Self { text: "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n".to_owned(), depth: 0 }
    }

    pub(crate) fn open(&mut self, name: &str, attributes: &[Attribute]) {
        self.tag(name, attributes, ">");
        self.depth += 1;
    }

    pub(crate) fn leaf(&mut self, name: &str, attributes: &[Attribute]) {
        self.tag(name, attributes, "/>");
    }

    pub(crate) fn close(&mut self, name: &str) {
        self.depth -= 1;
        self.indent();
        self.text.push_str(&format!("</{name}>\n"));
    }

    /// A line that is XML already.
    pub(crate) fn raw(&mut self, line: &str) {
        self.indent();
        self.text.push_str(line);
        self.text.push('\n');
    }

    /// The start value of a text in FMI 3.0, which may be empty.
    pub(crate) fn text_start(&mut self, value: &str) {
        self.raw(&format!("<Start value=\"{}\"/>", escape(value)));
    }

    pub(crate) fn finish(self) -> String {
        self.text
    }

    fn tag(&mut self, name: &str, attributes: &[Attribute], end: &str) {
        self.indent();
        self.text.push('<');
        self.text.push_str(name);
        for (key, value) in attributes.iter().filter(|(_, value)| !value.is_empty()) {
            self.text.push_str(&format!(" {key}=\"{}\"", escape(value)));
        }
        self.text.push_str(end);
        self.text.push('\n');
    }

    fn indent(&mut self) {
        self.text.push_str(&"  ".repeat(self.depth));
    }
}

/// A number as XML Schema's double; the shortest text that reads back to the same bits.
pub(crate) fn number(value: f64) -> String {
    format!("{value:?}")
}

fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn special_characters_are_escaped_and_empty_attributes_left_out() {
        let mut xml = Xml::new();
        xml.leaf("A", &[("x", "<\"&\">".to_owned()), ("y", String::new())]);
        assert!(xml.finish().ends_with("<A x=\"&lt;&quot;&amp;&quot;&gt;\"/>\n"));
    }
}
