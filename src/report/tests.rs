//! The page as a whole: what it holds, that it is well formed, and that nothing in it can become markup.

use super::*;

/// Text that would do harm, were it not escaped.
const EVIL: &str = "<script>alert(\"1\")</script><img src=x onerror='alert(2)'>&amp;";

fn picture() -> Vec<u8> {
    let mut out = std::io::Cursor::new(Vec::new());
    image::RgbImage::new(2, 2).write_to(&mut out, image::ImageFormat::Png).unwrap();
    out.into_inner()
}

/// A page in which every part is there and every text is `text`.
fn full(text: &str) -> Page {
    let word = || text.to_owned();
    let node =
        |name: &str, runs: u64| Node { name: name.into(), kind: word(), mapped: runs > 1, hits: 3, runs, seconds: 0.5 };
    let reason = |node: &str, from: Option<&str>| Reason {
        node: node.into(),
        did: format!("{node} ran"),
        cause: word(),
        from: from.map(str::to_owned),
    };
    let compared = Shown::Compared { size: [2, 2], original: picture(), stand_in: picture(), difference: picture() };
    let alone = Shown::Alone { size: [2, 2], picture: picture() };
    let view = |shown| View { titles: vec![word(), word()], place: word(), shown };
    Page {
        name: word(),
        about: word(),
        file: word(),
        sources: vec![word()],
        knobs: vec![(word(), word())],
        at: word(),
        seconds: 1.0,
        peak_memory: Some(1 << 20),
        warnings: 1,
        rejected: Some(word()),
        bounds: vec![
            Bound { node: word(), path: word(), about: word(), unit: word(), ..Bound::default() },
            Bound { measured: Some(1.0), max: Some(2.0), met: true, ..Bound::default() },
        ],
        certificates: vec![Certificate {
            path: word(),
            verdict: Some(word()),
            sentence: word(),
            costs: vec![Cost { what: "Triangles", unit: Unit::Count, before: Some(158_978.0), after: 1950.0 }],
            series: vec![Series {
                title: word(),
                unit: "px",
                higher_is_better: false,
                values: vec![0.0, 1.0, 9.0],
                of: "views",
            }],
            figures: vec![Figure { about: word(), path: word(), value: 1.0, unit: word() }],
            views: vec![view(compared), view(alone)],
            legend: vec![([1, 2, 3], word())],
            other_pictures: vec![word()],
        }],
        nodes: vec![node(text, 1), node("b", 7), node("c", 0)],
        edges: vec![
            Edge { from: 0, to: 1, label: word(), list: true },
            Edge { from: 0, to: 2, label: word(), list: false },
            Edge { from: 1, to: 2, label: word(), list: false },
        ],
        reasons: vec![reason(text, None), reason("b", Some(text)), reason("c", Some("b"))],
        files: vec![File { path: word(), bytes: 10 }],
        version: word(),
    }
}

/// The tags of a document in their order, each with its attributes; every element is closed where it was opened. What stands in `style` and `script` is
/// text.
fn tags(html: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut open: Vec<&str> = Vec::new();
    let mut rest = html;
    while let Some(at) = rest.find('<') {
        rest = &rest[at + 1..];
        let end = rest.find('>').expect("a tag ends");
        let tag = &rest[..end];
        rest = &rest[end + 1..];
        match tag.strip_prefix('/') {
            Some(name) => assert_eq!(open.pop(), Some(name), "closed where it was opened"),
            None => {
                let name = tag.split(' ').next().unwrap();
                assert_eq!(tag.matches('"').count() % 2, 0, "{tag}");
                found.push(tag.to_owned());
                if name == "style" || name == "script" {
                    rest = &rest[rest.find(&format!("</{name}>")).expect("it ends")..];
                }
                if !["meta", "img", "br", "input"].contains(&name) {
                    open.push(name);
                }
            }
        }
    }
    assert_eq!(open, Vec::<&str>::new());
    found
}

#[test]
fn a_page_is_well_formed_and_has_all_parts() {
    let html = html(&full("text"));
    let tags = tags(&html);
    for id in ["budget", "requirements", "views", "errors", "figures", "graph", "why", "settings"] {
        assert!(tags.iter().any(|t| *t == format!("section id=\"{id}\"")), "{id}");
    }
    assert_eq!(tags.iter().filter(|t| t.starts_with("img src=\"data:image/png;base64,")).count(), 4);
    assert_eq!(tags.iter().filter(|t| t.starts_with("path class=\"edge")).count(), 3);
    assert_eq!(tags.iter().filter(|t| t.starts_with("g class=\"node")).count(), 3);
    for text in ["82 × less", "158,978", "Rejected", "1 of 2 met", "missed: the certificate has no such number"] {
        assert!(html.contains(text), "{text}");
    }
}

#[test]
fn nothing_is_loaded_from_elsewhere() {
    let html = html(&full("text"));
    assert!(!html.contains("://"), "{:?}", html.find("://").map(|at| &html[at - 40..at + 20]));
    for tag in tags(&html) {
        assert!(!tag.contains("src=") || tag.contains("src=\"data:image/png;base64,"), "{tag}");
        assert!(!tag.starts_with("link ") && !tag.starts_with("iframe"), "{tag}");
        assert!(!tag.contains("href=") || tag.contains("href=\"#") || tag.contains("href=\"./"), "{tag}");
    }
    assert!(!html.contains("@import") && !html.contains("url("));
}

#[test]
fn texts_stay_texts() {
    let (plain, evil) = (html(&full("text")), html(&full(EVIL)));
    let names =
        |html: &str| -> Vec<String> { tags(html).iter().map(|t| t.split(' ').next().unwrap().to_owned()).collect() };
    assert_eq!(names(&plain), names(&evil), "no text opens an element");
    assert!(!evil.contains("<script>") && !evil.contains("<img src=x"));
    // As the value of an attribute, too.
    assert!(tags(&evil).iter().all(|t| !t.contains("onerror") || t.contains("&lt;img") || t.contains("%3Cimg")));
    assert_eq!(evil.matches("</script>").count(), 1);
}

#[test]
fn a_bake_without_certificates_has_a_page_too() {
    let empty = html(&Page::default());
    tags(&empty);
    let page = Page { nodes: full("text").nodes, edges: full("text").edges, ..Page::default() };
    let html = html(&page);
    assert!(
        tags(&html).iter().all(|t| !t.starts_with("section id=\"views\"") && !t.starts_with("section id=\"errors\""))
    );
    assert!(html.contains("1 of 3 nodes") || html.contains("2 of 3 nodes"), "{html}");
}

#[test]
fn reasons_form_a_tree_whatever_they_say() {
    // Two that name each other never end up below each other for ever.
    let mut page = full("text");
    page.reasons[0].from = Some("c".into());
    tags(&html(&page));
    // Many that began alike are one line.
    let alike =
        |node: &str| Reason { node: node.into(), did: format!("{node} ran"), cause: "first".into(), from: None };
    page.reasons = ["a", "b", "c"].map(alike).to_vec();
    assert!(html(&page).contains("<b>a, b, c</b> ran: first"));
}
