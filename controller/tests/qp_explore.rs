//! Exploration.
#![allow(clippy::all, clippy::unwrap_used, clippy::print_stdout)]
mod support;
use controller::config::{SolverConfig, SolverMethod};
use controller::fhocp::*;
use support::*;
#[test]
fn explore() {
    let count: usize = std::env::var("COUNT").map(|c| c.parse().unwrap()).unwrap_or(300);
    for setting in [
        Setting::race(10, 40, 1),
        Setting::race(20, 64, 2),
        Setting::every_row(10, 40, 3),
        Setting::every_row(20, 64, 4),
        Setting::paper(12, 24, 5),
        Setting::race(40, 96, 6),
    ] {
        let problems = closed_loop(&setting, count);
        let mut exact = ClarabelSolver::new(SolverConfig {
            method: SolverMethod::Clarabel,
            tolerance: 1e-10,
            max_iterations: 200,
        });
        let mut clarabel = ClarabelSolver::new(SolverConfig {
            method: SolverMethod::Clarabel,
            tolerance: 1e-8,
            max_iterations: 60,
        });
        let mut ours = RiccatiSolver::new(SolverConfig {
            method: SolverMethod::Clarabel,
            tolerance: 1e-8,
            max_iterations: 60,
        });
        let (mut err, mut its, mut bad, mut cerr) = (vec![], vec![], 0, vec![]);
        let mut speed = 0.0;
        let (mut exact_fail, mut c_fail) = (0, 0);
        let mut t_ours = vec![];
        let mut t_c = vec![];
        let mut cits = vec![];
        let mut cost_err: f64 = 0.0;
        let mut gs: Vec<f64> = problems.iter().map(growth).collect();
        gs.sort_by(f64::total_cmp);
        if false {
            println!(
                "growth med {:.1e} p90 {:.1e} max {:.1e}",
                gs[gs.len() / 2],
                gs[gs.len() * 9 / 10],
                gs[gs.len() - 1]
            );
        }
        for (k, p) in problems.iter().enumerate() {
            speed += p.x_0[0] / problems.len() as f64;
            let mut s = Solution::new(p.horizon(), p.hull.len());
            let mut e = s.clone();
            let mut c = s.clone();
            let rep = exact.solve(p, &mut e);
            let start = std::time::Instant::now();
            let crep = clarabel.solve(p, &mut c);
            t_c.push(start.elapsed().as_secs_f64() * 1e6);
            cits.push(crep.iterations);
            if !crep.status.usable() {
                c_fail += 1;
            }
            let start = std::time::Instant::now();
            let r = ours.solve(p, &mut s);
            t_ours.push(start.elapsed().as_secs_f64() * 1e6);
            its.push(r.iterations);
            if !r.status.usable() {
                bad += 1;
                if bad < 4 {
                    println!("bad {k} {r:?} exact {rep:?} growth {:.1e}", growth(p));
                }
                continue;
            }
            if !rep.status.usable() {
                exact_fail += 1;
                continue;
            }
            err.push((s.u[0] - e.u[0]).amax());
            if (s.u[0] - e.u[0]).amax() > 1e-3 {
                println!(
                    "err {k} {} {r:?} exact {rep:?} cost {} {}",
                    (s.u[0] - e.u[0]).amax(),
                    p.cost(&s),
                    p.cost(&e)
                );
            }
            cost_err = cost_err.max((p.cost(&s) - p.cost(&e)).abs() / (1.0 + p.cost(&e).abs()));
            cerr.push((c.u[0] - e.u[0]).amax());
        }
        err.sort_by(f64::total_cmp);
        cerr.sort_by(f64::total_cmp);
        its.sort();
        cits.sort();
        t_ours.sort_by(f64::total_cmp);
        t_c.sort_by(f64::total_cmp);
        let q = |v: &[f64], p: f64| {
            v.get(((v.len() as f64 * p) as usize).min(v.len().saturating_sub(1)))
                .copied()
                .unwrap_or(f64::NAN)
        };
        let sum: u32 = its.iter().sum();
        println!(
            "N{} K{} {} bad {bad}/{exact_fail}/{c_fail} it mean {:.2} med {} p99 {} max {} cl {} {} | err med {:.1e} p99 {:.1e} p999 {:.1e} max {:.1e} cost {cost_err:.1e} clarabel {:.1e} {:.1e} {:.1e} | us {:.1} {:.1} {:.1} clarabel {:.0} {:.0}",
            setting.horizon,
            setting.hull,
            setting.rate_limits,
            sum as f64 / its.len() as f64,
            its[its.len() / 2],
            its[its.len() * 99 / 100],
            its[its.len() - 1],
            cits[cits.len() / 2],
            cits[cits.len() - 1],
            q(&err, 0.5),
            q(&err, 0.99),
            q(&err, 0.999),
            q(&err, 1.0),
            q(&cerr, 0.5),
            q(&cerr, 0.99),
            q(&cerr, 1.0),
            q(&t_ours, 0.0),
            q(&t_ours, 0.5),
            q(&t_ours, 0.99),
            q(&t_c, 0.0),
            q(&t_c, 0.5)
        );
    }
}

fn growth(p: &Fhocp) -> f64 {
    let mut m = nalgebra::Matrix6::identity();
    let mut g: f64 = 0.0;
    for a in &p.model {
        m = a.a * m;
        g = g.max(m.amax());
    }
    g
}
