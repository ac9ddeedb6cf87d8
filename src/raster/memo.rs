//! What is made once for each triangle of a tile.

/// Values by triangle number, made when first asked for. One that another has displaced from its slot may be made again.
pub(crate) struct Memo<T> {
    made: Vec<(u32, T)>,
    /// Position in `made` by the low bits of the triangle number.
    at: [u32; 256],
}

impl<T> Default for Memo<T> {
    fn default() -> Self {
        Self { made: Vec::new(), at: [u32::MAX; 256] }
    }
}

impl<T> Memo<T> {
    pub fn get(&mut self, triangle: u32, make: impl FnOnce() -> T) -> &T {
        let slot = triangle as usize % self.at.len();
        let mut i = self.at[slot] as usize;
        if self.made.get(i).is_none_or(|m| m.0 != triangle) {
            i = self.made.len();
            self.made.push((triangle, make()));
            self.at[slot] = i as u32;
        }
        &self.made[i].1
    }
}
