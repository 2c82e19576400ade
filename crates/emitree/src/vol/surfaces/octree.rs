//! The octree: leaves with the regions in them and the patches between those.

use crate::vol::surfaces::wall::Wall;

/// The number of a region.
pub(super) type Label = u16;

/// The label of points that no line of sight reaches, where G is not evaluated.
pub(super) const HIDDEN: Label = Label::MAX;

/// A cell: its level and its place on that level.
pub(super) type Cell = (u8, [u32; 3]);

/// A wall between two regions.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Facet {
    pub(super) wall: Wall,
    pub(super) below: Label,
    pub(super) above: Label,
    /// The expected displacement along the normal.
    pub(super) error: f64,
    /// The displacement that is allowed.
    pub(super) allowed: f64,
    /// The |difference| of G between the sides.
    pub(super) jump: f64,
}

/// What is in a cell.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Leaf {
    /// One region.
    Uncut(Label),
    /// Patches between regions.
    Cut(Vec<Facet>),
    /// Several regions, nobody knows where: a cell that is too small to matter much. The first label
    /// is taken, and G is wrong by up to the jump.
    Unresolved(Label, f64),
    /// No line of sight reaches the cell.
    Hidden,
}

impl Leaf {
    /// The region at a point of the cell.
    pub(super) fn region(&self, at: [f64; 3]) -> Label {
        match self {
            Self::Uncut(label) | Self::Unresolved(label, _) => *label,
            Self::Hidden => HIDDEN,
            Self::Cut(facets) => region(facets, at).0,
        }
    }

    /// Whether a part of the cell may be in a region.
    pub(super) fn has(&self, label: Label) -> bool {
        match self {
            Self::Uncut(own) | Self::Unresolved(own, _) => *own == label,
            Self::Hidden => false,
            Self::Cut(facets) => facets.iter().any(|of| of.below == label || of.above == label),
        }
    }

    /// How far a point is from a region that is another one than that at the point, in units of the
    /// displacements allowed; infinite if no wall leads there.
    pub(super) fn distance_to(&self, label: Label, at: [f64; 3]) -> f64 {
        match self {
            Self::Uncut(_) => f64::INFINITY,
            Self::Unresolved(..) | Self::Hidden => 0.0,
            Self::Cut(facets) => distance_to(facets, label, at),
        }
    }

    /// The least jump at the borders of a region; infinite without one.
    pub(super) fn least_jump(&self, label: Label) -> f64 {
        let Self::Cut(facets) = self else { return f64::INFINITY };
        let bounding = facets.iter().filter(|of| of.below == label || of.above == label);
        bounding.map(|of| of.jump).fold(f64::INFINITY, f64::min)
    }

    /// The distance of a point from the nearest change of region along the frames of the patches, in
    /// units of the displacements allowed; infinite in a cell with one region.
    pub(super) fn clearance(&self, at: [f64; 3]) -> f64 {
        match self {
            Self::Uncut(_) => f64::INFINITY,
            Self::Unresolved(..) | Self::Hidden => 0.0,
            Self::Cut(facets) => {
                let label = region(facets, at).0;
                let of_label = facets.iter().filter(|of| of.below == label || of.above == label);
                let clearance = |of: &Facet| of.wall.above(at).abs() / of.allowed.max(of.error);
                of_label.map(clearance).fold(f64::INFINITY, f64::min)
            }
        }
    }
}

/// Whether a leaf is one of others, which are in the order of their cells.
pub(super) fn is_among(leaves: &[(Cell, Leaf)], of: &(Cell, Leaf)) -> bool {
    let number = leaves.binary_search_by(|other| other.0.cmp(&of.0));
    number.is_ok_and(|number| leaves[number] == *of)
}

/// Whether the surface in a cell is one smooth patch.
pub(super) fn is_smooth(facets: &[Facet]) -> bool {
    matches!(facets, [only] if only.wall.patches().len() == 1)
}

