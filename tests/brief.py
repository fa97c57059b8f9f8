"""Plans for tests of the whole graph, as short as a flight can be."""

PLAN = """
name: brief
about: a flight for a test
seed: {seed}
controller: {controller}
{more}
phases:
  - home: {{duration: 5.0}}
  - run_up: {{duration: 3.0}}
  - take_off: {{height: {height}, speed: 0.5}}
{phases}  - land: {{speed: 0.4}}
  - run_down: {{duration: 0.5}}
"""


def brief(*phases: str, height: float = 0.0, seed: int = 1, controller: str = "lq", more: str = "") -> str:
    """Text of a plan whose first phase begins about 12.6 s after the start, 11.6 s at a height of -0.3 m.

    Args:
        phases: between take-off and landing, each as it stands in a plan.
        height: of the take-off [m].
        seed: of every random number.
        controller: that flies.
        more: lines of YAML beside these: room, faults.
    """
    lines = "".join(f"  - {phase}\n" for phase in phases)
    return PLAN.format(seed=seed, controller=controller, more=more, height=height, phases=lines)
