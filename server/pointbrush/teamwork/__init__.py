"""Projects, tasks, reviews, copies and webhooks of teams."""
