//! Rectangles onto pages: the skyline heuristic, bottom left (Jylänki 2010, "A thousand ways to pack the bin").
//!
//! Rectangles come in order of falling height and are put where their upper edge ends lowest; pages are powers of two,
//! the smallest that holds everything. Deterministic; no rectangle is turned.

/// Where a rectangle lies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AtlasSlot {
    pub page: u32,
    pub x: u32,
    pub y: u32,
}

/// Pages and places, in the caller's unit.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Packing {
    /// Width and height of every page, powers of two.
    pub pages: Vec<[u32; 2]>,
    /// One per rectangle.
    pub places: Vec<AtlasSlot>,
}

/// The upper outline of what lies on a page: (x, width, height) from left to right, together the page's width.
struct Skyline {
    segments: Vec<[u32; 3]>,
    size: [u32; 2],
}

impl Skyline {
    fn new(size: [u32; 2]) -> Self {
        Self { segments: vec![[0, size[0], 0]], size }
    }

    /// Top of a rectangle of width `w` whose left side is at segment `i`; `None` where it leaves the page.
    fn rest(&self, i: usize, w: u32) -> Option<u32> {
        let mut left = w;
        let mut top = 0;
        for s in &self.segments[i..] {
            top = top.max(s[2]);
            if s[1] >= left {
                return Some(top);
            }
            left -= s[1];
        }
        None
    }

    fn place(&mut self, [w, h]: [u32; 2]) -> Option<[u32; 2]> {
        let fits = |y: u32| y.checked_add(h).filter(|top| *top <= self.size[1]);
        let tops = (0..self.segments.len()).filter_map(|i| self.rest(i, w).and_then(|y| Some((fits(y)?, i, y))));
        let (top, i, y) = tops.min()?;
        let x = self.segments[i][0];
        let mut covered = w;
        let mut next = i;
        while covered > 0 {
            let s = &mut self.segments[next];
            let part = s[1].min(covered);
            covered -= part;
            if part == s[1] {
                next += 1;
            } else {
                s[0] += part;
                s[1] -= part;
            }
        }
        self.segments.splice(i..next, [[x, w, top]]);
        // Equal neighbours become one, so that the outline stays short.
        let mut at = i.saturating_sub(1);
        while at + 1 < self.segments.len() && at <= i + 1 {
            if self.segments[at][2] == self.segments[at + 1][2] {
                self.segments[at][1] += self.segments[at + 1][1];
                self.segments.remove(at + 1);
            } else {
                at += 1;
            }
        }
        Some([x, y])
    }
}

/// Places rectangles of the given sizes (width, height; each at least 1) on as few pages of at most `max` a side
/// as the heuristic finds. `None` where a rectangle is larger than `max`, which must be a power of two.
pub fn pack(sizes: &[[u32; 2]], max: u32) -> Option<Packing> {
    if sizes.iter().flatten().any(|s| *s > max) {
        return None;
    }
    let mut rest: Vec<usize> = (0..sizes.len()).collect();
    rest.sort_by_key(|i| (std::cmp::Reverse([sizes[*i][1], sizes[*i][0]]), *i));
    let mut out = Packing { pages: Vec::new(), places: vec![AtlasSlot::default(); sizes.len()] };
    while !rest.is_empty() {
        let page = out.pages.len() as u32;
        let mut left = Vec::new();
        let mut used = [0; 2];
        for size in candidates(sizes, &rest, max) {
            let last = size == [max; 2];
            let mut skyline = Skyline::new(size);
            left.clear();
            for &i in &rest {
                match skyline.place(sizes[i]) {
                    Some([x, y]) => out.places[i] = AtlasSlot { page, x, y },
                    None if last => left.push(i),
                    None => {
                        left.push(i);
                        break;
                    }
                }
            }
            used = size;
            if left.is_empty() {
                break;
            }
        }
        out.pages.push(used);
        std::mem::swap(&mut rest, &mut left);
    }
    Some(out)
}

/// Page sizes to try for these rectangles, by area, square before oblong; the largest page last.
fn candidates(sizes: &[[u32; 2]], of: &[usize], max: u32) -> Vec<[u32; 2]> {
    let area: u64 = of.iter().map(|i| u64::from(sizes[*i][0]) * u64::from(sizes[*i][1])).sum();
    let widest = |k: usize| of.iter().map(|i| sizes[*i][k]).max().unwrap_or(1);
    let mut sides = vec![];
    let mut side = 1;
    while side <= max {
        sides.push(side);
        side *= 2;
    }
    let mut pages: Vec<[u32; 2]> = sides
        .iter()
        .flat_map(|w| [[*w, *w], [*w, *w / 2], [*w / 2, *w]])
        .filter(|[w, h]| *w >= widest(0) && *h >= widest(1) && u64::from(*w) * u64::from(*h) >= area)
        .collect();
    pages.sort_by_key(|[w, h]| (u64::from(*w) * u64::from(*h), w != h, *h));
    pages.push([max; 2]);
    pages
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn rectangles_lie_apart_within_their_pages(sizes in prop::collection::vec(prop::array::uniform2(1..20u32), 0..60)) {
            let p = pack(&sizes, 32).unwrap();
            let mut taken: Vec<Vec<bool>> = p.pages.iter().map(|[w, h]| vec![false; (w * h) as usize]).collect();
            for (size, at) in sizes.iter().zip(&p.places) {
                let [w, h] = p.pages[at.page as usize];
                prop_assert!(w.is_power_of_two() && h.is_power_of_two() && w <= 32 && h <= 32);
                prop_assert!(at.x + size[0] <= w && at.y + size[1] <= h);
                for y in at.y..at.y + size[1] {
                    for x in at.x..at.x + size[0] {
                        let cell = &mut taken[at.page as usize][(y * w + x) as usize];
                        prop_assert!(!*cell, "two rectangles at {x}, {y}");
                        *cell = true;
                    }
                }
            }
            prop_assert_eq!(&p, &pack(&sizes, 32).unwrap());
        }
    }

    #[test]
    fn fills_a_page_with_what_fits_exactly() {
        let p = pack(&[[8, 8], [4, 4], [4, 4], [8, 4], [4, 12], [4, 4]], 16).unwrap();
        assert_eq!(p.pages, [[16, 16]]);
    }

    #[test]
    fn many_alike_fill_their_page() {
        let p = pack(&[[3, 3]; 100], 1024).unwrap();
        assert_eq!(p.pages, [[32, 32]]);
    }

    #[test]
    fn too_large_is_refused() {
        assert_eq!(pack(&[[33, 1]], 32), None);
    }
}
