"""Sets of commands, to which options belong, and the headings of options."""

from __future__ import annotations

SERVERS = ("demo", "serve")
REMOTE = (
    "import", "import-labels", "track", "fit-boxes", "find-people", "align-sensors", "example",
    "export", "info", "labels", "delete", "undelete", "rename", "check-labels", "compare", "report",
    "token",
)  # fmt: skip
"""Commands that work on the workspace of this machine, or on that of a server."""
LOCAL = ("check", "backup", "restore", "review", "move")
"""Commands that need the folder of the workspace."""
CLIENTS = (*REMOTE, "project", "task", "webhook", "undo")
"""Commands that work on a server; the commands that are not in ``REMOTE`` need one."""
EVERYWHERE = (*REMOTE, *LOCAL, *SERVERS)
"""Commands that open a workspace."""
KEEPERS = ("backup", *SERVERS)
"""Commands that make backups."""
READERS = ("import", "import-labels", *SERVERS)
"""Commands that read points of files."""
RUNNERS = ("track", "example", *SERVERS)
"""Commands that run jobs."""
STORES = ("check", "backup", "restore", "move", *SERVERS)
"""Commands with the storage options in their help; the other commands take them as well."""
COMMAND_SETS = {
    EVERYWHERE: "workspace",
    CLIENTS: "clients",
    (*CLIENTS, *SERVERS): "clients, servers",
    SERVERS: "servers",
    KEEPERS: "`backup`, servers",
    READERS: "`import`, `import-labels`, servers",
    RUNNERS: "`track`, `example`, servers",
}
"""Names of sets of commands in docs/options.md."""
WORKSPACE, STORAGE, ADDRESS, ACCESS = "workspace", "storage", "address and TLS", "access"
JOBS, BACKUPS, LIMITS = "work", "backups", "limits"
GROUPS = (WORKSPACE, STORAGE, ADDRESS, ACCESS, JOBS, BACKUPS, LIMITS)
"""Headings of options, in their order."""
