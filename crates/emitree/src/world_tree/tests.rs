use super::*;
use crate::FromFn;
use crate::error::RenderError;
use crate::tree::StopReason;
use core::ops::ControlFlow;
use proptest::prelude::*;

const UNIT: [[f64; 3]; 2] = [[0.0; 3], [1.0; 3]];

fn boxed([min, max]: [[f64; 3]; 2]) -> WorldBox {
    WorldBox::new(min, max).unwrap()
}

fn built(
    g: impl Fn([f64; 3]) -> f64 + Sync,
    bounds: WorldBox,
    options: &WorldTreeOptions<'_>,
) -> BuiltWorldTree {
    build_world_tree(&FromFn(|r, _| g(r)), bounds, options).unwrap()
}

fn rates(tree: &WorldTree, positions: &[[f64; 3]]) -> Vec<f64> {
    let mut rates = vec![f64::NAN; positions.len()];
    let directions = vec![[0.0, 0.0, 1.0]; positions.len()];
    let Ok(()) = tree.emission_rates(&Samples::new(positions, &directions), &mut rates);
    rates
}

/// Points that fill the unit cube evenly: multiples of a vector with no rational relations.
fn points(count: u32) -> Vec<[f64; 3]> {
    let step = [0.819_172_513_396_164_5, 0.671_043_606_703_789_2, 0.549_700_477_901_936_6];
    (0..count).map(|n| step.map(|s| (f64::from(n) * s).fract())).collect()
}

/// A peak that leaves the tree uneven, with leaves on three levels or more.
fn peak([x, y, z]: [f64; 3]) -> f64 {
    (-200.0 * ((x - 0.3).powi(2) + (y - 0.6).powi(2) + (z - 0.1).powi(2))).exp()
}

fn uneven(order: usize) -> WorldTree {
    let options = WorldTreeOptions { order, base_level: 3, ..WorldTreeOptions::default() };
    let tree = built(peak, boxed(UNIT), &options).tree;
    assert!(tree.leaves_per_level().iter().filter(|&&leaves| leaves > 0).count() >= 2);
    tree
}

/// The families of an uneven tree, with the values of another function in them.
fn filled(tree: &WorldTree, g: impl Fn([f64; 3]) -> f64) -> Vec<Family> {
    let mut families: Vec<Family> = tree.families().collect();
    for family in &mut families {
        let edge = 0.5_f64.powi(family.level.into());
        for (n, value) in family.values.iter_mut().enumerate() {
            *value = g(core::array::from_fn(|a| {
                (2.0 * f64::from(family.position[a]) + (n >> a & 1) as f64 + 0.5) * edge
            }));
        }
    }
    families
}

#[test]
fn polynomials_below_the_order_are_exact_at_any_point_across_levels() {
    for order in [3, 5, 7] {
        let degree = i32::try_from(order).unwrap() - 1;
        let g = |[x, y, z]: [f64; 3]| {
            x.powi(degree) * y - 2.0 * (y * z).powi(degree) + z.powi(degree - 1) + x + 3.0
        };
        let tree = uneven(order);
        let families = filled(&tree, g);
        let tree = WorldTree::from_families(boxed(UNIT), order, 3, &families).unwrap();
        let mut positions = points(4_000);
        positions.extend([[0.0; 3], [1.0; 3], [0.0, 1.0, 0.5], [0.25, 0.5, 0.125]]);
        for (position, rate) in positions.iter().zip(rates(&tree, &positions)) {
            assert!((rate - g(*position)).abs() < 1e-11, "order {order} at {position:?}");
        }
    }
}

/// A degree that the order does not reach is not exact: the test above can fail.
#[test]
fn polynomials_of_the_order_plus_one_are_not_exact() {
    let g = |[x, _, _]: [f64; 3]| x.powi(6);
    let tree = WorldTree::from_families(boxed(UNIT), 3, 3, &filled(&uneven(3), g)).unwrap();
    let positions = points(1_000);
    let error = positions.iter().zip(rates(&tree, &positions));
    let largest = error.map(|(p, rate)| (rate - g(*p)).abs()).fold(0.0, f64::max);
    assert!(largest > 1e-6 && largest < 1e-2, "{largest:e}");
}

