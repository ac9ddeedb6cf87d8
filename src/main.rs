fn main() -> std::process::ExitCode {
    farfield::cli::main()
}
