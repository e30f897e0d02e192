"""Every law on every scene that suits it, as one table: `crane league`."""
