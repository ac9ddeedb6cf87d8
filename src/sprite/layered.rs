//! Layered depth images (section 3, equation 1).

/// For every texel the depths at which its ray crosses the surface, in [0, 1), ascending, their number even: depths 2j and
/// 2j + 1 are the range DR_j = (S_j, E_j) that lies inside (section 4.3).
///
/// The paper keeps d layers of w·h depths, filled up with the invalid depth 1; here only the valid ones are kept, and
/// [`LayeredDepthImage::layer`] gives the paper's.
#[derive(Clone, Debug, PartialEq)]
pub struct LayeredDepthImage {
    /// Texels of the whole image: w_i, h_i of the paper.
    size: [u32; 2],
    region: Region,
    /// The texels of the region, row by row: those of texel i are `depths[starts[i]..starts[i + 1]]`.
    starts: Vec<u32>,
    depths: Vec<f32>,
}

/// A rectangle of texels; the region that is kept, after cropping AABB_LDI = (x, y, w_b, h_b) of section 4.2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    pub x: u32,
    pub y: u32,
    pub width: u32,
    pub height: u32,
}

impl Region {
    pub fn texels(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Place of a texel of the whole image in the region, row by row.
    pub fn at(&self, s: u32, t: u32) -> Option<usize> {
        let (x, y) = (s.checked_sub(self.x)?, t.checked_sub(self.y)?);
        (x < self.width && y < self.height).then(|| y as usize * self.width as usize + x as usize)
    }
}

/// Stands for no depth in the paper's layers.
pub const INVALID: f32 = 1.0;

impl LayeredDepthImage {
    /// From the depths of every texel of a whole image, row by row.
    ///
    /// # Panics
    /// Where `rays` are not as many as the texels, there are 2³² depths or more, or a texel's are not ascending, even in number
    /// and in [0, 1).
    pub fn new(size: [u32; 2], rays: impl IntoIterator<Item = impl AsRef<[f32]>>) -> Self {
        Self::from_region(size, Region { x: 0, y: 0, width: size[0], height: size[1] }, rays)
    }

    /// As [`LayeredDepthImage::new`], for the texels of a region; outside it there is nothing.
    pub(super) fn from_region(
        size: [u32; 2],
        region: Region,
        rays: impl IntoIterator<Item = impl AsRef<[f32]>>,
    ) -> Self {
        let (mut starts, mut depths) = (vec![0], Vec::new());
        for ray in rays {
            let ray = ray.as_ref();
            assert!(ray.len().is_multiple_of(2) && ray.is_sorted(), "the depths of a ray are sorted pairs");
            assert!(ray.iter().all(|d| (0.0..1.0).contains(d)), "depths lie in [0, 1)");
            depths.extend_from_slice(ray);
            starts.push(u32::try_from(depths.len()).expect("an image has less than 2^32 depths"));
        }
        assert_eq!(starts.len(), region.texels() + 1, "a ray for every texel");
        Self { size, region, starts, depths }
    }

    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    pub fn region(&self) -> Region {
        self.region
    }

    /// The depths of texel `i` of the region.
    pub fn ray(&self, i: usize) -> &[f32] {
        &self.depths[self.starts[i] as usize..self.starts[i + 1] as usize]
    }

    /// All depths, texel by texel.
    pub fn depths(&self) -> &[f32] {
        &self.depths
    }

    /// The depth complexity d: most depths of a texel.
    pub fn depth_complexity(&self) -> u32 {
        self.starts.windows(2).map(|s| s[1] - s[0]).max().unwrap_or(0)
    }

    /// Texels of the region that hold depths.
    pub fn covered(&self) -> usize {
        self.starts.windows(2).filter(|s| s[1] > s[0]).count()
    }

    /// The paper's depth map LDI^i over the region, row by row.
    pub fn layer(&self, i: usize) -> Vec<f32> {
        (0..self.region.texels()).map(|texel| self.ray(texel).get(i).copied().unwrap_or(INVALID)).collect()
    }

    /// The image without the rows and columns around it that hold nothing (section 4.2); `None` where all hold nothing.
    pub fn crop(&self) -> Option<Self> {
        let old = self.region;
        let (mut low, mut high) = ([u32::MAX; 2], [0; 2]);
        for (i, s) in self.starts.windows(2).enumerate().filter(|(_, s)| s[1] > s[0]) {
            debug_assert!(s[1] - s[0] >= 2);
            let p = [i as u32 % old.width, i as u32 / old.width];
            (low, high) = ([low[0].min(p[0]), low[1].min(p[1])], [high[0].max(p[0]), high[1].max(p[1])]);
        }
        if low[0] > high[0] {
            return None;
        }
        let region =
            Region { x: old.x + low[0], y: old.y + low[1], width: high[0] - low[0] + 1, height: high[1] - low[1] + 1 };
        let (mut starts, mut depths) = (vec![0], Vec::with_capacity(self.depths.len()));
        for y in low[1]..=high[1] {
            for x in low[0]..=high[0] {
                depths.extend_from_slice(self.ray(y as usize * old.width as usize + x as usize));
                starts.push(depths.len() as u32);
            }
        }
        Some(Self { size: self.size, region, starts, depths })
    }

    /// The parity test VPT of equation (3): whether a point of texture space, T of equation (2), lies inside. Its texel is
    /// the one that it falls into; range ends count as inside, as in the paper.
    pub fn contains(&self, point: [f32; 3]) -> bool {
        texel(self.size, &self.region, point).is_some_and(|i| within(self.ray(i), point[2]))
    }
}

/// The place in the region of the texel into which a point of texture space falls.
#[inline]
pub(super) fn texel(size: [u32; 2], region: &Region, point: [f32; 3]) -> Option<usize> {
    // Also false for what is no number.
    if !(point[0] >= 0.0 && point[0] < 1.0 && point[1] >= 0.0 && point[1] < 1.0) {
        return None;
    }
    region.at((point[0] * size[0] as f32) as u32, (point[1] * size[1] as f32) as u32)
}

/// Whether a depth lies in one of the ranges.
#[inline]
pub(super) fn within(ray: &[f32], depth: f32) -> bool {
    ray.chunks_exact(2).any(|range| range[0] <= depth && depth <= range[1])
}
