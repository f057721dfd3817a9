"""Built-in mapping profiles (TOML). The schema is described in `parsers.mapping.profiles`."""
