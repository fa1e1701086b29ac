//! Single cases at the edges, which chance does not meet or cannot tell apart.

use super::*;

fn offer() -> Offer {
    let mut plan = [Input::default(); PLAN];
    plan[..3].copy_from_slice(&[1.0, 1.5, 2.0].map(|a| Input { a, delta: 0.0 }));
    Offer {
        drives: true,
        arrival_ns: 1000 * MS,
        valid_for_ns: 200 * MS,
        input: Input { a: 0.5, delta: 0.0 },
        plan,
        n_plan: 3,
        plan_dt: 0.05,
        ..Offer::default()
    }
}

/// The acceleration asked, and whether it is the plan's.
fn at(offer: &Offer, age_ms: i64) -> Option<(f64, bool)> {
    offer.input_at((1000 + age_ms) * MS, 50 * MS).map(|(u, planned)| (u.a, planned))
}

#[test]
fn a_command_becomes_its_plan_and_then_nothing() {
    let offer = offer();
    assert_eq!(at(&offer, 0), Some((0.5, false)));
    assert_eq!(at(&offer, 50), Some((0.5, false)));
    assert_eq!(at(&offer, 51), Some((1.5, true)), "the plan's second step has begun");
    assert_eq!(at(&offer, 101), Some((2.0, true)));
    assert_eq!(at(&offer, 199), Some((2.0, true)), "its last step lasts");
    assert_eq!(at(&offer, 200), Some((2.0, true)));
    assert_eq!(at(&offer, 201), None);
    assert_eq!(at(&Offer { drives: false, ..offer }, 0), None);
    assert_eq!(at(&Offer { plan_dt: 0.0, ..offer }, 60), Some((1.0, true)));
    assert_eq!(at(&Offer { n_plan: 0, ..offer }, 60), Some((0.5, true)));
    // More steps than are kept are the steps that are kept.
    assert_eq!(Offer { n_plan: PLAN + 1, ..offer }.plan().len(), PLAN);
}

#[test]
fn the_box_gives_way_by_a_tolerance_and_no_more() {
    let limiter = rules().limiter;
    let within =
        |a: f64, delta: f64| Offer { input: Input { a, delta }, ..offer() }.in_range(&limiter);
    let plan_within = |a: f64, delta: f64| {
        let mut offer = offer();
        offer.input.a = 0.0;
        offer.plan[2] = Input { a, delta };
        offer.in_range(&limiter)
    };
    let (least, most, angle) = (limiter.a_min, limiter.a_max, limiter.delta_max);
    for (by, expected) in [(0.9e-4, true), (1.1e-4, false)] {
        for (a, delta) in
            [(least - by, 0.0), (most + by, 0.0), (0.0, angle + by), (0.0, -angle - by)]
        {
            assert_eq!(within(a, delta), expected, "{a} {delta}");
            assert_eq!(plan_within(a, delta), expected, "plan {a} {delta}");
        }
    }
}

#[test]
fn numbers_follow_in_a_window() {
    let follows = |seq: i64, last: Option<i64>| Offer { seq, ..offer() }.follows(last);
    assert!(follows(i64::MIN, None));
    assert!(follows(6, Some(5)) && follows(105, Some(5)));
    assert!(!follows(5, Some(5)) && !follows(4, Some(5)) && !follows(106, Some(5)));
    // Numbers of an attacker's choice do not overflow.
    assert!(!follows(i64::MAX, Some(i64::MIN)) && !follows(i64::MIN, Some(i64::MAX)));
}
