"""What a farm is given: commands that compute a shot in parts, as text or as a job of Open Job Description."""
