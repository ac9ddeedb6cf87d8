//! Which stand-in each object of a scene gets: the cheapest that is good enough, within budgets for the whole scene.
//!
//! Every object has candidates, the first of which is the object itself. One of them is picked for each, so that the weighted cost of all is least and
//! no total exceeds its budget. That is a knapsack problem with one choice per object and several budgets. `relax` bounds it by Lagrangian
//! relaxation (Everett 1963; Held, Wolfe and Crowder 1974 for the multipliers): budgets become prices, and with prices each object can be decided alone.
//! `search` then closes the gap by branch and bound where the scene is small enough, and says whether it did.
//!
//! Two things make it more than that. A group is a stand-in for many objects at once, such as a mesh of all that is far away; at most one group
//! is taken, because groups are meant as alternatives, and every one of them is tried. What objects share, a texture or a mesh, is paid once however many of
//! them use it: its cost is split among those that do, which changes with the choice, so the choice is repeated until nothing changes.

mod cost;
mod judge;
mod relax;
mod search;
mod solve;
mod table;
#[cfg(test)]
mod tests;
mod weigh;

pub use cost::{Cost, NOTHING, plus};
pub use judge::{Judged, Target, judge};
pub use solve::{Candidate, Choice, Group, Item, Picked, Problem, choose};
pub use table::{Judgements, ORIGINAL, Table, table};
pub use weigh::Shared;
