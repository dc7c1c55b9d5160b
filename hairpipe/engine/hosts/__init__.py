"""Who evaluates what a run has decided on: child processes of this machine, or of others."""
