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
    /// Where [`LayeredDepthImage::from_parts`] would refuse them.
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
            depths.extend_from_slice(ray.as_ref());
            starts.push(u32::try_from(depths.len()).expect("an image has less than 2^32 depths"));
        }
        Self::from_parts(size, region, starts, depths).unwrap_or_else(|what| panic!("{what}"))
    }

    /// From the texels of a region, row by row: those of texel i have the depths `depths[starts[i]..starts[i + 1]]`. Refuses a
    /// region that leaves the image, starts that are not those of as many texels, and depths of a texel that are not ascending,
    /// even in number and in [0, 1).
    pub fn from_parts(size: [u32; 2], region: Region, starts: Vec<u32>, depths: Vec<f32>) -> Result<Self, String> {
        let inside = |from: u32, length: u32, of: u32| from.checked_add(length).is_some_and(|end| end <= of);
        if !inside(region.x, region.width, size[0]) || !inside(region.y, region.height, size[1]) {
            return Err(format!("{region:?} leaves an image of {} × {}", size[0], size[1]));
        }
        let texels = u64::from(region.width) * u64::from(region.height);
        if starts.len() as u64 != texels + 1 || starts[0] != 0 || starts[texels as usize] as usize != depths.len() {
            return Err(format!("{} starts and {} depths for {texels} texels", starts.len(), depths.len()));
        }
        for (i, s) in starts.windows(2).enumerate() {
            let ray = depths.get(s[0] as usize..s[1] as usize).unwrap_or(&[f32::NAN]);
            if !(ray.len().is_multiple_of(2) && ray.is_sorted() && ray.iter().all(|d| (0.0..1.0).contains(d))) {
                return Err(format!("texel {i}: {ray:?} are no ascending pairs in [0, 1)"));
            }
        }
        Ok(Self { size, region, starts, depths })
    }

    /// See [`LayeredDepthImage::from_parts`].
    pub fn starts(&self) -> &[u32] {
        &self.starts
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
