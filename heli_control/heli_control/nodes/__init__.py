"""ROS 2 nodes of heli_control: declare, convert, call, publish."""
