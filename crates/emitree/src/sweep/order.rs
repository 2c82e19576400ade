//! The order of the images of a sweep: which is rendered in full, and which by the mesh of another.
//!
//! Images are taken from the middle outwards, each with the nearest mesh. Where that does not suffice, the
//! next full rendering is half as far again from the mesh. The evaluations that may be lost, by meshes that
//! do not suffice and by finer meshes, are kept below a tenth of those of all images in full, each of those that
//! were not rendered in full as expensive as the cheapest that was.

/// The most evaluations of a sweep, in those of all images rendered in full.
const MOST: f64 = 1.1;
/// The next full rendering after a mesh does not suffice: its distance from that mesh, in that of the image
/// that failed.
const NEXT: f64 = 1.5;
/// The samples besides its points that compare a mesh with an emission: usually 256 and some lines of sight. With
/// fewer the mesh is not tried.
const CHECKED: u64 = 600;

/// What comes next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Next {
    /// The image of this number, without a mesh.
    InFull(usize),
    /// The image of this number, with the mesh of this number, which may request so many rates.
    ByMesh { image: usize, mesh: usize, most: u64 },
}

impl Next {
    pub(super) fn image(self) -> usize {
        match self {
            Self::InFull(image) | Self::ByMesh { image, .. } => image,
        }
    }
}

/// Images that remain, meshes, and the evaluations so far.
#[derive(Clone, Debug)]
pub(super) struct Order {
    /// The parameters of each image, as fractions of their ranges.
    places: Vec<Vec<f64>>,
    /// The numbers of the images that remain, in the lexical order of their places.
    remaining: Vec<usize>,
    /// Where the next full rendering is to be, if one is needed.
    target: Option<Vec<f64>>,
    meshes: Vec<OfMesh>,
    /// Evaluations so far.
    evaluations: u64,
    in_full: InFull,
}

/// The renderings in full so far.
#[derive(Clone, Copy, Debug, Default)]
struct InFull {
    count: u32,
    /// The evaluations of all, and of the cheapest.
    evaluations: f64,
    least: f64,
}

/// What is known of a mesh.
#[derive(Clone, Debug)]
struct OfMesh {
    place: Vec<f64>,
    /// The number of its points.
    points: u64,
    /// Places at which it did not suffice.
    failed: Vec<Vec<f64>>,
}

impl Order {
    /// Images with the values of some parameters, each value a number for every parameter.
    pub(super) fn new(values: &[Vec<f64>]) -> Self {
        let places = scaled(values);
        let mut remaining: Vec<usize> = (0..places.len()).collect();
        let lexical = |&i: &usize, &j: &usize| places[i].partial_cmp(&places[j]);
        remaining.sort_by(|i, j| lexical(i, j).unwrap_or(core::cmp::Ordering::Equal));
        let target = places.first().map(|place| vec![0.5; place.len()]);
        let in_full = InFull::default();
        Self { places, remaining, target, meshes: Vec::new(), evaluations: 0, in_full }
    }

    /// What comes next; `None` at the end.
    pub(super) fn next(&self) -> Option<Next> {
        let first = *self.remaining.first()?;
        if let Some(target) = &self.target {
            return self.nearest(target).map(Next::InFull);
        }
        let Some((image, mesh)) = self.nearest_pair() else { return Some(Next::InFull(first)) };
        let most = self.allowance(0);
        Some(match most >= self.meshes[mesh].points + CHECKED {
            true => Next::ByMesh { image, mesh, most },
            false => Next::InFull(image),
        })
    }

    /// Counts evaluations.
    pub(super) fn count(&mut self, evaluations: u64) {
        self.evaluations += evaluations;
    }

    /// Evaluations so far.
    pub(super) fn evaluations(&self) -> u64 {
        self.evaluations
    }

    /// The number of images that remain.
    pub(super) fn remaining(&self) -> usize {
        self.remaining.len()
    }

    /// An image was rendered in full, which would take so many evaluations alone.
    pub(super) fn rendered_in_full(&mut self, evaluations: f64) {
        self.target = None;
        let InFull { count, evaluations: of_all, least } = self.in_full;
        let least = if count == 0 { evaluations } else { least.min(evaluations) };
        self.in_full = InFull { count: count + 1, evaluations: of_all + evaluations, least };
    }

    /// The evaluations that may be lost: all images are within the limit then, where `but` of those that remain
    /// take no more.
    pub(super) fn allowance(&self, but: usize) -> u64 {
        let InFull { count, evaluations, least } = self.in_full;
        let of_all = evaluations + least * (self.places.len() as f64 - f64::from(count));
        let of_others = least * self.remaining.len().saturating_sub(but) as f64;
        let allowed = MOST * of_all - self.evaluations as f64 - of_others;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
        let allowed = allowed as u64;
        allowed
    }

    /// The distance of an image from a mesh.
    pub(super) fn distance_from(&self, mesh: usize, image: usize) -> f64 {
        distance(&self.places[image], &self.meshes[mesh].place)
    }

    /// Adds the mesh of an image, with so many points.
    pub(super) fn add_mesh(&mut self, image: usize, points: u64) {
        let place = self.places[image].clone();
        self.meshes.push(OfMesh { place, points, failed: Vec::new() });
    }

    /// An image is done, or can't be rendered.
    pub(super) fn done(&mut self, image: usize) {
        self.remaining.retain(|&other| other != image);
        if self.in_full.count > 0 {
            self.target = None;
        }
    }

