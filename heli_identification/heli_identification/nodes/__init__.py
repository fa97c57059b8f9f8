"""ROS 2 nodes of heli_identification: declare, convert, call, publish."""
