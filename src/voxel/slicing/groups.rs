//! Numbers sorted into groups.

/// Numbers by group, in each in the order in which they came.
pub struct Groups {
    /// Group g holds `numbers[starts[g]..starts[g + 1]]`.
    starts: Vec<usize>,
    numbers: Vec<u32>,
}

impl Groups {
    /// From (group, number), every group less than `count`.
    pub fn new(count: usize, pairs: impl Iterator<Item = (usize, u32)> + Clone) -> Self {
        let mut starts = vec![0; count + 1];
        pairs.clone().for_each(|(group, _)| starts[group + 1] += 1);
        for g in 0..count {
            starts[g + 1] += starts[g];
        }
        let mut next = starts.clone();
        let mut numbers = vec![0; starts[count]];
        for (group, number) in pairs {
            numbers[next[group]] = number;
            next[group] += 1;
        }
        Self { starts, numbers }
    }

    /// Nothing where there is no such group.
    pub fn of(&self, group: usize) -> &[u32] {
        match self.starts.get(group..group + 2) {
            Some(s) => &self.numbers[s[0]..s[1]],
            None => &[],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_their_order() {
        let pairs = [(2, 7), (0, 3), (2, 1), (2, 9), (0, 3)];
        let groups = Groups::new(4, pairs.into_iter());
        let all: Vec<&[u32]> = (0..5).map(|g| groups.of(g)).collect();
        assert_eq!(all, [&[3, 3][..], &[], &[7, 1, 9], &[], &[]]);
    }
}
