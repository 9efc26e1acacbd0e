"""The case file: TOML to a checked Case to a Simulation."""
