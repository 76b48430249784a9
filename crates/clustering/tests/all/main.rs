//! All tests of the public interface in one binary, which is built and linked once.

mod allocation;
mod clusterings;
mod kmeans;
