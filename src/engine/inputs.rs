//! What a node's key takes from other nodes, in the key's order. The scheduler hashes this list and `why` explains it, so
//! they cannot disagree.

use super::{
    elements,
    plan::{OutputRef, Plan},
};

/// How an output of another node enters a node's key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Through the port.
    Port,
    /// As the relation that picks among what the port gathers.
    Relation,
    /// As the list that made the axes below which the port gathers.
    Outer,
}

/// One input of a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KeyInput {
    /// The number of the port.
    pub port: usize,
    pub role: Role,
    /// `None`: the port is absent, which the key tells too.
    pub from: Option<OutputRef>,
}

impl KeyInput {
    /// Such as "the relation of input `meshes`".
    pub fn describe(&self, plan: &Plan, n: usize) -> String {
        let port = plan.nodes[n].kind.spec().inputs[self.port].name;
        match self.role {
            Role::Port => format!("input `{port}`"),
            Role::Relation => format!("the relation of input `{port}`"),
            Role::Outer => format!("the list below which input `{port}` gathers"),
        }
    }
}

/// The inputs of node `n`'s key: its ports, and for a mapped node whatever else decides which elements there are and which
/// of them a gather takes. The keys of a mapped node's runs take the ports alone.
pub fn of_key(plan: &Plan, n: usize) -> Vec<KeyInput> {
    let node = &plan.nodes[n];
    let ports = node.inputs.iter().enumerate();
    let mut all: Vec<_> = ports.map(|(port, i)| KeyInput { port, role: Role::Port, from: i.from }).collect();
    if node.axes.is_empty() {
        return all;
    }
    for (port, input) in node.inputs.iter().enumerate() {
        let beside = [(Role::Relation, input.via), (Role::Outer, elements::outer(plan, n, port))];
        all.extend(beside.into_iter().filter(|(_, from)| from.is_some()).map(|(role, from)| KeyInput {
            port,
            role,
            from,
        }));
    }
    all
}