/// How far a point is from a region on whose other side of a wall it is, in units of the displacements
/// allowed; infinite if no wall bounds the region.
fn distance_to(facets: &[Facet], label: Label, at: [f64; 3]) -> f64 {
    let bounding = facets.iter().filter(|of| of.below == label || of.above == label);
    let beyond = |of: &Facet| {
        let above = of.wall.above(at);
        let beyond = if of.above == label { -above } else { above };
        beyond / of.allowed.max(of.error)
    };
    let worst = bounding.map(beyond).fold(f64::NEG_INFINITY, f64::max);
    if worst == f64::NEG_INFINITY { f64::INFINITY } else { worst.max(0.0) }
}

/// The region at a point among patches: that which is the furthest on its own side of all patches that
/// bound it. Returned with the distance.
pub(super) fn region(facets: &[Facet], at: [f64; 3]) -> (Label, f64) {
    if let [only] = facets {
        let above = only.wall.above(at);
        return (if above > 0.0 { only.above } else { only.below }, above.abs());
    }
    let first = (0, f64::NEG_INFINITY);
    depths(facets, at).fold(first, |best, of| if of.1 > best.1 { of } else { best })
}

/// Whether a point is in several regions by the patches, further than the displacements allowed: those
/// between some of the regions are missing.
pub(super) fn is_ambiguous(facets: &[Facet], at: [f64; 3]) -> bool {
    let most = facets.iter().map(|of| of.allowed.max(of.error)).fold(0.0, f64::max);
    depths(facets, at).filter(|(_, depth)| *depth > most).count() > 1
}

/// The region of a point, if it is on the sides that no other region has: it is that of all points on
/// the same sides of all patches.
pub(super) fn one_region(facets: &[Facet], at: [f64; 3]) -> Option<Label> {
    if let [_] = facets {
        return Some(region(facets, at).0);
    }
    let mut inside = depths(facets, at).filter(|(_, depth)| *depth > 0.0);
    let (label, _) = inside.next()?;
    inside.next().is_none().then_some(label)
}

/// For each region its least distance from a point on its own side of a patch that bounds it: below 0
/// outside of it.
fn depths(facets: &[Facet], at: [f64; 3]) -> impl Iterator<Item = (Label, f64)> + '_ {
    let labels = facets.iter().enumerate().flat_map(|(i, of)| [(i, of.below), (i, of.above)]);
    let is_first = |(i, label): &(usize, Label)| {
        facets[..*i].iter().all(|of| of.below != *label && of.above != *label)
    };
    labels.filter(is_first).map(move |(_, label)| {
        let side = |of: &Facet| {
            let above = of.wall.above(at);
            if of.above == label { above } else { -above }
        };
        let bounding = facets.iter().filter(|of| of.below == label || of.above == label);
        (label, bounding.map(side).fold(f64::INFINITY, f64::min))
    })
}

/// The cells of a view, in coordinates of about equal lengths along all axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Grid {
    /// The lengths of the edges of the view.
    pub(super) edges: [f64; 3],
    /// The number of base cells along each axis.
    pub(super) base: [u32; 3],
    /// The finest level.
    pub(super) finest: u8,
}

impl Grid {
    /// Whether a point is in the view.
    pub(super) fn contains(&self, at: [f64; 3]) -> bool {
        (0..3).all(|k| (0.0..=self.edges[k]).contains(&at[k]))
    }

    /// The edges of the cells of a level.
    pub(super) fn cell_edges(&self, level: u8) -> [f64; 3] {
        core::array::from_fn(|k| self.edges[k] / f64::from(self.base[k] << level))
    }

    /// The longest of them.
    pub(super) fn cell_size(&self, level: u8) -> f64 {
        self.cell_edges(level).into_iter().fold(0.0, f64::max)
    }

    /// The point at places, in cells, on a level.
    pub(super) fn point(&self, level: u8, places: [f64; 3]) -> [f64; 3] {
        let edges = self.cell_edges(level);
        core::array::from_fn(|k| edges[k] * places[k])
    }

    /// The corner of the lattice of the finest level.
    pub(super) fn corner(&self, corner: [u32; 3]) -> [f64; 3] {
        self.point(self.finest, corner.map(f64::from))
    }

