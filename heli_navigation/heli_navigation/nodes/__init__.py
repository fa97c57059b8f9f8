"""ROS 2 nodes of heli_navigation: declare, convert, call, publish."""
