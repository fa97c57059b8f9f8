"""ROS 2 nodes of heli_bench_sim: declare, convert, call, publish."""
