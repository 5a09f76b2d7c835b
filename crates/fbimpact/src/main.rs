//! Thin entry point: parse, call, map to an exit code.

fn main() -> std::process::ExitCode {
    fbimpact::main_with(std::env::args_os())
}
