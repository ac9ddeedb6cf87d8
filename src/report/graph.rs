//! Where the nodes of a graph are drawn: in layers from the top, so that every edge leads down, with few crossings and short edges.
//!
//! The steps are those of Sugiyama, Tagawa and Toda, "Methods for Visual Understanding of Hierarchical System Structures", 1981: layers by the longest
//! path, places of their own for edges that pass a layer, an order within layers by barycentres, and positions near those of the neighbours.

use std::collections::{BTreeMap, BTreeSet};

/// Sizes of a drawing, pixels.
#[derive(Clone, Copy, Debug)]
pub struct Sizes {
    pub width: f64,
    pub height: f64,
    /// Between nodes of a layer, and between layers.
    pub gap: [f64; 2],
    /// Room for an edge that passes a layer.
    pub lane: f64,
}

/// A graph that has its places.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawing {
    pub size: [f64; 2],
    /// Left top corners of the nodes.
    pub nodes: Vec<[f64; 2]>,
    /// For each edge the points that it passes, from the lower side of the one to the upper side of the other node.
    pub edges: Vec<Vec<[f64; 2]>>,
}

/// How often the order is improved, down and up.
const SWEEPS: usize = 12;
/// How often the positions are, until chains are straight.
const SETTLE: usize = 80;

/// Something that has a place in a layer: a node, or an edge from a node on its way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Item {
    node: usize,
    layer: usize,
}

/// Lays out `count` nodes with edges that lead from smaller to greater numbers; others are not drawn.
pub fn lay_out(count: usize, edges: &[(usize, usize)], sizes: Sizes) -> Drawing {
    let proper = |e: &&(usize, usize)| e.0 < e.1 && e.1 < count;
    let distinct: BTreeSet<(usize, usize)> = edges.iter().filter(proper).copied().collect();
    let layers = layers(count, &distinct);
    let graph = Graph::new(&layers, &distinct);
    let order = graph.ordered();
    let centres = graph.positions(&order, sizes);
    let left = centres.iter().map(|(item, x)| x - graph.width(item, sizes) / 2.0).fold(f64::INFINITY, f64::min);
    let right = centres.iter().map(|(item, x)| x + graph.width(item, sizes) / 2.0).fold(0.0, f64::max);
    let step = sizes.height + sizes.gap[1];
    let x = |item: &Item| centres.get(item).map_or(0.0, |c| c - left);
    let of = |node: usize| Item { node, layer: layers[node] };
    let corner = |n: usize| [x(&of(n)) - sizes.width / 2.0, layers[n] as f64 * step];
    let path = |(from, to): &(usize, usize)| {
        if !distinct.contains(&(*from, *to)) {
            return Vec::new();
        }
        let mut points = vec![[x(&of(*from)), layers[*from] as f64 * step + sizes.height]];
        for layer in layers[*from] + 1..layers[*to] {
            let at = x(&Item { node: *from, layer });
            points.extend([[at, layer as f64 * step], [at, layer as f64 * step + sizes.height]]);
        }
        points.push([x(&of(*to)), layers[*to] as f64 * step]);
        points
    };
    let depth = layers.iter().max().map_or(0, |l| l + 1) as f64;
    Drawing {
        size: [(right - left).max(0.0), (depth * step - sizes.gap[1]).max(0.0)],
        nodes: (0..count).map(corner).collect(),
        edges: edges.iter().map(path).collect(),
    }
}

/// The layer of each node: below all that it follows; what follows nothing stands just above what needs it first.
fn layers(count: usize, edges: &BTreeSet<(usize, usize)>) -> Vec<usize> {
    let mut layers = vec![0; count];
    for n in 0..count {
        let above = edges.iter().filter(|e| e.1 == n).map(|e| layers[e.0] + 1);
        layers[n] = above.max().unwrap_or(0);
    }
    for n in (0..count).filter(|n| edges.iter().all(|e| e.1 != *n)) {
        let below = edges.iter().filter(|e| e.0 == n).map(|e| layers[e.1] - 1).min();
        layers[n] = below.unwrap_or(0);
    }
    layers
}

struct Graph {
    /// The layer of each node itself.
    own: Vec<usize>,
    layers: Vec<Vec<Item>>,
    above: BTreeMap<Item, Vec<Item>>,
    below: BTreeMap<Item, Vec<Item>>,
}

