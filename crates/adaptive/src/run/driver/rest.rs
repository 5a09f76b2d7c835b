//! The end of a run whose bodies have come to rest.

use super::Driver;

impl Driver<'_> {
    /// Notes after a step whether the bodies are as slow as `stop_at_rest` asks for: by the root of
    /// their mean square speed `sqrt(2 T / m)`, with the kinetic energy `T` and the mass `m` of all
    /// bodies.
    pub(super) fn note_rest(&mut self) {
        let Some(rest) = self.settings.stop_at_rest else { return };
        let (t, y) = (self.integrator.time(), self.integrator.state());
        let mass: f64 = self.model.bodies.iter().map(|b| b.data.mass).filter(|m| m.is_finite()).sum();
        let is_slow = 2.0 * self.model.system.invariants(t, y).kinetic <= mass * rest.speed * rest.speed;
        self.run.slow_since = is_slow.then(|| self.run.slow_since.unwrap_or(t));
    }

    /// Whether the bodies have been slow for as long as `stop_at_rest` asks for.
    pub(super) fn is_at_rest(&self) -> bool {
        let slow = self.settings.stop_at_rest.zip(self.run.slow_since);
        slow.is_some_and(|(rest, since)| self.integrator.time() - since >= rest.duration)
    }
}
