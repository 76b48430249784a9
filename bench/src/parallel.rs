//! Pictures, drawn and processed by several threads.

use std::sync::atomic::{AtomicUsize, Ordering};

use anyhow::Result;

/// Number of threads.
const THREADS: usize = 2;

/// Calls `look` with each item, and returns all that it adds, in the items' order.
pub(crate) fn in_parallel<T: Sync, O: Send>(
    items: &[T],
    look: impl Fn(&T, &mut Vec<O>) -> Result<()> + Sync,
) -> Result<Vec<O>> {
    let next = AtomicUsize::new(0);
    let work = || {
        let mut found = Vec::new();
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            let Some(item) = items.get(number) else {
                return anyhow::Ok(found);
            };
            let mut of_item = Vec::new();
            look(item, &mut of_item)?;
            found.push((number, of_item));
        }
    };
    let mut all = std::thread::scope(|scope| {
        let threads = [(); THREADS].map(|()| scope.spawn(work));
        let mut all = Vec::new();
        for thread in threads {
            all.extend(thread.join().expect("the thread does not panic")?);
        }
        anyhow::Ok(all)
    })?;
    all.sort_by_key(|(number, _)| *number);
    Ok(all.into_iter().flat_map(|(_, of_item)| of_item).collect())
}