    /// The centre of a cell.
    pub(super) fn centre(&self, (level, at): Cell) -> [f64; 3] {
        self.point(level, at.map(|k| f64::from(k) + 0.5))
    }

    /// The x and y of a line, in base cells.
    pub(super) fn places(&self, xy: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|k| self.place(k, xy[k]))
    }

    /// A place along an axis, in base cells.
    fn place(&self, axis: usize, at: f64) -> f64 {
        at / self.edges[axis] * f64::from(self.base[axis])
    }

    /// The places of the lines through a cell: from the first on, and before the second.
    pub(super) fn places_of_lines(&self, (level, at): Cell) -> [[f64; 2]; 2] {
        [0, 1].map(|k| {
            let [low, high] = [at[k], at[k] + 1];
            let of = |at: u32| f64::from(at) / f64::from(1_u32 << level);
            // Lines beyond the view are those of the cells at its ends.
            let is_last = high == self.base[k] << level;
            [
                if low == 0 { f64::NEG_INFINITY } else { of(low) },
                if is_last { f64::INFINITY } else { of(high) },
            ]
        })
    }

    /// The cell of a level at a point.
    pub(super) fn cell_at(&self, level: u8, at: [f64; 3]) -> [u32; 3] {
        let edges = self.cell_edges(level);
        core::array::from_fn(|k| {
            let cells = self.base[k] << level;
            floor(at[k] / edges[k]).min(cells - 1)
        })
    }

    /// The faces of a cell that are at the border of the view: the axis across each, and whether it is at the upper end.
    pub(super) fn faces_at_border(&self, (level, at): Cell) -> impl Iterator<Item = (usize, bool)> {
        let base = self.base;
        (0..3).flat_map(move |axis| {
            let lower = (at[axis] == 0).then_some((axis, false));
            let upper = (at[axis] + 1 == base[axis] << level).then_some((axis, true));
            lower.into_iter().chain(upper)
        })
    }

    /// The lowest corner of a cell on the lattice of the finest level, and the edge of the cell there.
    pub(super) fn corners(&self, (level, at): Cell) -> ([u32; 3], u32) {
        let step = 1 << (self.finest - level);
        (at.map(|k| k * step), step)
    }

    /// Canonical coordinates of a point, inside the cube.
    pub(super) fn canonical(&self, at: [f64; 3]) -> [f64; 3] {
        const INSIDE: f64 = 1e-9;
        core::array::from_fn(|k| (at[k] / self.edges[k]).clamp(INSIDE, 1.0 - INSIDE))
    }

    /// The point at canonical coordinates.
    pub(super) fn at_canonical(&self, u: [f64; 3]) -> [f64; 3] {
        core::array::from_fn(|k| u[k] * self.edges[k])
    }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small, and 0 or more")]
fn floor(x: f64) -> u32 {
    x.max(0.0) as u32
}

/// The leaves of an octree, to be found by points.
#[derive(Clone, Debug)]
pub(super) struct Octree {
    pub(super) grid: Grid,
    pub(super) leaves: Vec<(Cell, Leaf)>,
    /// For each base cell its node.
    roots: Vec<u32>,
    /// The children of the nodes; those of a leaf are [`LEAF`] and its number.
    nodes: Vec<[u32; 8]>,
}

/// Marks a node as a leaf.
const LEAF: u32 = u32::MAX;
/// Marks a place without a node.
const NONE: u32 = u32::MAX - 1;

