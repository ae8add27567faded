"""Permissions of files, and the resources that the system gives to this process."""
