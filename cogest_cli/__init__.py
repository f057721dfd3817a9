"""The `cogest` command: parses arguments, calls the library, prints, and turns errors into exit codes."""
