//! Textures of relief maps.

use crate::{
    engine::artifact::{Artifact, DecodeError, Decoder, Encoder},
    relief::textures::Textures,
    texture::{TextureArray, ktx2},
};

impl Artifact for Textures {
    const TYPE: &'static str = "Textures";
    const FORMAT: u32 = 1;

    fn encode(&self, out: &mut Encoder) {
        out.json("names", &self.named().map(|(name, _)| name).collect::<Vec<_>>());
        for (name, array) in self.named() {
            // What compresses maps gives arrays that can be written, and so does the reader.
            out.bytes(name, ktx2::write(array).expect("texture arrays that were checked"));
        }
    }

    fn decode(data: &Decoder) -> Result<Self, DecodeError> {
        let array = |name: &str| -> Result<TextureArray, DecodeError> {
            ktx2::read(data.bytes(name)?).map_err(|e| DecodeError::section(name, e.to_string()))
        };
        let names: Vec<String> = data.json("names")?;
        let optional = |name: &str| names.iter().any(|n| n == name).then(|| array(name)).transpose();
        Ok(Self {
            color: array("color")?,
            normal: array("normal")?,
            depth: array("depth")?,
            orm: optional("orm")?,
            emissive: optional("emissive")?,
        })
    }
}
