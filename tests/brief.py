"""Plans for tests of the whole graph, as short as a flight can be."""

PLAN = """
name: brief
about: a flight for a test
seed: {seed}
controller: {controller}
{more}
phases:
  - home: {{duration: {home}}}
  - run_up: {{duration: 1.0}}
  - take_off: {{height: -0.15, speed: 0.5}}
{phases}  - land: {{speed: 0.5}}
  - run_down: {{duration: 0.5}}
"""


def brief(
    *phases: str,
    home: float = 5.0,
    seed: int = 1,
    controller: str = "lq",
    more: str = "",
) -> str:
    """Text of a plan whose first phase begins about 13.7 s after the start and whose landing takes 3 s.

    Args:
        phases: between take-off and landing, each as it stands in a plan.
        home: duration of homing [s]; after 5 s the encoders are indexed, after 7.1 s the hand has let go.
        seed: of every random number.
        controller: that flies.
        more: lines of YAML beside these: room, faults.
    """
    lines = "".join(f"  - {phase}\n" for phase in phases)
    return PLAN.format(home=home, seed=seed, controller=controller, more=more, phases=lines)
