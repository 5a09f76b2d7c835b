//! Thin entry point: parse, call, map to an exit code.

#[global_allocator]
static ALLOCATOR: fbimpact::process::allocation::EndingAllocator =
    fbimpact::process::allocation::EndingAllocator;

fn main() -> std::process::ExitCode {
    fbimpact::process::allocation::prepare();
    fbimpact::process::allocation::on_enough_stack(|| fbimpact::main_with(std::env::args_os()))
}
