//! The command `varsac`; everything it does is in the library.

fn main() -> std::process::ExitCode {
    varsac_host::cli::main().into()
}