#[test]
#[expect(clippy::float_cmp, reason = "values at centres are kept")]
fn the_values_at_the_centres_of_leaves_are_those_of_g() {
    let tree = uneven(5);
    for family in tree.families().filter(|family| family.level == tree.finest_level()) {
        let edge = 0.5_f64.powi(family.level.into());
        let centre = family.position.map(|p| (2.0 * f64::from(p) + 0.5) * edge);
        assert_eq!(family.values[0], peak(centre));
        assert!((rates(&tree, &[centre])[0] - peak(centre)).abs() < 1e-15);
    }
}

#[test]
fn a_box_anywhere_makes_the_same_tree() {
    let [min, max] = [[-3.0, 10.0, 0.5], [5.0, 12.0, 1.0]];
    let world = move |u: [f64; 3]| core::array::from_fn(|a| min[a] + u[a] * (max[a] - min[a]));
    let unit = move |r: [f64; 3]| core::array::from_fn(|a| (r[a] - min[a]) / (max[a] - min[a]));
    let options = WorldTreeOptions { base_level: 3, ..WorldTreeOptions::default() };
    let there = built(|r| peak(unit(r)), boxed([min, max]), &options);
    let here = built(peak, boxed(UNIT), &options);
    assert_eq!(there.evaluations, here.evaluations);
    let positions = points(500);
    let moved: Vec<_> = positions.iter().map(|&u| world(u)).collect();
    for (a, b) in rates(&there.tree, &moved).iter().zip(rates(&here.tree, &positions)) {
        assert!((a - b).abs() < 1e-12);
    }
    assert_eq!(rates(&there.tree, &[[-3.001, 11.0, 0.7], [0.0, 11.0, 1.001]]), [0.0, 0.0]);
}

#[test]
fn families_bring_every_bit_back() {
    for order in [3, 5, 7] {
        let tree = uneven(order);
        let families: Vec<Family> = tree.families().collect();
        let again = WorldTree::from_families(tree.bounds(), order, 3, &families).unwrap();
        assert_eq!(again.leaves_per_level(), tree.leaves_per_level());
        assert!(again.families().eq(families));
        let positions = points(3_000);
        let bits = |tree| rates(tree, &positions).into_iter().map(f64::to_bits).collect::<Vec<_>>();
        assert_eq!(bits(&again), bits(&tree));
    }
}

#[test]
fn the_value_does_not_depend_on_the_batch_nor_the_tree_on_threads() {
    let tree = uneven(5);
    let positions = points(300);
    let together = rates(&tree, &positions);
    for (position, rate) in positions.iter().zip(together) {
        assert_eq!(rates(&tree, &[*position])[0].to_bits(), rate.to_bits());
    }
    let with = |threads, batch_size| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let options = WorldTreeOptions { base_level: 3, batch_size, ..WorldTreeOptions::default() };
        let built = pool.install(|| built(peak, boxed(UNIT), &options));
        (built.evaluations, built.tree.families().collect::<Vec<_>>())
    };
    let one = with(1, u64::MAX);
    assert!(with(3, u64::MAX) == one && with(2, 100) == one);
}

#[test]
fn what_is_nowhere_negative_stays_so() {
    // A shell of rate 1 with jumps: polynomials through it undershoot.
    let shell = |[x, y, z]: [f64; 3]| {
        let r = (x * x + y * y + z * z).sqrt();
        f64::from(u8::from((0.5..0.8).contains(&r)))
    };
    let options = WorldTreeOptions { finest_level: Some(6), ..WorldTreeOptions::default() };
    let positive = built(shell, boxed(UNIT), &options);
    assert!(positive.unresolved_cells > 0 && positive.largest_dropped > positive.threshold);
    assert_eq!((positive.ending, positive.tree.finest_level()), (StopReason::Complete, 6));
    let positions = points(20_000);
    let lowest = rates(&positive.tree, &positions).into_iter().fold(f64::MAX, f64::min);
    assert_eq!(lowest.to_bits(), 0.0_f64.to_bits());
    // Where g may be negative nothing is cut.
    let shifted = built(move |r| shell(r) - 0.5, boxed(UNIT), &options);
    let lowest = rates(&shifted.tree, &positions).into_iter().fold(f64::MAX, f64::min);
    assert!(lowest < -0.51, "{lowest}");
}

