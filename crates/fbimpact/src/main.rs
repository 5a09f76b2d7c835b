//! Thin entry point: parse, call, map to an exit code.

#[global_allocator]
static ALLOCATOR: fbimpact::allocation::EndingAllocator = fbimpact::allocation::EndingAllocator;

fn main() -> std::process::ExitCode {
    fbimpact::allocation::prepare();
    fbimpact::main_with(std::env::args_os())
}
