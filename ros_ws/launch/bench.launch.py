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
from heli_flight.plan import load_plan
from heli_flight.process_table import PROCESSES

ARGUMENTS = (
    DeclareLaunchArgument(
        "plan", default_value="", description="shipped plan or plan file; empty: wait for services"
    ),
    DeclareLaunchArgument(
        "controller",
        default_value="lq",
        description="in place of the plan's first: shipped controller or file",
    ),
    DeclareLaunchArgument(
        "mode", default_value="realtime", choices=["realtime", "lockstep"], description="way of running"
    ),
    DeclareLaunchArgument("seed", default_value="1", description="seed of the bench's random numbers"),
    DeclareLaunchArgument("bag", default_value="", description="new folder for the bag; empty: none"),
)


def nodes(context: LaunchContext) -> list[Node]:
    """One action per process, with the parameters that the arguments decide."""
    given = context.launch_configurations
    own = {
        topics.BENCH_SIM: {"mode": given["mode"], "seed": int(given["seed"])},
        topics.SUPERVISOR: {"plan": given["plan"]},
        topics.ATTITUDE_CONTROLLER: {
            "controller": given["controller"],
            "plan_controllers": plan_controllers(given["plan"], given["controller"]),
        },
        topics.RECORDER: {"bag": given["bag"]},
    }
    processes = [process for process in PROCESSES if process.name != topics.RECORDER or given["bag"]]
    running = {"running": ",".join(process.name for process in processes)}
    return [
        Node(
            package=process.package,
            executable=process.executable,
            name=process.name,
            parameters=[typed(running | own.get(process.name, {}))],
            output="screen",
            # The recorder ends first, when its bag is closed; the bench waits for that.
            on_exit=[] if process.name == topics.RECORDER else [Shutdown(reason=f"{process.name} ended")],
        )
        for process in processes
    ]


def plan_controllers(plan: str, first: str) -> str:
    """All controllers of a plan, its first replaced; what is wrong with the plan the supervisor says."""
    try:
        return ",".join((first, *load_plan(plan).controllers[1:])) if plan else ""
    except InputError:
        return ""


def typed(parameters: dict[str, str | int]) -> dict[str, ParameterValue]:
    """Parameters of the type they have here: launch would read a plan named "1" as a number."""
    return {
        key: ParameterValue(value, value_type=type(value)) for key, value in parameters.items() if value != ""
    }


def generate_launch_description() -> LaunchDescription:
    """Entry point of `ros2 launch`."""
    return LaunchDescription([*ARGUMENTS, OpaqueFunction(function=nodes)])
