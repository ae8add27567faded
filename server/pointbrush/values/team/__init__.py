"""Values of teams: accounts, projects, tasks, reviews, snapshots, webhooks."""