impl Graph {
    /// Edges of one node share their way down.
    fn new(own: &[usize], edges: &BTreeSet<(usize, usize)>) -> Self {
        let depth = own.iter().max().map_or(0, |l| l + 1);
        let mut layers = vec![BTreeSet::new(); depth];
        let mut steps = BTreeSet::new();
        for (node, layer) in own.iter().copied().enumerate() {
            layers[layer].insert(Item { node, layer });
        }
        for (from, to) in edges {
            let mut last = Item { node: *from, layer: own[*from] };
            for layer in own[*from] + 1..own[*to] {
                let next = Item { node: *from, layer };
                layers[layer].insert(next);
                steps.insert((last, next));
                last = next;
            }
            steps.insert((last, Item { node: *to, layer: own[*to] }));
        }
        let (mut above, mut below): (BTreeMap<_, Vec<_>>, BTreeMap<_, Vec<_>>) = Default::default();
        for (a, b) in steps {
            above.entry(b).or_default().push(a);
            below.entry(a).or_default().push(b);
        }
        Self { own: own.to_vec(), layers: layers.into_iter().map(|l| l.into_iter().collect()).collect(), above, below }
    }

    fn width(&self, item: &Item, sizes: Sizes) -> f64 {
        if self.own[item.node] == item.layer { sizes.width } else { sizes.lane }
    }

    /// The layers in the order with fewest crossings that was found.
    fn ordered(&self) -> Vec<Vec<Item>> {
        let mut order = self.layers.clone();
        let mut best = (self.crossings(&order), order.clone());
        for sweep in 0..2 * SWEEPS {
            let down = sweep % 2 == 0;
            let near = if down { &self.above } else { &self.below };
            let mut at = places(&order);
            let turn: Vec<usize> = if down { (0..order.len()).collect() } else { (0..order.len()).rev().collect() };
            for layer in turn {
                let centre = |item: &Item| mean(near.get(item)?.iter().map(|i| at[i] as f64));
                let mut keyed: Vec<(f64, Item)> =
                    order[layer].iter().map(|i| (centre(i).unwrap_or(at[i] as f64), *i)).collect();
                keyed.sort_by(|a, b| a.0.total_cmp(&b.0));
                order[layer] = keyed.into_iter().map(|k| k.1).collect();
                at.extend(order[layer].iter().enumerate().map(|(k, i)| (*i, k)));
            }
            let crossings = self.crossings(&order);
            if crossings < best.0 {
                best = (crossings, order.clone());
            }
        }
        best.1
    }

    fn crossings(&self, order: &[Vec<Item>]) -> usize {
        let at = places(order);
        let mut count = 0;
        for layer in order {
            let ends = |i: &Item| self.below.get(i).into_iter().flatten().map(|b| at[b]).collect::<Vec<_>>();
            let ends: Vec<Vec<usize>> = layer.iter().map(ends).collect();
            for (k, first) in ends.iter().enumerate() {
                for second in &ends[k + 1..] {
                    count += first.iter().map(|a| second.iter().filter(|b| *b < a).count()).sum::<usize>();
                }
            }
        }
        count
    }

    /// Centres in x, in the order given and not too near each other, whose edges have small squares of lengths: layer by layer, which converges.
    fn positions(&self, order: &[Vec<Item>], sizes: Sizes) -> BTreeMap<Item, f64> {
        let mut centres: BTreeMap<Item, f64> = BTreeMap::new();
        for layer in order {
            let offsets = self.offsets(layer, sizes);
            let middle = offsets.last().copied().unwrap_or(0.0) / 2.0;
            centres.extend(layer.iter().zip(offsets).map(|(i, o)| (*i, o - middle)));
        }
        for sweep in 0..2 * SETTLE {
            let down = sweep % 2 == 0;
            let turn: Vec<usize> = if down { (0..order.len()).collect() } else { (0..order.len()).rev().collect() };
            for layer in turn.into_iter().map(|l| &order[l]) {
                let near = |item: &Item| {
                    let both = [&self.above, &self.below].into_iter().filter_map(|side| side.get(item)).flatten();
                    let (sum, weight) = both.fold((0.0, 0.0), |(sum, weight), other| {
                        let pull = self.pull(item, other);
                        (sum + pull * centres[other], weight + pull)
                    });
                    if weight > 0.0 { (sum / weight, weight) } else { (centres[item], 1.0) }
                };
                let offsets = self.offsets(layer, sizes);
                let wanted: Vec<(f64, f64)> =
                    layer.iter().map(near).zip(&offsets).map(|((x, weight), o)| (x - o, weight)).collect();
                let found: Vec<f64> = rising(&wanted).into_iter().zip(offsets).map(|(x, o)| x + o).collect();
                centres.extend(layer.iter().copied().zip(found));
            }
        }
        centres
    }

    /// How much an edge's length counts: long edges are to be straight.
    fn pull(&self, a: &Item, b: &Item) -> f64 {
        let passes = |item: &Item| self.own[item.node] != item.layer;
        match (passes(a), passes(b)) {
            (true, true) => 8.0,
            (false, false) => 1.0,
            _ => 2.0,
        }
    }

