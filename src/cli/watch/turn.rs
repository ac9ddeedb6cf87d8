//! Whose turn it is: at most one bake at a time, and after what was saved meanwhile another.

/// What is to be done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    Nothing,
    /// Start a bake.
    Bake,
    /// Stop the bake that runs; its end will be told.
    Stop,
    /// End the program with this code.
    Leave(u8),
}

#[derive(Default)]
pub struct Turn {
    baking: bool,
    /// Another bake follows the one that runs.
    again: bool,
    leaving: Option<u8>,
}

impl Turn {
    pub fn is_baking(&self) -> bool {
        self.baking
    }

    /// Whether the running bake no longer matters: something that it reads was saved, or the program ends.
    pub fn is_stale(&self) -> bool {
        self.again || self.leaving.is_some()
    }

    /// Something was saved, or the user wants a bake.
    pub fn wanted(&mut self) -> Step {
        if self.leaving.is_some() || self.again {
            return Step::Nothing;
        }
        if self.baking {
            self.again = true;
            return Step::Stop;
        }
        self.baking = true;
        Step::Bake
    }

    /// The bake has ended, by itself or because it was stopped.
    pub fn ended(&mut self) -> Step {
        self.baking = false;
        match self.leaving {
            Some(code) => Step::Leave(code),
            None if std::mem::take(&mut self.again) => self.wanted(),
            None => Step::Nothing,
        }
    }

    /// The program is to end.
    pub fn leave(&mut self, code: u8) -> Step {
        self.leaving = Some(code);
        if self.baking { Step::Stop } else { Step::Leave(code) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_save_stops_the_bake_and_starts_the_next() {
        let mut turn = Turn::default();
        assert_eq!(turn.wanted(), Step::Bake);
        assert!(turn.is_baking() && !turn.is_stale());
        assert_eq!(turn.wanted(), Step::Stop);
        // More saves until it has stopped are one.
        assert_eq!(turn.wanted(), Step::Nothing);
        assert!(turn.is_stale());
        assert_eq!(turn.ended(), Step::Bake);
        assert!(!turn.is_stale());
        assert_eq!(turn.ended(), Step::Nothing);
        assert_eq!(turn.wanted(), Step::Bake);
    }

    #[test]
    fn leaving_waits_for_the_bake_to_stop() {
        let mut turn = Turn::default();
        assert_eq!(turn.leave(0), Step::Leave(0));
        let mut turn = Turn::default();
        turn.wanted();
        turn.wanted();
        assert_eq!(turn.leave(130), Step::Stop);
        assert_eq!(turn.wanted(), Step::Nothing);
        assert_eq!(turn.ended(), Step::Leave(130));
    }
}
