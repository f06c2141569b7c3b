//! Stiff and extreme cases with every algorithm, in its settings that promise something.

use tetrascope_testing::say;
use xtask::stability::{Case, Group, Matrix, OTHERS, suite, under};
use xtask::testing::{algorithms, context};

/// Draws the cases of a group, and fails with all that is wrong: each in its own optical model, and in one of
/// the others, which take turns. `cargo xtask stability` draws each in all.
fn check(group: Group) {
    let mut cases = suite();
    for (turn, model) in OTHERS.into_iter().enumerate() {
        let others = under(model).into_iter().enumerate();
        let is_its_turn = |(i, case): (usize, Case)| (i % OTHERS.len() == turn).then_some(case);
        cases.extend(others.filter_map(is_its_turn));
    }
    cases.retain(|case| case.group == group);
    let mut algorithms = algorithms(&format!("stability: {}", group.name()));
    algorithms.retain(|algorithm| !algorithm.is_truth());
    let matrix = Matrix::draw(&cases, &algorithms, context()).expect("the ground truth draws all");
    say(&matrix.to_table());
    let faults = matrix.faults();
    assert!(matrix.passed(), "{}", faults.join("\n"));
}

#[test]
fn stiff_transfer_functions_are_drawn_as_promised() {
    check(Group::Stiff);
}

#[test]
fn extreme_meshes_are_drawn_as_promised() {
    check(Group::Geometry);
}

#[test]
fn extreme_views_are_drawn_as_promised() {
    check(Group::Views);
}

#[test]
fn extreme_values_are_drawn_as_promised() {
    check(Group::Values);
}

#[test]
fn extreme_grids_are_drawn_as_promised() {
    check(Group::Grids);
}

#[test]
fn laws_of_physics_hold() {
    check(Group::Laws);
}
