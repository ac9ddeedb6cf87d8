//! Edges by length, shortest first; among equal lengths, first come, first served.

use std::{cmp::Reverse, collections::BinaryHeap};

/// Squared lengths below this have a list of their own: all of the many edges of a fresh mesh.
const SHORT: usize = 4096;

/// An edge and when it was put in the queue.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
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

/// A priority queue over integer squared lengths (quarter units).
pub struct Queue {
    short: Vec<Fifo>,
    /// No list below this one holds anything.
    lowest: usize,
    long: BinaryHeap<Reverse<(u64, Entry)>>,
}

impl Queue {
    pub fn new() -> Self {
        Self { short: (0..SHORT).map(|_| Fifo::default()).collect(), lowest: SHORT, long: BinaryHeap::new() }
    }

    pub fn push(&mut self, squared: u64, entry: Entry) {
        match usize::try_from(squared) {
            Ok(s) if s < SHORT => {
                self.short[s].items.push(entry);
                self.lowest = self.lowest.min(s);
            }
            _ => self.long.push(Reverse((squared, entry))),
        }
    }

    pub fn pop(&mut self) -> Option<Entry> {
        while let Some(fifo) = self.short.get_mut(self.lowest) {
            if let Some(entry) = fifo.items.get(fifo.taken) {
                fifo.taken += 1;
                return Some(*entry);
            }
            *fifo = Fifo::default();
            self.lowest += 1;
        }
        self.long.pop().map(|Reverse((_, entry))| entry)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shortest_first_then_oldest() {
        let lengths = [5u64, 1 << 40, 4, 5, 4096, 4095, 4, 1 << 40];
        let mut queue = Queue::new();
        let entry = |i: usize| Entry { time: i as u32, a: 0, b: 1 };
        lengths.iter().enumerate().for_each(|(i, l)| queue.push(*l, entry(i)));
        let mut expected: Vec<usize> = (0..lengths.len()).collect();
        expected.sort_by_key(|i| (lengths[*i], *i));
        let found: Vec<usize> = std::iter::from_fn(|| queue.pop()).map(|e| e.time as usize).collect();
        assert_eq!(found, expected);
        queue.push(7, entry(1));
        queue.push(3, entry(2));
        assert_eq!(queue.pop(), Some(entry(2)));
    }
}
