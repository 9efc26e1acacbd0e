"""The help of each command: flags without values, examples, and its page in the documentation."""

from __future__ import annotations

from typing import Any

from typer.core import TyperCommand, TyperGroup

_PAGES = "https://github.com/contiga/contiga/blob/main/docs/"

_TEXTS: dict[str, tuple[str, tuple[str, ...]]] = {
    "": ("command-line.md", ("contiga run case.toml -o out", "contiga COMMAND --help")),
    "run": (
        "command-line.md",
        (
            "contiga run case.toml -o out",
            "contiga run case.toml --set time.end=20 --set contact[0].law.damping=0.2",
            "contiga run case.toml -o out --set time.end=40 --resume",
        ),
    ),
    "check": (
        "checks.md",
        ("contiga check case.toml", "contiga check case.toml --set contact[0].law.damping=0.2"),
    ),
    "preview": ("command-line.md", ("contiga preview case.toml -o case.png",)),
    "info": ("meshes.md", ("contiga info part.step", "contiga info pad.k")),
    "mesh": (
        "meshes.md",
        (
            "contiga mesh part.step --tol 0.05 -o part.stl",
            "contiga mesh part.step --tol 0.001 --unit m -o part.msh",
        ),
    ),
    "report": ("report.md", ("contiga report out",)),
    "compare": (
        "report.md",
        (
            "contiga compare out_1 out_2 out_3 -o compare.html",
            "contiga compare study_out -o compare.html",
        ),
    ),
    "film": ("command-line.md", ("contiga film out -o film.mp4", "contiga film out -o film.gif")),
    "convert": ("convert.md", ("contiga convert deck.k --units mm,kg,ms -o case.toml",)),
    "export": ("command-line.md", ("contiga export out", "contiga export out -o tests --test T17")),
    "pack": ("command-line.md", ("contiga pack out -o out.zip",)),
    "plot": (
        "report.md",
        (
            "contiga plot out -x head_cg.travel -y head-pad.force -o force.svg",
            "contiga plot out_1 out_2 -y head_cg.a -o both.png",
        ),
    ),
    "route": (
        "belts.md",
        (
            "contiga route chest.step --from=-300,0,0 --to=300,0,0 --via 0,0,400 -o path.png",
            "contiga route case.toml -o belts.png",
        ),
    ),
    "study": (
        "study.md",
        (
            "contiga study study.toml -o out",
            "contiga study study.toml -o out --resume",
            "contiga study study.toml -o out --scheduler tcp://login1:8786",
        ),
    ),
    "warmup": ("command-line.md", ("contiga warmup --jobs 2", "contiga warmup --clear")),
    "reproduce": ("reproduce.md", ("contiga reproduce --only 5.1,5.4 -o reproduction",)),
    "verify": ("verify.md", ("contiga verify --only spring,mass -o verification",)),
}


def epilog(command: str) -> str:
    """Return the examples of a command ("" for the program), a line each, and its page."""
    page, examples = _TEXTS[command]
    # Blank lines keep each example in a line of its own.
    return "\n\n".join(["Examples:", *examples, f"More: {_PAGES}{page}"])


class Command(TyperCommand):
    """A command whose help shows flags without a value."""

    def get_params(self, ctx: Any) -> list[Any]:
        """Return arguments and options."""
        return _without_values(super().get_params(ctx))


class Group(TyperGroup):
    """The program, whose help shows flags without a value."""

    def get_params(self, ctx: Any) -> list[Any]:
        """Return the options of the program."""
        return _without_values(super().get_params(ctx))


def _without_values(params: list[Any]) -> list[Any]:
    """Change flags so that their help shows no value; return the list."""
    for param in params:
        if getattr(param, "is_flag", False) and param.metavar is None:
            param.metavar = ""
    return params
