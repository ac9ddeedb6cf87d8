//! The tree of a scene's regions.

use crate::{
    engine::artifact::{Artifact, DecodeError, Decoder, Encoder},
    scene::split::RegionTree,
};

impl Artifact for RegionTree {
    const TYPE: &'static str = "RegionTree";
    const FORMAT: u32 = 1;

    fn encode(&self, out: &mut Encoder) {
        out.json("regions", &self.regions);
    }

    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        let tree = Self { regions: data.json("regions")? };
        tree.fault().map_or(Ok(tree), |fault| Err(DecodeError::section("regions", fault)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        engine::artifact::{from_bytes, to_bytes},
        math::Stop,
        scene::{
            builtin,
            split::{Division, Splitting, split},
        },
    };
    use std::sync::Arc;

    #[test]
    fn decodes_what_was_encoded_and_refuses_what_is_no_tree() {
        let how = Splitting { division: Division::Octree, levels: 2, min_triangles: 0 };
        let (tree, _) = split(&builtin::make("solids", 1).unwrap(), how, &Stop::default()).unwrap();
        let again = |tree: &RegionTree| from_bytes::<RegionTree>(Arc::new(to_bytes(tree)));
        assert_eq!(again(&tree), Ok(tree.clone()));
        let spoiled = |spoil: &dyn Fn(&mut RegionTree)| {
            let mut tree = tree.clone();
            spoil(&mut tree);
            again(&tree)
        };
        assert!(spoiled(&|t| t.regions.reverse()).is_err());
        assert!(spoiled(&|t| drop(t.regions.pop())).is_err());
        assert!(spoiled(&|t| t.regions[0].children.clear()).is_err());
        assert!(spoiled(&|t| t.regions[1].bounds.reverse()).is_err());
        assert!(spoiled(&|t| t.regions[0].children[0] = "root.9".into()).is_err());
        assert!(again(&RegionTree::default()).is_err());
    }
}
