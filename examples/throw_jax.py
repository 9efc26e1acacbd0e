"""The gradient of a throw through its bounce: contact forces of contiga in a program of JAX.

A chain of beads bounces off an exact torus, and Newton's method finds the velocity that takes its
middle to a target: `jax.pure_callback` asks contiga for forces and their derivative. m, kg, s.
"""

import jax
import jax.numpy as jnp
import numpy as np

import contiga as cg

jax.config.update("jax_enable_x64", True)
MASS, GRAVITY, SPRING, SIDE = 0.01, 9.81, 50.0, 0.1
STEP, STEPS, BEADS, MIDDLE = 2e-3, 300, 5, 2
START = np.array([[SIDE * k - 0.9, 0.1, 0.6] for k in range(BEADS)])
VELOCITY, TARGET = np.array([2.1, -1.7, -0.5]), np.array([0.7, -0.1, 0.4])
RING, CHAIN = cg.Body([cg.shapes.torus(major=0.5, minor=0.25)]), cg.Slave(START, area=1.0)
CONTACT = cg.Contact(RING, CHAIN, law=cg.PenaltyLaw(200.0), search="penetration")


def respond(x: jax.Array) -> tuple[np.ndarray, np.ndarray]:
    """Forces (n, 3) on beads at `x` (n, 3), and their derivative (3 n, 3 n), by contiga."""
    state = CONTACT.start(np.asarray(x))  # without memory: forces depend on the place alone
    return state.force, CONTACT.tangent(state).toarray()


def ask(x: jax.Array) -> tuple[jax.Array, jax.Array]:
    shapes = tuple(jax.ShapeDtypeStruct(s, x.dtype) for s in (x.shape, (x.size, x.size)))
    return jax.pure_callback(respond, shapes, x)


@jax.custom_jvp
def contact_force(x: jax.Array) -> jax.Array:
    """Forces (n, 3), which JAX differentiates forward and backward."""
    return ask(x)[0]


@contact_force.defjvp
def _(x: tuple[jax.Array], dx: tuple[jax.Array]) -> tuple[jax.Array, jax.Array]:
    force, tangent = ask(*x)
    return force, (tangent @ dx[0].ravel()).reshape(force.shape)


def forces(x: jax.Array) -> jax.Array:
    """Contact, gravity, and springs from bead to bead."""
    side = jnp.diff(x, axis=0)
    pull = SPRING * (1.0 - SIDE / jnp.linalg.norm(side, axis=1, keepdims=True)) * side
    springs = jnp.pad(pull, ((0, 1), (0, 0))) - jnp.pad(pull, ((1, 0), (0, 0)))
    return contact_force(x) + springs - jnp.array([0.0, 0.0, MASS * GRAVITY])


@jax.jit
def path(velocity: jax.Array) -> jax.Array:
    """(steps, n, 3) places of the beads, by the symplectic Euler method."""

    def advance(now: tuple[jax.Array, jax.Array], _: None) -> tuple[tuple, jax.Array]:
        x, v = now[0], now[1] + STEP / MASS * forces(now[0])
        return (x + STEP * v, v), x + STEP * v

    return jax.lax.scan(advance, (START, jnp.tile(velocity, (BEADS, 1))), length=STEPS)[1]


@jax.jit
def miss(velocity: jax.Array) -> jax.Array:
    """(3,) from the target to the middle bead at the end."""
    return path(velocity)[-1, MIDDLE] - TARGET


def aim(velocity: jax.Array, rounds: int = 7) -> list[jax.Array]:
    """Velocities by Newton's method, each closer to one that hits the target."""
    tried, derivative = [jnp.asarray(velocity)], jax.jit(jax.jacrev(miss))
    for _ in range(rounds):
        tried.append(tried[-1] - jnp.linalg.solve(derivative(tried[-1]), miss(tried[-1])))
    return tried


if __name__ == "__main__":
    for velocity in aim(VELOCITY):
        print(velocity.round(4), f"{jnp.linalg.norm(miss(velocity)):.1e}")
