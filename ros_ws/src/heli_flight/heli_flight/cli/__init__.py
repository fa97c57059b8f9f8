"""One module per sub-command of the `heli` command."""
