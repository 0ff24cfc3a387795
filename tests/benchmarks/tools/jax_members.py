"""Many members of the drive by JAX: ``vmap`` over members, ``scan`` over instants.

The job on stdin: the source of one instant, values of the members, the steps.
"""

import json
import os
import sys
from functools import partial
from time import process_time

os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})  # before it makes threads

import jax  # noqa: E402
import jax.numpy as jnp  # noqa: E402

jax.config.update("jax_enable_x64", True)


def main() -> None:
    """Print the seconds of a compiled run on one core and the last row's signal."""
    job = json.load(sys.stdin)
    room = {"jnp": jnp, "f": partial(jnp.asarray, dtype=jnp.float64)}
    exec(job["source"], room)
    x, p, d = (jnp.asarray(job[n], jnp.float64) for n in ("x", "p", "d"))

    def member(p: jax.Array, d: jax.Array) -> jax.Array:
        def once(state: jax.Array, _: None) -> tuple[jax.Array, jax.Array]:
            return tuple(room["instant"](state, p, d))

        return jax.lax.scan(once, x, None, length=job["steps"])[1]

    run = jax.jit(jax.vmap(member))
    run(p, d).block_until_ready()
    begun = process_time()
    rows = run(p, d).block_until_ready()
    took = process_time() - begun
    last = rows[:, -1, job["row"]].tolist()
    print(json.dumps({"seconds": took, "last": last}))


if __name__ == "__main__":
    main()
