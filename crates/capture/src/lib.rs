//! Frame sources: files, video and a rendered rope with known truth.
