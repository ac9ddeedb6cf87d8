//! Edges by rank, least first; among equal ranks, first come, first served.

/// An edge and when it was put in the queue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry {
    pub time: u32,
    pub a: u32,
    pub b: u32,
}

#[derive(Default)]
struct Fifo {
    items: Vec<Entry>,
    taken: usize,
}

/// A number of at least 1, to six binary digits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Rank(u16);

impl Rank {
    /// Anything below 1, and what is no number, counts as 1.
    pub fn of(x: f64) -> Self {
        let digits = |x: f32| x.to_bits() >> 17;
        let x = if x > 1.0 { (x as f32).min(f32::MAX) } else { 1.0 };
        Self((digits(x) - digits(1.0)) as u16)
    }

    const COUNT: usize = 128 << 6;
}

/// A priority queue.
pub struct Queue {
    ranks: Vec<Fifo>,
    /// No list below this one holds anything.
    lowest: usize,
}

impl Queue {
    pub fn new() -> Self {
        Self { ranks: (0..Rank::COUNT).map(|_| Fifo::default()).collect(), lowest: Rank::COUNT }
    }

    pub fn push(&mut self, rank: Rank, entry: Entry) {
        let rank = usize::from(rank.0);
        self.ranks[rank].items.push(entry);
        self.lowest = self.lowest.min(rank);
    }

    pub fn pop(&mut self) -> Option<Entry> {
        while let Some(fifo) = self.ranks.get_mut(self.lowest) {
            if let Some(entry) = fifo.items.get(fifo.taken) {
                fifo.taken += 1;
                return Some(*entry);
            }
            *fifo = Fifo::default();
            self.lowest += 1;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn least_first_then_oldest() {
        let ranks = [5.0, 1e12, 4.0, 5.0, 4096.0, 4000.0, 4.0, 1e12, 0.0, f64::MAX];
        let mut queue = Queue::new();
        let entry = |i: usize| Entry { time: i as u32, a: 0, b: 1 };
        ranks.iter().enumerate().for_each(|(i, r)| queue.push(Rank::of(*r), entry(i)));
        let mut expected: Vec<usize> = (0..ranks.len()).collect();
        expected.sort_by(|i, j| ranks[*i].total_cmp(&ranks[*j]).then(i.cmp(j)));
        let found: Vec<usize> = std::iter::from_fn(|| queue.pop()).map(|e| e.time as usize).collect();
        assert_eq!(found, expected);
        queue.push(Rank::of(7.0), entry(1));
        queue.push(Rank::of(3.0), entry(2));
        assert_eq!(queue.pop(), Some(entry(2)));
        queue.push(Rank::of(f64::INFINITY), entry(3));
        queue.push(Rank::of(f64::NAN), entry(4));
        assert_eq!(queue.pop(), Some(entry(4)));
    }
}
