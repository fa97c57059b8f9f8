"""Motor, position and attitude control: designs, controller files, nodes."""
