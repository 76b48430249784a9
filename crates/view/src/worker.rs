//! A thread for a client's slow tasks: encoding and tracing pictures, picking colors.
//!
//! It runs at low priority, so the chain's stages go first. The client's own thread stays at normal
//! priority and sends short messages on time, however busy the machine is.

use std::os::fd::OwnedFd;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::Builder;

use lariat_chain::stages::arrangement::give_way;
use tungstenite::Message;

use crate::hub::ring;

/// Maximum number of waiting tasks. A client that asks for more waits for the first to be done.
const MOST_WAITING: usize = 4;

/// Tasks of one client, done in order.
pub(crate) struct Worker<T> {
    tasks: Sender<T>,
    done: Receiver<Vec<Message>>,
    waiting: usize,
}

impl<T: Send + 'static> Worker<T> {
    /// Starts the thread. It turns each task into the messages that answer it, and signals `bell`
    /// when they are ready.
    ///
    /// # Errors
    /// Fails if no thread can be started.
    pub(crate) fn start(
        bell: Arc<OwnedFd>,
        mut work: impl FnMut(T) -> Vec<Message> + Send + 'static,
    ) -> std::io::Result<Self> {
        let (tasks, to_do) = channel();
        let (finished, done) = channel();
        // The usual stack: an extraction needs more than a client's own thread has.
        let thread = Builder::new().name("view-worker".into());
        thread.spawn(move || {
            give_way();
            for task in to_do {
                if finished.send(work(task)).is_err() {
                    return;
                }
                ring(&bell);
            }
        })?;
        Ok(Self {
            tasks,
            done,
            waiting: 0,
        })
    }

    /// True if no task is left.
    pub(crate) fn is_idle(&self) -> bool {
        self.waiting == 0
    }

    /// Adds a task. If it has to wait for an earlier task, returns the messages of that task.
    /// Returns `None` if the thread has ended.
    pub(crate) fn add(&mut self, task: T) -> Option<Vec<Message>> {
        let mut messages = Vec::new();
        if self.waiting == MOST_WAITING {
            messages = self.done.recv().ok()?;
            self.waiting -= 1;
        }
        self.tasks.send(task).ok()?;
        self.waiting += 1;
        Some(messages)
    }

    /// Returns the messages of the next task that is done.
    pub(crate) fn next(&mut self) -> Option<Vec<Message>> {
        let messages = self.done.try_recv().ok()?;
        self.waiting -= 1;
        Some(messages)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rustix::event::{EventfdFlags, eventfd};

    #[test]
    fn tasks_are_answered_in_order_and_one_too_many_waits() {
        let bell = Arc::new(eventfd(0, EventfdFlags::CLOEXEC).expect("a bell"));
        let work = |task: u8| vec![Message::binary(vec![task])];
        let mut worker = Worker::start(bell.clone(), work).expect("a thread");
        let mut answers = Vec::new();
        for task in 0..10 {
            answers.extend(worker.add(task).expect("it works"));
        }
        assert_eq!(answers.len(), 10 - MOST_WAITING);
        while answers.len() < 10 {
            let mut count = [0; 8];
            rustix::io::read(&*bell, &mut count).expect("it rings");
            while let Some(more) = worker.next() {
                answers.extend(more);
            }
        }
        let expected: Vec<_> = (0..10).map(|task| Message::binary(vec![task])).collect();
        assert_eq!(answers, expected);
    }

    #[test]
    fn a_worker_that_panicked_is_noticed() {
        let bell = Arc::new(eventfd(0, EventfdFlags::CLOEXEC).expect("a bell"));
        let work = |(): ()| panic!("a fault");
        let mut worker = Worker::start(bell, work).expect("a thread");
        let is_noticed = (0..=MOST_WAITING).any(|_| worker.add(()).is_none());
        assert!(is_noticed);
    }
}
