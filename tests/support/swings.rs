//! Pendulums.

use adaptive::run::recording::Recording;

/// Period of the first joint's swing about zero from its first two passages, on straight lines between samples \[s\].
pub fn period(recording: &Recording) -> f64 {
    let samples = &recording.samples;
    let angle = |i: usize| samples[i].joints[0].positions[0];
    let crossing = |i: usize| {
        let share = angle(i - 1) / (angle(i - 1) - angle(i));
        samples[i - 1].time + share * (samples[i].time - samples[i - 1].time)
    };
    let mut crossings = (1..samples.len()).filter(|&i| angle(i - 1) * angle(i) < 0.0).map(crossing);
    let mut next = || crossings.next().expect("it passes zero twice");
    let first = next();
    2.0 * (next() - first)
}
