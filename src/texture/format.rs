//! Formats of texels, and their numbers in Vulkan and DXGI.

/// Texels along a side that every current graphics API takes.
pub const MOST_SIDE: u32 = 1 << 14;

/// How texels are stored. All are unsigned and normalised: the highest code is 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Format {
    /// One channel of 8 bits.
    R8,
    /// Two channels of 8 bits.
    Rg8,
    /// Four channels of 8 bits.
    Rgba8,
    /// Opaque colour, 4 bits a texel.
    Bc1,
    /// Colour as BC1 and alpha as BC4, 8 bits a texel.
    Bc3,
    /// One channel, 4 bits a texel.
    Bc4,
    /// Two channels as BC4 each, 8 bits a texel.
    Bc5,
    /// One channel of 16 bits, little-endian.
    R16,
}

impl Format {
    pub const ALL: [Self; 8] =
        [Self::R8, Self::Rg8, Self::Rgba8, Self::Bc1, Self::Bc3, Self::Bc4, Self::Bc5, Self::R16];

    /// Texels along the side of a block: 4 where blocks are compressed, else 1.
    pub fn block_side(self) -> u32 {
        match self {
            Self::R8 | Self::Rg8 | Self::Rgba8 | Self::R16 => 1,
            Self::Bc1 | Self::Bc3 | Self::Bc4 | Self::Bc5 => 4,
        }
    }

    /// Bytes of a block, or of a texel where there are no blocks.
    pub fn block_bytes(self) -> u32 {
        match self {
            Self::R8 => 1,
            Self::Rg8 | Self::R16 => 2,
            Self::Rgba8 => 4,
            Self::Bc1 | Self::Bc4 => 8,
            Self::Bc3 | Self::Bc5 => 16,
        }
    }

    /// Channels that are stored.
    pub fn channels(self) -> u32 {
        match self {
            Self::R8 | Self::R16 | Self::Bc4 => 1,
            Self::Rg8 | Self::Bc5 => 2,
            Self::Bc1 => 3,
            Self::Rgba8 | Self::Bc3 => 4,
        }
    }

    /// Bytes of an image with sides of at most 2³⁰; blocks at the right and lower edge count whole.
    pub fn bytes(self, width: u32, height: u32) -> u64 {
        let blocks = |n: u32| u64::from(n.div_ceil(self.block_side()));
        blocks(width) * blocks(height) * u64::from(self.block_bytes())
    }

    /// Whether colours can be sRGB-encoded.
    pub fn has_srgb(self) -> bool {
        matches!(self, Self::Rgba8 | Self::Bc1 | Self::Bc3)
    }

    /// The number of `VkFormat`. BC1 is the variant without alpha. Formats without an sRGB variant ignore `srgb`.
    pub fn vk(self, srgb: bool) -> u32 {
        match (self, srgb) {
            (Self::R8, _) => 9,
            (Self::Rg8, _) => 16,
            (Self::Rgba8, false) => 37,
            (Self::Rgba8, true) => 43,
            (Self::R16, _) => 70,
            (Self::Bc1, false) => 131,
            (Self::Bc1, true) => 132,
            (Self::Bc3, false) => 137,
            (Self::Bc3, true) => 138,
            (Self::Bc4, _) => 139,
            (Self::Bc5, _) => 141,
        }
    }

    /// The number of `DXGI_FORMAT`. Formats without an sRGB variant ignore `srgb`.
    pub fn dxgi(self, srgb: bool) -> u32 {
        match (self, srgb) {
            (Self::Rgba8, false) => 28,
            (Self::Rgba8, true) => 29,
            (Self::Rg8, _) => 49,
            (Self::R16, _) => 56,
            (Self::R8, _) => 61,
            (Self::Bc1, false) => 71,
            (Self::Bc1, true) => 72,
            (Self::Bc3, false) => 77,
            (Self::Bc3, true) => 78,
            (Self::Bc4, _) => 80,
            (Self::Bc5, _) => 83,
        }
    }

    /// The format with a number of `VkFormat`, and whether it is sRGB.
    pub fn from_vk(number: u32) -> Option<(Self, bool)> {
        Self::find(|format, srgb| format.vk(srgb) == number)
    }

    /// The format with a number of `DXGI_FORMAT`, and whether it is sRGB.
    pub fn from_dxgi(number: u32) -> Option<(Self, bool)> {
        Self::find(|format, srgb| format.dxgi(srgb) == number)
    }

    fn find(is: impl Fn(Self, bool) -> bool) -> Option<(Self, bool)> {
        let all = Self::ALL.into_iter().flat_map(|f| [(f, false), (f, true)]);
        all.filter(|(f, srgb)| f.has_srgb() || !srgb).find(|(f, srgb)| is(*f, *srgb))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_lead_back() {
        for format in Format::ALL {
            for srgb in [false, true] {
                let expected = Some((format, srgb && format.has_srgb()));
                assert_eq!(Format::from_vk(format.vk(srgb)), expected);
                assert_eq!(Format::from_dxgi(format.dxgi(srgb)), expected);
            }
        }
        assert_eq!((Format::from_vk(0), Format::from_vk(133), Format::from_dxgi(0)), (None, None, None));
    }

    #[test]
    fn blocks_at_the_edge_count_whole() {
        for (format, width, height, bytes) in [
            (Format::R8, 5, 3, 15),
            (Format::R16, 5, 3, 30),
            (Format::Bc1, 5, 3, 16),
            (Format::Bc5, 8, 9, 96),
            (Format::Rgba8, 1 << 14, 1 << 14, 1 << 30),
        ] {
            assert_eq!(format.bytes(width, height), bytes, "{format:?}");
        }
    }
}
