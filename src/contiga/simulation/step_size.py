"""How long the next step is: as given, or as long as named reasons let it be.

A step that chooses itself is proposed by what is known before it: the critical step, how fast
forces change, turns, rows of tables, the step before. Then it is worked out and judged by what
happened in it: how far points went, whether one went in and out, what is stiffer than foreseen, its
energy balance error. What objects has it taken again, shorter; for energy only where that helps,
and never below the shortest step. Every choice follows from the states alone.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import replace
from itertools import count

from contiga.dynamics.stepping import AutoSteps
from contiga.errors import RunError
from contiga.simulation.clock import Clock
from contiga.simulation.critical import Limit, find_limit, limit_of
from contiga.simulation.model import Model
from contiga.simulation.reasons import Choice, Cut, Reason
from contiga.simulation.stability import check_stable
from contiga.simulation.step import Stepped, advance
from contiga.simulation.step_judge import Try, leak_of, let_pass, loses, objection, tried
from contiga.simulation.step_proposals import proposals
from contiga.simulation.system_state import SystemState


def following(model: Model, last: SystemState, clock: Clock) -> Stepped:
    """The step after `last`.

    Raises
    ------
    RunError
        A given step is longer than the critical one, or every step is; elements are unstable or
        inside out.
    """
    stepped = _after(model, last, clock)
    if model.mechanism.deforms:
        check_stable(model, stepped.state)
    return stepped


def _after(model: Model, last: SystemState, clock: Clock) -> Stepped:
    """As long as it is given, or chosen."""
    stepping = model.stepping
    if isinstance(stepping, AutoSteps):
        return _chosen(model, stepping, last, clock)
    time = stepping.after(last.time)
    if model.mechanism.moved and not model.allow_unstable:
        with clock("motion"):
            _check(find_limit(model, last), time - last.time, last.time)
    return advance(model, last, time, clock)


def _check(limit: Limit, step: float, time: float) -> None:
    if step > limit.critical:
        raise RunError(
            f"t = {time:g}: the step of {step:.4g} is longer than the critical one of "
            f"{limit.critical:.4g}, that of {limit.of}: its vibrations would grow without bound. "
            f'Take a step below {0.9 * limit.critical:.3g}, or step = "auto"; '
            "allow_unstable lets it pass"
        )


def _check_following(limit: Limit, last: SystemState) -> None:
    if last.step > limit.critical:
        raise RunError(
            f"t = {last.time:g}: no step is stable for {limit.of}, whose stiffness follows the "
            f"step: the critical one is {limit.critical / last.step:.3g} of any. Take a smaller "
            "scale of its law; allow_unstable lets it pass"
        )


def _chosen(model: Model, stepping: AutoSteps, last: SystemState, clock: Clock) -> Stepped:
    """A step as long as it may be."""
    with clock("motion"):
        if model.mechanism.moved and not model.allow_unstable:
            _check_following(limit_of(model, last, "following"), last)
        cut = min(proposals(model, stepping, last))
    longer: Try | None = None
    for tries in count(1):
        time, cut = _until(model, last.time, cut)
        stepped = advance(model, last, time, clock)
        with clock("motion"):
            now = tried(model, stepping, last, stepped, cut)
            shorter = objection(model, stepping, last, now)
        if shorter is None:
            leak, handed = leak_of(last, now, longer), now.handed
            state = replace(
                stepped.state, shaking=now.shaking, leak=leak,
                place_error=handed.place, speed_error=handed.speed,
            )  # fmt: skip
            missed = let_pass(model, last, now)
            choice = Choice(cut, tries, missed, now.single, now.lag, now.late)
            return stepped._replace(state=state, choice=choice)
        if shorter.reason in (Reason.ENERGY, Reason.SHORTEST) and loses(model, last, now):
            longer = now
        cut = shorter
    raise AssertionError("there is always another step")


def _until(model: Model, time: float, cut: Cut) -> tuple[float, Cut]:
    """When a step ends: the last two before a kink share what is left, so that none is tiny."""
    k = bisect_right(model.kinks, time)
    kink = k < len(model.kinks)
    until = model.kinks[k] if kink else model.stepping.end
    left, reason = until - time, Reason.KINK if kink else Reason.END
    if cut.step >= left:
        return until, Cut(left, reason) if cut.step > left else cut
    if 2.0 * cut.step > left:
        return time + 0.5 * left, Cut(0.5 * left, reason)
    return time + cut.step, cut
