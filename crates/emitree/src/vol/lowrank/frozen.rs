//! The interpolant of a part as a linear map from its values at the triples of pivots.

use crate::vol::lowrank::interpolant::Interpolant;
use crate::vol::lowrank::search::Search;
use crate::vol::lowrank::start::Functions;
use crate::vol::view::products::{CoreToMeans, FrozenProducts};
use std::sync::Arc;

impl CoreToMeans for Interpolant {
    fn means(&self, core: &[f64], shape: [usize; 2]) -> Vec<f64> {
        self.with_core(core).means(shape)
    }
}

impl Search<'_> {
    /// The present interpolant, whose functions are given, with frozen functions.
    pub(super) fn frozen(&self, Functions(functions): &Functions) -> FrozenProducts {
        let nodes = self.interpolant.triples().iter().map(|u| self.view.terms(*u)).collect();
        FrozenProducts { nodes: Arc::new(nodes), interpolant: functions.clone() }
    }

    /// The functions of the present interpolant.
    pub(super) fn functions(&self) -> Functions {
        Functions(Arc::new(self.interpolant.clone()))
    }
}
