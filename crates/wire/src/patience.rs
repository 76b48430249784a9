//! Lets a lossless writer wait for a reader whose buffer is full. The writer waits as long as the
//! reader lives. When told to stop, it waits a little longer, so that earlier messages are still
//! delivered.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use iceoryx2::port::{BackpressureAction, BackpressureInfo};
use iceoryx2::prelude::*;

use crate::channel::Delivery;
use crate::domain::root_of;
use crate::door::Passing;
use crate::{Domain, now_ns, quiet, tidy};

/// Interval at which a waiting writer checks whether the reader was killed.
const DEAD_READER_CHECK: Duration = Duration::from_millis(500);
/// Interval at which a waiting writer calls its `meanwhile` function.
pub(crate) const LOOK: Duration = Duration::from_millis(50);
/// Time from the stop flag until a writer gives up, so that a living but stuck reader cannot hold
/// it forever.
const AFTER_STOP: Duration = Duration::from_secs(3);

/// Function called repeatedly while a lossless writer waits. It may find that the writer must stop.
pub(crate) type Meanwhile = Arc<dyn Fn() + Send + Sync>;

/// Handler of full buffers for a lossless writer; `None` for a writer that does not wait.
pub(crate) fn with_slow_readers(
    domain: &Domain,
    delivery: &Delivery,
    meanwhile: Option<Meanwhile>,
) -> Option<impl Fn(&BackpressureInfo) -> BackpressureAction + Send + 'static + use<>> {
    let Delivery::Lossless { stop } = delivery else {
        return None;
    };
    let stop = stop.clone();
    let config = domain.config().clone();
    let stop_noticed_ns = AtomicU64::new(0);
    let next_check_ns = AtomicU64::new(0);
    let next_look_ns = AtomicU64::new(0);
    Some(move |waiting: &BackpressureInfo| {
        quiet::let_through();
        let now_ns = now_ns();
        if let Some(meanwhile) = &meanwhile
            && now_ns >= next_look_ns.load(Ordering::Relaxed)
        {
            next_look_ns.store(now_ns + LOOK.as_nanos() as u64, Ordering::Relaxed);
            meanwhile();
        }
        if !stop.load(Ordering::Relaxed) {
            stop_noticed_ns.store(0, Ordering::Relaxed);
        } else {
            let before = stop_noticed_ns.load(Ordering::Relaxed);
            let noticed_ns = if before == 0 { now_ns } else { before };
            stop_noticed_ns.store(noticed_ns, Ordering::Relaxed);
            if now_ns - noticed_ns > AFTER_STOP.as_nanos() as u64 {
                return BackpressureAction::DiscardDataAndFail;
            }
        }
        let check = DEAD_READER_CHECK.as_nanos() as u64;
        if waiting.retries == 0 {
            next_check_ns.store(now_ns + check, Ordering::Relaxed);
        } else if now_ns >= next_check_ns.load(Ordering::Relaxed) {
            next_check_ns.store(now_ns + check, Ordering::Relaxed);
            // The writer no longer waits for a reader that is removed.
            remove_the_dead(&config);
        }
        BackpressureAction::Retry
    })
}

/// Removes what killed processes left.
fn remove_the_dead(config: &Config) {
    // If another process is joining or leaving, that process does this, or the next check does.
    if let Some(passing) = Passing::at_once(&root_of(config)) {
        tidy::finish(config, &passing);
    }
}
