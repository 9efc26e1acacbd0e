"""`python -m benchmarks`: every benchmark, one after the other."""

from __future__ import annotations

from benchmarks import area, area_errors, faceted, mesher, startup, tracking
from contiga.num.threads import thread_count


def main() -> None:
    """Print the tables."""
    print(f"{thread_count()} threads")
    for title, run in (
        ("Tracking", tracking.run),
        ("Faceted", faceted.run),
        ("Mesher", mesher.run),
        ("Area", area.run),
        ("Errors of the area", area_errors.run),
        ("Start", startup.run),
    ):
        print(f"\n{title}")
        for line in run():
            print(f"  {line}", flush=True)


if __name__ == "__main__":
    main()
