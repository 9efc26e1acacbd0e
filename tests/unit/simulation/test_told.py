"""What a run says of its own results: forces that jump, and single nodes that are not followed."""

import pytest
from tests.scenes import box

import contiga as cg


def jumps(x, *, foot="nearest", step="auto"):
    """Of a point that falls into a block, 1 − x from the edge of its top."""
    block = box((-1, -1, -2), (1, 1, 0))
    slave = cg.Slave([[x, 0, 0.05]], area=[1.0], mass=[1.0])
    contact = cg.Contact(block, slave, law=cg.PenaltyLaw(10.0), foot=foot)
    simulation = cg.Simulation(
        bodies={"block": block},
        slaves={"dust": (slave, cg.motion.Free(velocity=[0, 0, -1.0]))},
        contacts=[contact],
        end=0.5,
        step=step,
    )
    return [text for text in simulation.run().summary["warnings"] if "forces jump" in text]


def test_forces_that_jump_from_wall_to_wall_are_told():
    (text,) = jumps(0.9)
    assert text.startswith(
        "contact block-dust: forces jump by 141 % of the largest in the one step"
    )
    assert "t = 0.1517" in text  # 0.05 in the air, then asin(0.1 √10)/√10


@pytest.mark.parametrize("other", [{"x": 0.3}, {"x": 0.9, "foot": "tracked"}])
def test_what_stays_at_one_wall_is_not(other):
    assert jumps(**other) == []


@pytest.mark.parametrize(("other", "followed"), [(100.0, True), (1000.0, False)])
def test_a_node_with_little_of_the_energy_is_told_where_it_is_not_followed(other, followed) -> None:
    """Beside one that flies by: from ω h = 0.3 on a rebound is off by more than a hundredth."""
    block = box((-1, -1, -2), (1, 1, 0))
    dust = cg.Slave([[0.3, 0, 0.05], [5, 0, 0.05]], area=[1.0, 1.0], mass=[1.0, other])
    result = cg.Simulation(
        bodies={"block": block},
        slaves={"dust": (dust, cg.motion.Free(velocity=[0, 0, -1.0]))},
        contacts=[cg.Contact(block, dust, law=cg.PenaltyLaw(1e3))],
        end=2.0,
        step="auto",
    ).run()
    texts = [text for text in result.summary["warnings"] if text.startswith("step: single nodes")]
    assert len(texts) == (0 if followed else 1)
    assert abs(result.state.slaves["dust"].velocities[0, 2] - 1.0) < (1e-3 if followed else 1e-2)
