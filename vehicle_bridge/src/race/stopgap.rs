use std::sync::Arc;
use vehicle_model::*;
pub struct Plant { m: Discretized, track: Arc<Track>, x: State, u: Input }
impl Plant {
    pub fn new(car: CarParams, track: Arc<Track>, x: State, dt: f64) -> Self { Self { m: Discretized { model: Model::new(ModelKind::Dynamic, car), dt, substeps: 20 }, track, x, u: Input::default() } }
    pub fn measure(&mut self) -> State { self.x }
    pub fn truth(&self) -> State { self.x }
    pub fn applied(&self) -> Input { self.u }
    pub fn apply(&mut self, u: &Input, _dt: f64) { self.u = *u; self.x = self.m.next(&self.x, u, |s| self.track.kappa(s)); self.x.s = self.track.wrap(self.x.s); }
}
