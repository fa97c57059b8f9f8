"""ROS 2 nodes of heli_flight: declare, convert, call, publish."""