impl Octree {
    /// The tree of leaves that fill the view.
    pub(super) fn new(grid: Grid, leaves: Vec<(Cell, Leaf)>) -> Self {
        let count = grid.base.iter().map(|k| *k as usize).product();
        let mut tree =
            Self { grid, leaves: Vec::new(), roots: vec![NONE; count], nodes: Vec::new() };
        for (number, ((level, at), _)) in leaves.iter().enumerate() {
            let root = tree.root(at.map(|k| k >> level));
            if tree.roots[root] == NONE {
                tree.roots[root] = tree.add_node();
            }
            let mut node = tree.roots[root] as usize;
            for below in (0..*level).rev() {
                let child = (0..3).map(|k| ((at[k] as usize >> below) & 1) << k).sum::<usize>();
                if tree.nodes[node][child] == NONE {
                    tree.nodes[node][child] = tree.add_node();
                }
                node = tree.nodes[node][child] as usize;
            }
            tree.nodes[node] = [NONE; 8];
            tree.nodes[node][0] = LEAF;
            tree.nodes[node][1] = u32::try_from(number).unwrap_or(NONE);
        }
        tree.leaves = leaves;
        tree
    }

    fn add_node(&mut self) -> u32 {
        self.nodes.push([NONE; 8]);
        u32::try_from(self.nodes.len() - 1).unwrap_or(NONE)
    }

    fn root(&self, at: [u32; 3]) -> usize {
        let [nx, ny, _] = self.grid.base.map(|k| k as usize);
        let [x, y, z] = at.map(|k| k as usize);
        (z * ny + y) * nx + x
    }

    /// The number of the leaf at a point.
    pub(super) fn find(&self, at: [f64; 3]) -> usize {
        let mut places = [0.0; 3];
        let mut cell = [0; 3];
        for k in 0..3 {
            let along = self.grid.place(k, at[k]);
            cell[k] = floor(along).min(self.grid.base[k] - 1);
            places[k] = along - f64::from(cell[k]);
        }
        let mut node = self.roots[self.root(cell)] as usize;
        while self.nodes[node][0] != LEAF {
            let mut child = 0;
            for (k, place) in places.iter_mut().enumerate() {
                *place *= 2.0;
                if *place >= 1.0 {
                    *place -= 1.0;
                    child |= 1 << k;
                }
            }
            node = self.nodes[node][child] as usize;
        }
        self.nodes[node][1] as usize
    }

    /// The numbers of the leaves that the lines between two places pass, those of each line in their order.
    pub(super) fn passed(&self, [low, high]: [[f64; 2]; 2]) -> Vec<usize> {
        let [nx, ny, nz] = self.grid.base;
        let cells =
            |k: usize, count: u32| floor(low[k]).min(count - 1)..=floor(high[k]).min(count - 1);
        let mut found = Vec::new();
        for z in 0..nz {
            for x in cells(0, nx) {
                for y in cells(1, ny) {
                    let node = self.roots[self.root([x, y, z])] as usize;
                    let from = |ends: [f64; 2]| [ends[0] - f64::from(x), ends[1] - f64::from(y)];
                    self.add_passed(node, [from(low), from(high)], &mut found);
                }
            }
        }
        found
    }

    /// Those below a node, in which places are from 0 to 1.
    fn add_passed(&self, node: usize, [low, high]: [[f64; 2]; 2], found: &mut Vec<usize>) {
        let children = &self.nodes[node];
        if children[0] == LEAF {
            found.push(children[1] as usize);
            return;
        }
        for (child, next) in children.iter().enumerate() {
            let half = |k: usize| (child >> k) & 1;
            let is_passed =
                (0..2).all(|k| if half(k) == 1 { high[k] >= 0.5 } else { low[k] < 0.5 });
            if is_passed {
                let within = |of: [f64; 2]| [0, 1].map(|k| 2.0 * of[k] - half(k) as f64);
                self.add_passed(*next as usize, [within(low), within(high)], found);
            }
        }
    }

    /// The leaf at a point.
    pub(super) fn leaf(&self, at: [f64; 3]) -> &Leaf {
        &self.leaves[self.find(at)].1
    }

    /// The ends of a leaf along an axis.
    pub(super) fn ends(&self, leaf: usize, axis: usize) -> [f64; 2] {
        let (level, at) = self.leaves[leaf].0;
        let edge = self.grid.cell_edges(level)[axis];
        [at[axis], at[axis] + 1].map(|k| f64::from(k) * edge)
    }
}

#[cfg(test)]
mod tests;
