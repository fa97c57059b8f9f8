"""Plans, supervisor, recorder, in-process flight, report and the heli command."""
