//! Whatever a file holds, checking it ends in a plan or a report.

use super::check;
use proptest::prelude::*;

/// Pieces of pipeline files, sound and not.
const PIECES: &[&str] = &[
    "[pipeline]\n",
    "base = \"stock\"\n",
    "name = 3\n",
    "[params]\n",
    "scene = \"{scene}\"\n",
    "factor = nan\n",
    "[nodes]\n",
    "[nodes.load]\n",
    "kind = \"load-scene\"\n",
    "path = \"{scene}\"\n",
    "[nodes.mesh]\n",
    "kind = \"voxel-mesh\"\n",
    "scene = \"load\"\n",
    "scene = \"mesh.meshes\"\n",
    "[nodes.collapse]\n",
    "kind = \"collapse\"\n",
    "mesh = \"mesh\"\n",
    "mesh = { from = \"mesh\", via = \"cells.neighbours\" }\n",
    "factor = \"{factor}\"\n",
    "factor = 1e999\n",
    "policy = \"q\"\n",
    "kind = \"simplify\"\n",
    "method = \"sharp\"\n",
    "method = 3\n",
    "per = [\"mesh\", 1]\n",
    "cross = true\n",
    "join = \"inner\"\n",
    "[nodes.cells]\n",
    "kind = \"hex-cells\"\n",
    "[nodes.far]\n",
    "pipeline = \"part\"\n",
    "pipeline = \"through\"\n",
    "pipeline = \"first\"\n",
    "meshes = \"far\"\n",
    "[inputs]\n",
    "scene = { type = \"Scene\", default = \"load\" }\n",
    "[outputs]\n",
    "scene = \"far.meshes\"\n",
    "[files]\n",
    "\"../x\" = \"write\"\n",
    "\"{name}\" = \"mesh\"\n",
    "[require.write]\n",
    "a.b = { min = 3, max = 1 }\n",
    "[outputs]\n",
    "= \n",
    "x = [[[[\n",
    "\"\"\"\n",
    "[nodes.\"a b\"]\n",
    "kind = 99999999999999999999999999\n",
    "ä = \"ö\"\n",
    "false = false\n",
    "load = false\n",
    "centre = [1, \"{factor}\"]\n",
    "limits = { angle = {} }\n",
    "[[nodes.load]]\n",
    "kind = 1979-05-27\n",
];

fn render(result: Result<farfield::engine::plan::Plan, farfield::engine::pipeline::Problems>) {
    if let Err(problems) = result {
        assert!(!problems.list.is_empty());
        assert!(!problems.to_string().is_empty());
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_text(text in "\\PC{0,200}") {
        render(check(&text, &[]));
    }

    #[test]
    fn any_bytes(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
        render(check(&String::from_utf8_lossy(&bytes), &[]));
    }

    #[test]
    fn any_mixture(pieces in proptest::collection::vec(0..PIECES.len(), 0..30), set in "[a-z.=\\[\\]{}\"0-9]{0,20}") {
        let text: String = pieces.into_iter().map(|i| PIECES[i]).collect();
        render(check(&text, &[]));
        render(check(&text, &[&set]));
    }

    /// A sound file with one byte changed.
    #[test]
    fn any_slip(at in any::<proptest::sample::Index>(), byte in 0_u8..128) {
        let mut text = include_str!("stock.toml").as_bytes().to_vec();
        let at = at.index(text.len());
        text[at] = byte;
        render(check(&String::from_utf8(text).unwrap(), &[]));
    }
}

#[test]
fn deep_nesting_is_an_error() {
    let deep = format!("x = {}{}", "[".repeat(50_000), "]".repeat(50_000));
    assert!(check(&deep, &[]).is_err());
    let keys = format!("{}x = 1", "a.".repeat(50_000));
    assert!(check(&keys, &[]).is_err());
}

#[test]
fn a_long_cycle_and_a_long_chain_are_walked_without_recursion() {
    let chain = |count: usize, first: usize| -> String {
        (0..count)
            .map(|i| {
                let from = if i == 0 { first } else { i - 1 };
                format!("[nodes.n{i}]\nkind = \"collapse\"\nmesh = \"n{from}\"\n")
            })
            .collect()
    };
    let error = check(&chain(3000, 2999), &[]).map(|_| ()).unwrap_err();
    assert!(error.list[0].message.starts_with("a cycle: n0 → n1 → "), "{}", error.list[0].message);
    assert_eq!(error.list.len(), 1);
}
