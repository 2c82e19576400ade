//! What a rendering begins with: the structure that another one has found.

use core::any::Any;
use std::sync::Arc;

/// What a method has found about a view and an emission, for the same method.
#[derive(Clone)]
pub(crate) struct Structure {
    of_method: Arc<dyn Any + Send + Sync>,
    /// Whether it has products for some part of the view: their points are far fewer than those of a rendering.
    pub(crate) has_products: bool,
}

impl Structure {
    pub(crate) fn new(of_method: impl Any + Send + Sync, has_products: bool) -> Self {
        Self { of_method: Arc::new(of_method), has_products }
    }

    /// The structure, if it is of this type.
    pub(crate) fn of_method<T: Any>(&self) -> Option<&T> {
        self.of_method.downcast_ref()
    }
}

impl core::fmt::Debug for Structure {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Structure").finish_non_exhaustive()
    }
}

/// The structure that a rendering begins with.
#[derive(Clone, Debug)]
pub(crate) struct Start {
    /// `None` if the mesh has none for another emission.
    pub(crate) structure: Option<Structure>,
    /// Whether the rendering ends where the structure does not suffice, instead of beginning anew.
    pub(crate) is_fixed: bool,
}
