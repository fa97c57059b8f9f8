"""Parameters of a room with half of the gusts that are calibrated on Table 5.2."""

CALM = """
/**/bench_sim:
  ros__parameters:
    room.strength_x: 1.0
    room.strength_y: 1.0
    room.strength_z: 0.3
    room.strength_yaw: 0.3
"""
"""In it a step of 0.20 m still shows, and LQ keeps its tilt below 20 deg without the IMU, too."""
