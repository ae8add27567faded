"""Resources of teams: accounts, projects, tasks, reviews, snapshots, webhooks."""
