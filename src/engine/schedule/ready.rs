//! The order in which runs start: the deepest node first, so that values are used up before more are made. What others
//! already wait for goes before all of them.

use super::RunId;
use std::collections::VecDeque;

pub struct Ready {
    urgent: VecDeque<RunId>,
    /// By the depth of their nodes.
    levels: Vec<VecDeque<RunId>>,
    /// Of each node: the length of the longest way to it.
    depths: Vec<usize>,
}

impl Ready {
    pub fn new(depths: Vec<usize>) -> Self {
        let levels = depths.iter().max().map_or(0, |most| most + 1);
        Self { urgent: VecDeque::new(), levels: vec![VecDeque::new(); levels], depths }
    }

    pub fn push(&mut self, id: RunId) {
        self.levels[self.depths[id.node]].push_back(id);
    }

    /// For a run that another waits for, or that has waited itself.
    pub fn push_urgent(&mut self, id: RunId) {
        self.urgent.push_front(id);
    }

    fn next(&mut self) -> Option<&mut VecDeque<RunId>> {
        if !self.urgent.is_empty() {
            return Some(&mut self.urgent);
        }
        self.levels.iter_mut().rev().find(|level| !level.is_empty())
    }

    pub fn front(&mut self) -> Option<RunId> {
        self.next()?.front().copied()
    }

    pub fn pop(&mut self) -> Option<RunId> {
        self.next()?.pop_front()
    }

    pub fn is_empty(&self) -> bool {
        self.urgent.is_empty() && self.levels.iter().all(VecDeque::is_empty)
    }
}
