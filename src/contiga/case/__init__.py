"""The case file: TOML to a checked Case to a Simulation."""

from contiga.extras import require

require("a case file", "pydantic")
