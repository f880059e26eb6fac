//! Clarke and Park of the core against what a real drive computed from the same currents.

use bearing_watch::drive::AlphaBeta;
use bearing_watch::{Angle, Park};
use host_tests::{data, table};
use std::f64::consts::{PI, TAU};

#[test]
fn magnitudes_and_angle_of_a_recorded_drive() {
    let Some(folder) = data("odtu_pmsm") else { return };
    // t_s, then ia_A, ib_A, speed_rpm, fsw_Hz, id_A, iq_A; twenty pole pairs.
    let (_, rows) = table(&folder.join("park_50rpm.csv"));
    let times: Vec<f64> = rows.iter().map(|(t, _)| t.parse().expect("time")).collect();
    let (mut stator, mut rotor) = (0.0, 0.0);
    let (mut shaft, mut differences, mut before) = (0.0, Vec::new(), 0.0);
    for (k, (_, row)) in rows.iter().enumerate() {
        let [ia, ib, speed_rpm, _, id, iq] = row[..] else { panic!("six columns") };
        let ab = AlphaBeta::from_two(ia as f32, ib as f32);
        let (alpha, beta) = (f64::from(ab.alpha), f64::from(ab.beta));
        stator += alpha.hypot(beta);
        rotor += id.hypot(iq);
        let omega = speed_rpm * TAU / 60.0;
        if k > 0 {
            shaft += 0.5 * (omega + before) * (times[k] - times[k - 1]);
        }
        before = omega;
        differences.push(beta.atan2(alpha) - iq.atan2(id) - 20.0 * shaft);
    }
    let n = rows.len() as f64;
    println!("mean |i| in the stator frame {:.4} A, as the drive's dq {:.4} A", stator / n, rotor / n);
    assert!((stator / n / 0.9452 - 1.0).abs() < 1e-3 && (rotor / n / 0.9427 - 1.0).abs() < 1e-3);

    // Spread of an angle: take the mean direction off, wrap, then the standard deviation.
    let (s, c) = differences.iter().fold((0.0, 0.0), |(s, c), d| (s + d.sin(), c + d.cos()));
    let offset = f64::atan2(s, c);
    let wrapped = |d: f64| (d - offset + PI).rem_euclid(TAU) - PI;
    let sd = (differences.iter().map(|d| wrapped(*d).powi(2)).sum::<f64>() / n).sqrt().to_degrees();
    println!("electrical angle against 20 times the integrated speed: {sd:.2} degrees sd");
    assert!(sd <= 5.5, "{sd}");
    // Noise of the currents and the drive's own delay make it nowhere near exact.
    assert!(sd > 1.0, "{sd}");

    // Park with that angle, from the core, gives the drive's own dq currents back on average.
    let (mut d, mut q, mut shaft, mut before) = (0.0, 0.0, 0.0, 0.0);
    let (mut drive_d, mut drive_q) = (0.0, 0.0);
    for (k, (_, row)) in rows.iter().enumerate() {
        let omega = row[2] * TAU / 60.0;
        if k > 0 {
            shaft += 0.5 * (omega + before) * (times[k] - times[k - 1]);
        }
        before = omega;
        let turns = (20.0 * shaft + offset) / TAU;
        let angle = Angle::from_bits((turns.rem_euclid(1.0) * 4_294_967_296.0) as u32);
        let dq = Park::Standard.forward(AlphaBeta::from_two(row[0] as f32, row[1] as f32), angle.sin_cos());
        (d, q) = (d + f64::from(dq.d), q + f64::from(dq.q));
        (drive_d, drive_q) = (drive_d + row[4], drive_q + row[5]);
    }
    println!("mean dq from the core {:.3}, {:.3}; the drive's {:.3}, {:.3}", d / n, q / n, drive_d / n, drive_q / n);
    // An angle scattered by 5.2° shrinks means by 1 − cos ≈ 0.4 %, and the two sensors differ by 0.3 %.
    assert!((d - drive_d).abs() / n < 0.02 && (q - drive_q).abs() / n < 0.02);
}

#[test]
fn turning_the_phases_by_one_turns_the_angle_by_a_third() {
    use bearing_watch::drive::Abc;
    for k in 0..100_u32 {
        let angle = Angle::from_bits(k.wrapping_mul(0x0123_4567));
        let (a, b, c) = (1.5, -2.25, 0.5);
        let one = Park::Standard.forward(Abc { a, b, c }.clarke(), angle.sin_cos());
        let third = Angle::from_bits(0x5555_5555);
        let other = Park::Standard.forward(Abc { a: c, b: a, c: b }.clarke(), angle.plus(third).sin_cos());
        // Currents of a few amperes, sines to 2e-7.
        assert!((one.d - other.d).abs() < 5e-6 && (one.q - other.q).abs() < 5e-6);
    }
}