#[test]
fn the_number_of_evaluations_is_what_g_has_counted() {
    let calls = core::sync::atomic::AtomicU64::new(0);
    let counted = |r| {
        calls.fetch_add(1, core::sync::atomic::Ordering::Relaxed);
        peak(r)
    };
    let options = WorldTreeOptions { base_level: 3, ..WorldTreeOptions::default() };
    let found = built(counted, boxed(UNIT), &options);
    let calls = || calls.load(core::sync::atomic::Ordering::Relaxed);
    assert_eq!(found.evaluations, calls());
    // The check of directions, and one evaluation for each cell that the tree has.
    assert_eq!(found.evaluations, 1_024 + found.tree.cells() as u64);
    let levels = u64::from(found.tree.finest_level() - 3 + 1);
    assert_eq!(found.batches, 2 + levels);
    assert_eq!((found.ending, found.unresolved_cells), (StopReason::Complete, 0));
    assert!(found.largest_dropped < found.threshold);
    assert!((found.threshold / found.largest_rate - 1e-3).abs() < 1e-12);
    let before = calls();
    rates(&found.tree, &points(100));
    assert_eq!(calls(), before);
}

#[test]
fn a_budget_ends_the_build_with_a_tree() {
    let options =
        WorldTreeOptions { base_level: 3, max_evaluations: 6_000, ..WorldTreeOptions::default() };
    let found = built(peak, boxed(UNIT), &options);
    assert_eq!(found.ending, StopReason::Budget);
    assert!(found.evaluations <= 6_000 && found.evaluations > 6_000 - 8);
    assert!(found.unresolved_cells > 0 && found.largest_dropped > found.threshold);
    // Not even the base grid can be split: it is still a tree.
    let options = WorldTreeOptions { max_evaluations: 1_536, ..options };
    let base = built(peak, boxed(UNIT), &options);
    assert_eq!((base.evaluations, base.tree.cells()), (1_536, 512));
    let centre = [0.3125, 0.5625, 0.0625];
    assert!((rates(&base.tree, &[centre])[0] - peak(centre)).abs() < 1e-15);
    // No detail is known: any may be as large as g.
    assert_eq!((base.unresolved_cells, base.largest_dropped), (512, base.largest_rate));
}

fn refused(options: &WorldTreeOptions<'_>) -> String {
    let g = FromFn(|r, _| peak(r));
    match build_world_tree(&g, boxed(UNIT), options) {
        Err(error) => error.to_string(),
        Ok(_) => String::new(),
    }
}

#[test]
fn options_out_of_range_are_refused() {
    let base = WorldTreeOptions::default();
    let order = WorldTreeOptions { order: 9, ..base };
    assert_eq!(refused(&order), "`order` is 9: expected 3, 5 or 7");
    let level = WorldTreeOptions { base_level: 2, ..base };
    assert_eq!(refused(&level), "`base_level` is 2: expected a level from 3 to 10");
    let finest = WorldTreeOptions { finest_level: Some(4), ..base };
    assert_eq!(refused(&finest), "`finest_level` is 4: expected 5 to 19");
    for tolerance in [0.0, 1.0, f64::NAN] {
        let expected =
            format!("`tolerance` is {tolerance}: expected a fraction above 0 and below 1");
        assert_eq!(refused(&WorldTreeOptions { tolerance, ..base }), expected);
    }
    let budget = WorldTreeOptions { max_evaluations: 5_119, ..base };
    assert_eq!(
        refused(&budget),
        "`max_evaluations` allows 5119 evaluations, but the base grid of level 4 with the check of \
         directions needs 5120"
    );
    let memory = WorldTreeOptions { base_level: 10, ..base };
    assert_eq!(
        refused(&memory),
        "a base grid of level 10 would take 128.0 GiB of memory: at most 8.0 GiB are allowed"
    );
}

#[test]
fn a_rate_that_depends_on_the_direction_is_refused() {
    let lopsided = FromFn(
        |[x, _, _]: [f64; 3], [_, _, dz]: [f64; 3]| {
            if x > 0.9 { 1.0 + 1e-6 * dz } else { 1.0 }
        },
    );
    let error = build_world_tree(&lopsided, boxed(UNIT), &WorldTreeOptions::default());
    let error = error.unwrap_err();
    assert_eq!(
        error.to_string(),
        "the emission rate at position [0.9375, 0.0625, 0.0625] is 1.00000064 towards [0.48, 0.6, \
         0.64] and 1.00000048 towards [-0.8, -0.36, 0.48]: expected the same in all directions, a \
         tree of positions has only one"
    );
    // A sum in another order is no direction.
    let rounded = FromFn(|[x, _, _]: [f64; 3], [_, _, dz]: [f64; 3]| (x + dz) - dz);
    assert!(build_world_tree(&rounded, boxed(UNIT), &WorldTreeOptions::default()).is_ok());
}

