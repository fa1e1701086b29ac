//! Living instances by handle.
//!
//! The pointer a host holds is a number never used twice, not an address: a null, freed, foreign
//! or made-up handle is looked up, not dereferenced. An instance in use by one thread refuses a
//! second one instead of racing or waiting.

use std::any::Any;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError, RwLock};

use crate::c::logger::Logger;
use crate::instance::Instance;
use crate::model::FmuModel;

/// An instance with the way to its host's log.
pub(crate) struct Entry<M: FmuModel> {
    pub(crate) instance: Mutex<Instance<M>>,
    pub(crate) logger: Logger,
}

static ENTRIES: RwLock<BTreeMap<usize, Arc<dyn Any + Send + Sync>>> = RwLock::new(BTreeMap::new());
static NEXT: AtomicUsize = AtomicUsize::new(1);

/// Hosts may print handles or tag the low bits of pointers, so handles look like aligned ones.
const STRIDE: usize = 16;

pub(crate) fn insert<M: FmuModel>(instance: Instance<M>, logger: Logger) -> usize {
    let handle = STRIDE * NEXT.fetch_add(1, Ordering::Relaxed);
    let entry = Arc::new(Entry { instance: Mutex::new(instance), logger });
    ENTRIES.write().unwrap_or_else(PoisonError::into_inner).insert(handle, entry);
    handle
}

pub(crate) fn find<M: FmuModel>(handle: usize) -> Option<Arc<Entry<M>>> {
    let entries = ENTRIES.read().unwrap_or_else(PoisonError::into_inner);
    let entry = entries.get(&handle)?.clone();
    drop(entries);
    entry.downcast::<Entry<M>>().ok()
}

/// Forgets an instance; it is dropped once no call uses it.
pub(crate) fn remove(handle: usize) -> Option<Arc<dyn Any + Send + Sync>> {
    ENTRIES.write().unwrap_or_else(PoisonError::into_inner).remove(&handle)
}
