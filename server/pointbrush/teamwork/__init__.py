"""Projects, tasks, reviews, copies and webhooks: what a team shares about its recordings."""
