"""What is known of the bench: position, velocity and attitude from the encoders."""
