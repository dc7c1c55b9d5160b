"""Runs on several machines, as processes of this one: with homes of their own, by every engine, and disturbed."""
