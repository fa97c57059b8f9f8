"""The helicopter test bench as it is: helicopter, rig, sensors, actuators."""
