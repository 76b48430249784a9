//! The program `lariat-bench`.

use std::process::ExitCode;

fn main() -> ExitCode {
    lariat_bench::run()
}