#[test]
fn an_emission_that_fails_or_is_interrupted_ends_the_build() {
    let hole = FromFn(|[x, _, _]: [f64; 3], _: [f64; 3]| if x > 0.99 { f64::NAN } else { x });
    let options = WorldTreeOptions { base_level: 6, ..WorldTreeOptions::default() };
    let error = build_world_tree(&hole, boxed(UNIT), &options).unwrap_err();
    assert!(error.to_string().starts_with("the emission rate is NaN at position [0.99"), "{error}");
    let stop = |evaluations| {
        if evaluations > 2_000 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let options = WorldTreeOptions { progress: Some(&stop), ..options };
    let error = build_world_tree(&FromFn(|r, _| peak(r)), boxed(UNIT), &options).unwrap_err();
    assert_eq!(error, WorldTreeError::Render(RenderError::Interrupted));
}

#[test]
fn families_that_make_no_tree_are_named() {
    let families: Vec<Family> = uneven(3).families().collect();
    let error = |change: &dyn Fn(&mut Vec<Family>)| {
        let mut broken = families.clone();
        change(&mut broken);
        let tree = WorldTree::from_families(boxed(UNIT), 3, 3, &broken);
        tree.map(|tree| tree.cells()).unwrap_err().to_string()
    };
    let count = families.len();
    assert_eq!(
        error(&|f| f.truncate(63)),
        "there are 63 families: expected at least 64, those of the base grid"
    );
    assert_eq!(
        error(&|f| f.swap(1, 2)),
        "family 1 is at [2, 0, 0] of level 3: expected [1, 0, 0] of the base level 3, the first \
         axis fastest"
    );
    assert_eq!(
        error(&|f| f[70].level = 6),
        "family 70 is of level 6: expected 4, or one more, up to 19"
    );
    assert_eq!(
        error(&|f| f[64].position = [8, 0, 0]),
        "family 64 at [8, 0, 0] of level 4 fills a cell that the tree has not"
    );
    assert_eq!(
        error(&|f| f[65].position = f[64].position),
        format!(
            "family 65 at {:?} of level 4 comes twice: expected each one once",
            families[64].position
        )
    );
    assert_eq!(
        error(&|f| f[count - 1].values[3] = f64::INFINITY),
        format!("family {} has the value inf: expected a finite number", count - 1)
    );
    let of = |order, base| WorldTree::from_families(boxed(UNIT), order, base, &families);
    assert_eq!(of(4, 3).unwrap_err().to_string(), "the order is 4: expected 3, 5 or 7");
    assert_eq!(of(3, 11).unwrap_err().to_string(), "the base level is 11: expected 3 to 10");
    // A base grid alone is a tree, and so is one with a level less.
    assert_eq!(WorldTree::from_families(boxed(UNIT), 3, 3, &families[..64]).unwrap().cells(), 512);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// On one level neighbouring polynomials meet: a small step changes little, wherever it is.
    #[test]
    fn the_value_is_continuous_within_a_level(
        from in prop::array::uniform3(0.01..0.99_f64),
        order in prop::sample::select(vec![3_usize, 5, 7]),
    ) {
        // A wave that the base grid hardly resolves, and no cell is refined further.
        let wave = |[x, y, z]: [f64; 3]| (25.0 * x).sin() * (31.0 * y + 17.0 * z).cos();
        let options = WorldTreeOptions { order, base_level: 3, finest_level: Some(4), ..WorldTreeOptions::default() };
        let tree = built(wave, boxed(UNIT), &options).tree;
        // Steps over the faces between cells and over their centres.
        for face in 0..32 {
            let mut pair = [from; 2];
            let x = f64::from(face) / 32.0;
            pair[0][1] = (x - 1e-9).max(0.0);
            pair[1][1] = x + 1e-9;
            let [a, b]: [f64; 2] = rates(&tree, &pair).try_into().unwrap_or_default();
            prop_assert!((a - b).abs() < 1e-6, "{a} {b} at {x}");
        }
    }
}
