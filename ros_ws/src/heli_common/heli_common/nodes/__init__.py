"""ROS 2 nodes of heli_common: declare, convert, call, publish."""
