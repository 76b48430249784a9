"""Starts a chain and its node: `ros2 launch lariat_bringup lariat.launch.py`, or by this file's path without building anything.

    ros2 launch lariat_bringup lariat.launch.py source:=/dev/video0 rviz:=true
    ros2 launch lariat_bringup lariat.launch.py image:=/camera/image_raw camera_info:=/camera/camera_info

`lariat` and `lariat-ros2` must be on the path.
"""

import shlex
from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, OpaqueFunction
from launch.substitutions import LaunchConfiguration

ARGUMENTS = {
    "rig": ("default", "the rig's name"),
    "namespace": ("", "the node's namespace, such as /cell"),
    "frame_id": ("", "the frame of reference of ropes; the rig's name or the pictures' frame if not given"),
    "camera_frame_id": ("", "the frame of reference of pictures; the rig's name with _camera if not given"),
    "best_effort": ("false", "whether messages are sent once, as sensor data: true or false"),
    "settings": ("", "a settings file (lariat.toml) of the chain"),
    "source": ("", "what the chain reads: a camera, pictures, a recording; images of ROS if image is given"),
    "image": ("", "a topic of images that become the chain's frames"),
    "mask": ("", "a topic of masks of these images"),
    "camera_info": ("", "a topic of the camera's calibration"),
    "chain": ("", "more words for `lariat run`, such as --plane plane.toml"),
    "node": ("", "more words for `lariat ros2`, such as --jpeg-quality 90"),
    "rviz": ("false", "whether RViz is started: true or false"),
}


def processes(context):
    said = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    rig = ["--rig", said["rig"]]
    source = "external" if said["image"] else said["source"]
    chain = ["lariat", "run", *rig, *(["--source", source] if source else [])]
    chain += ["--mask", "external"] if said["mask"] else []
    chain += ["--config", said["settings"]] if said["settings"] else []
    node = ["lariat", "ros2", *rig]
    for name in ("frame_id", "camera_frame_id", "image", "mask", "camera_info"):
        node += [f"--{name.replace('_', '-')}", said[name]] if said[name] else []
    node += ["--best-effort"] if said["best_effort"] == "true" else []
    node += shlex.split(said["node"])
    # Words of ROS come last.
    node += ["--ros-args", "-r", f"__ns:={said['namespace']}"] if said["namespace"] else []
    commands = [chain + shlex.split(said["chain"]), node]
    if said["rviz"] == "true":
        view = Path(__file__).resolve().parents[1] / "rviz" / "lariat.rviz"
        # The view is of the rig default; its topics and its frame take another rig's name in RViz.
        commands.append(["rviz2", "-d", str(view)])
    return [ExecuteProcess(cmd=command, output="screen") for command in commands]


def generate_launch_description():
    declared = [DeclareLaunchArgument(name, default_value=value, description=about) for name, (value, about) in ARGUMENTS.items()]
    return LaunchDescription([*declared, OpaqueFunction(function=processes)])