    /// Centres of a layer that is packed closely, the first at 0.
    fn offsets(&self, layer: &[Item], sizes: Sizes) -> Vec<f64> {
        let mut at = 0.0;
        let mut out = Vec::with_capacity(layer.len());
        for (k, item) in layer.iter().enumerate() {
            if k > 0 {
                at += (self.width(&layer[k - 1], sizes) + self.width(item, sizes)) / 2.0 + sizes.gap[0];
            }
            out.push(at);
        }
        out
    }
}

fn places(order: &[Vec<Item>]) -> BTreeMap<Item, usize> {
    order.iter().flat_map(|layer| layer.iter().copied().enumerate()).map(|(k, item)| (item, k)).collect()
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0), |(s, n), v| (s + v, n + 1));
    (count > 0).then(|| sum / f64::from(count))
}

/// The values that never fall and are nearest to those wanted, each with its weight, by least squares: neighbours that fall are pooled.
fn rising(wanted: &[(f64, f64)]) -> Vec<f64> {
    let mut pools: Vec<(f64, f64, usize)> = Vec::new();
    for (value, weight) in wanted {
        let mut pool = (*value, *weight, 1);
        while let Some((before, w, n)) = pools.pop_if(|p| p.0 > pool.0) {
            pool = ((before * w + pool.0 * pool.1) / (w + pool.1), w + pool.1, n + pool.2);
        }
        pools.push(pool);
    }
    pools.into_iter().flat_map(|(v, _, n)| std::iter::repeat_n(v, n)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZES: Sizes = Sizes { width: 100.0, height: 40.0, gap: [20.0, 30.0], lane: 10.0 };

    #[test]
    fn rising_values_are_the_nearest() {
        let alike = |values: &[f64]| rising(&values.iter().map(|v| (*v, 1.0)).collect::<Vec<_>>());
        assert_eq!(alike(&[1.0, 2.0, 3.0]), [1.0, 2.0, 3.0]);
        assert_eq!(alike(&[3.0, 1.0, 5.0, 4.0]), [2.0, 2.0, 4.5, 4.5]);
        assert_eq!(rising(&[(3.0, 3.0), (1.0, 1.0)]), [2.5, 2.5]);
    }

    #[test]
    fn a_chain_is_straight_and_a_source_stands_near_its_use() {
        // 0 → 1 → 2 → 3, and 4 → 5 with 3 → 5: 4 stands beside 3.
        let d = lay_out(6, &[(0, 1), (1, 2), (2, 3), (3, 5), (4, 5)], SIZES);
        assert_eq!(d.nodes[4][1], d.nodes[3][1]);
        let x: Vec<f64> = d.nodes[..3].iter().map(|p| p[0]).collect();
        assert!((x[0] - x[2]).abs() < 1.0, "{x:?}");
        assert_eq!(d.size[1], 5.0 * 40.0 + 4.0 * 30.0);
        assert_eq!(d.edges[0], [[d.nodes[0][0] + 50.0, 40.0], [d.nodes[1][0] + 50.0, 70.0]]);
    }

    #[test]
    fn nodes_never_overlap_and_edges_keep_clear_of_them() {
        // Any graph of thirty nodes; the numbers are those of a linear congruential generator.
        let mut state = 7_u32;
        let mut next = |below: usize| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as usize % below
        };
        for _ in 0..20 {
            let edges: Vec<(usize, usize)> =
                (1..30).flat_map(|to| [(next(to), to), (to.saturating_sub(1 + next(3)), to)]).collect();
            let d = lay_out(30, &edges, SIZES);
            for (i, a) in d.nodes.iter().enumerate() {
                assert!(a[0] >= -1e-9 && a[0] + 100.0 <= d.size[0] + 1e-9 && a[1] + 40.0 <= d.size[1]);
                for b in &d.nodes[i + 1..] {
                    assert!(a[1] != b[1] || (a[0] - b[0]).abs() >= 120.0 - 1e-6, "{a:?} {b:?}");
                }
            }
            for ((from, to), points) in edges.iter().zip(&d.edges) {
                assert!(points.windows(2).all(|p| p[0][1] < p[1][1]), "{from} {to} {points:?}");
                for p in &points[1..points.len() - 1] {
                    let inside =
                        |n: &[f64; 2]| n[1] <= p[1] && p[1] <= n[1] + 40.0 && n[0] < p[0] && p[0] < n[0] + 100.0;
                    assert!(!d.nodes.iter().any(inside), "{from} → {to} passes a node at {p:?}");
                }
            }
        }
        // Twice the same, and what leads upwards is left out.
        assert_eq!(lay_out(2, &[(1, 0), (0, 1), (0, 1)], SIZES).edges[0], Vec::<[f64; 2]>::new());
        assert_eq!(lay_out(0, &[], SIZES).size, [0.0, 0.0]);
    }
}
