"""The bench and everything that flies it: ros2 launch ros_ws/launch/bench.launch.py plan:=hover_steps.

Each node is a process of its own. The launch ends when the bench does, after the supervisor's last word, or
when any node fails. Without a plan the supervisor waits for its services; without a bag nothing is recorded.
"""

from __future__ import annotations

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

from heli_common import topics
from heli_common.errors import InputError
from heli_flight.node_settings import FlightSettings, Settings
from heli_flight.plan import Plan, load_plan
from heli_flight.process_table import processes

ARGUMENTS = (
    DeclareLaunchArgument(
        "plan", default_value="", description="shipped plan or plan file; empty: wait for services"
    ),
    DeclareLaunchArgument(
        "controller",
        default_value="lq",
        description="in place of the plan's first: shipped controller or file",
    ),
    DeclareLaunchArgument("motor", default_value="motor", description="shipped motor controller or file"),
    DeclareLaunchArgument(
        "mode", default_value="realtime", choices=["realtime", "lockstep"], description="way of running"
    ),
    DeclareLaunchArgument("seed", default_value="1", description="seed of the bench's random numbers"),
    DeclareLaunchArgument(
        "identification",
        default_value="false",
        choices=["true", "false"],
        description="whether the identification runs though the plan does not excite",
    ),
    DeclareLaunchArgument("namespace", default_value="", description="of every node and topic"),
    DeclareLaunchArgument("bag", default_value="", description="new folder for the bag; empty: none"),
)


def nodes(context: LaunchContext) -> list[Node]:
    """One action per process, with the parameters that the arguments decide."""
    given = context.launch_configurations
    plan = readable(given["plan"])
    identified = given["identification"] == "true" or bool(plan and plan.excitations)
    settings = FlightSettings(
        plan=plan,
        plan_name=given["plan"],
        mode=given["mode"],
        seed=int(given["seed"]),
        controllers=(given["controller"], *(plan.controllers[1:] if plan else ())),
        motor=given["motor"],
        bag=given["bag"],
    )
    table = [each for each in processes(identified) if each.name != topics.RECORDER or given["bag"]]
    running = [process.name for process in table]
    # A flight in real time goes on without its optional nodes.
    spared = (topics.RECORDER, *(topics.OPTIONAL_NODES if given["mode"] == "realtime" else ()))
    return [
        Node(
            package=process.package,
            executable=process.executable,
            name=process.name,
            namespace=given["namespace"] or None,
            parameters=[typed(settings.of(process, running))],
            output="screen",
            # The recorder ends first, when its bag is closed; the bench waits for that.
            on_exit=[] if process.name in spared else [Shutdown(reason=f"{process.name} ended")],
        )
        for process in table
    ]


def readable(name: str) -> Plan | None:
    """A plan, or None without one; what is wrong with it the supervisor says."""
    try:
        return load_plan(name) if name else None
    except InputError:
        return None


def typed(parameters: Settings) -> dict[str, ParameterValue]:
    """Parameters of the type they have here: launch would read a plan named "1" as a number."""
    return {
        key: ParameterValue(value, value_type=type(value)) for key, value in parameters.items() if value != ""
    }


def generate_launch_description() -> LaunchDescription:
    """Entry point of `ros2 launch`."""
    return LaunchDescription([*ARGUMENTS, OpaqueFunction(function=nodes)])