    /// A mesh does not suffice for an image.
    pub(super) fn failed(&mut self, image: usize, mesh: usize) {
        let (failed, of) = (self.places[image].clone(), &mut self.meshes[mesh]);
        let beyond = failed.iter().zip(&of.place).map(|(at, from)| from + NEXT * (at - from));
        self.target = Some(beyond.collect());
        of.failed.push(failed);
    }

    /// The image nearest to a place; the first one of several.
    fn nearest(&self, target: &[f64]) -> Option<usize> {
        let to = |&image: &usize| distance(&self.places[image], target);
        self.remaining.iter().copied().min_by(|i, j| to(i).total_cmp(&to(j)))
    }

    /// The image and the mesh nearest to each other.
    fn nearest_pair(&self) -> Option<(usize, usize)> {
        let mut nearest: Option<(f64, usize, usize)> = None;
        for (number, mesh) in self.meshes.iter().enumerate() {
            for &image in &self.remaining {
                let place = &self.places[image];
                let distance = distance(place, &mesh.place);
                let is_nearer = nearest.is_none_or(|(least, ..)| distance < least);
                if is_nearer && !mesh.fails_before(place) {
                    nearest = Some((distance, image, number));
                }
            }
        }
        nearest.map(|(_, image, mesh)| (image, mesh))
    }
}

impl OfMesh {
    /// Whether the mesh did not suffice for a place on the way to this one.
    fn fails_before(&self, place: &[f64]) -> bool {
        let from = &self.place;
        let along = |failed: &[f64], at: &[f64]| -> f64 {
            let ways = failed.iter().zip(at).zip(from);
            ways.map(|((failed, at), from)| (failed - from) * (at - from)).sum()
        };
        self.failed.iter().any(|failed| along(failed, place) >= along(failed, failed))
    }
}

/// Values as fractions of the range of all.
fn scaled(values: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mut places = values.to_vec();
    for parameter in 0..values.first().map_or(0, Vec::len) {
        let of_all = || values.iter().map(|of_image| of_image[parameter]);
        let (least, most) =
            of_all().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        for place in &mut places {
            let offset = place[parameter] - least;
            place[parameter] = if most > least { offset / (most - least) } else { 0.0 };
        }
    }
    places
}

/// The distance, without the rounding that makes equal ones different.
fn distance(first: &[f64], second: &[f64]) -> f64 {
    let squares = first.iter().zip(second).map(|(a, b)| (a - b).powi(2));
    (squares.sum::<f64>().sqrt() * 1e9).round() / 1e9
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The image and the mesh that come next, if there is a mesh.
    fn by_mesh(order: &Order) -> Option<(usize, usize)> {
        match order.next()? {
            Next::ByMesh { image, mesh, .. } => Some((image, mesh)),
            Next::InFull(_) => None,
        }
    }

    fn along(count: u32) -> Order {
        let values: Vec<Vec<f64>> = (0..count).map(|i| vec![3.0 + 0.1 * f64::from(i)]).collect();
        Order::new(&values)
    }

    #[test]
    fn images_are_taken_from_the_middle_outwards() {
        let mut order = along(5);
        assert_eq!(order.next(), Some(Next::InFull(2)));
        order.rendered_in_full(10_000.0);
        order.count(10_000);
        order.add_mesh(2, 300);
        order.done(2);
        let mut images = Vec::new();
        while let Some((image, 0)) = by_mesh(&order) {
            images.push(image);
            order.count(300);
            order.done(image);
        }
        assert_eq!(images, [1, 3, 0, 4]);
        assert_eq!((order.next(), order.remaining()), (None, 0));
    }

    /// The next full rendering is beyond the place of failure, and the mesh is not used there any more.
    #[test]
    fn a_mesh_that_fails_is_followed_by_another() {
        let mut order = along(11);
        order.rendered_in_full(10_000.0);
        order.count(10_000);
        order.add_mesh(5, 300);
        order.done(5);
        assert_eq!(by_mesh(&order), Some((4, 0)));
        order.done(4);
        assert_eq!(by_mesh(&order), Some((6, 0)));
        order.done(6);
        assert_eq!(by_mesh(&order), Some((3, 0)));
        order.count(300);
        order.failed(3, 0);
        assert_eq!(order.next(), Some(Next::InFull(2)));
        order.rendered_in_full(10_000.0);
        order.count(10_000);
        order.add_mesh(2, 300);
        order.done(2);
        assert_eq!(by_mesh(&order), Some((1, 1)));
        order.done(1);
        assert_eq!(by_mesh(&order), Some((3, 1)));
        order.done(3);
        assert_eq!(by_mesh(&order), Some((7, 0)));
    }

    /// Meshes that always fail cost a tenth of all images at most.
    #[test]
    fn the_evaluations_of_meshes_that_fail_are_bounded() {
        let mut order = along(30);
        let mut evaluations = 0;
        while let Some(next) = order.next() {
            match next {
                Next::InFull(image) => {
                    order.rendered_in_full(10_000.0);
                    evaluations += 10_000;
                    order.count(10_000);
                    order.add_mesh(image, 400);
                    order.done(image);
                }
                Next::ByMesh { image, mesh, most } => {
                    let lost = most.min(4_000);
                    evaluations += lost;
                    order.count(lost);
                    order.failed(image, mesh);
                }
            }
        }
        assert!(evaluations > 300_000 && evaluations <= 330_000, "{evaluations}");
    }

    #[test]
    fn images_that_fail_are_left_out() {
        let mut order = along(3);
        let mut images = Vec::new();
        while let Some(next) = order.next() {
            images.push(next.image());
            order.done(next.image());
        }
        assert_eq!(images, [1, 0, 2]);
    }
}
