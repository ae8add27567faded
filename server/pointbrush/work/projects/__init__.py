"""Projects: many recordings, several people, tasks, versions, events."""
