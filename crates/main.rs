//! Thin entry point: parse, call, map to an exit code.

use fbimpact::process::{allocation, provenance::Build};

#[global_allocator]
static ALLOCATOR: allocation::EndingAllocator = allocation::EndingAllocator;

const BUILD: Build = Build {
    commit: env!("FBIMPACT_COMMIT"),
    compiler: env!("FBIMPACT_COMPILER"),
    target: env!("FBIMPACT_TARGET"),
};

fn main() -> std::process::ExitCode {
    allocation::prepare();
    allocation::on_enough_stack(|| fbimpact::main_with(BUILD, std::env::args_os()))
}
