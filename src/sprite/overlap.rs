//! Collision of two solids: what both hold.

use super::Volume;
use crate::math::{Aabb, Stop, Stopped};
use rayon::prelude::*;

/// What two solids share, found along the rays through the first one's texels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overlap {
    /// Texels of the first whose rays meet both at once.
    pub texels: u64,
    /// m³.
    pub volume: f64,
    /// Around what they share, metres; empty where they share nothing.
    pub bounds: Aabb,
}

impl Overlap {
    pub fn collides(&self) -> bool {
        self.texels > 0
    }

    const NONE: Self = Self { texels: 0, volume: 0.0, bounds: Aabb::EMPTY };

    fn plus(self, o: Self) -> Self {
        Self { texels: self.texels + o.texels, volume: self.volume + o.volume, bounds: self.bounds.union(o.bounds) }
    }
}

/// What `a` and `b` share: the ranges of `a`, clipped against `b` as rays.
pub fn overlap(a: &Volume, b: &Volume, stop: &Stop) -> Result<Overlap, Stopped> {
    let (size, region) = (a.image().size().map(f64::from), a.image().region());
    // Of a texel's box of depth 1.
    let unit = 1.0 / (a.to_texture().matrix3.determinant().abs() * size[0] * size[1]);
    let row = |y: u32| {
        stop.check()?;
        let mut sum = Overlap::NONE;
        for x in 0..region.width {
            let ranges = a.image().ray((y * region.width + x) as usize);
            if ranges.is_empty() {
                continue;
            }
            let ray = a.ray_of([region.x + x, region.y + y]);
            let mut met = false;
            for span in b.spans(&ray) {
                for range in ranges.chunks_exact(2) {
                    let (from, to) = (span.enter.t.max(f64::from(range[0])), span.exit.min(f64::from(range[1])));
                    if from < to {
                        met = true;
                        let bounds = [from, to].into_iter().map(|t| ray.at(t)).collect();
                        sum = sum.plus(Overlap { texels: 0, volume: (to - from) * unit, bounds });
                    }
                }
            }
            sum.texels += u64::from(met);
        }
        Ok(sum)
    };
    let rows: Vec<Overlap> = (0..region.height).into_par_iter().map(row).collect::<Result<_, Stopped>>()?;
    // In the order of the rows, so that the sum is the same for any number of threads.
    Ok(rows.into_iter().fold(Overlap::NONE, Overlap::plus))
}
