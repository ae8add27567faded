"""The options of pointbrush, each once; ``options.py`` says what an option is.

``python -m pointbrush.settings`` writes the tables of docs/options.md; a test fails when they are
stale.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from getpass import getuser
from pathlib import Path
from typing import Any
from urllib.parse import quote

from pointbrush.errors import BadInputError
from pointbrush.options import WORKSPACE, Option, markdown, option, options_of

EVERYWHERE: tuple[str, ...] = ()
SERVERS = ("demo", "serve")
KEEPERS = ("backup", *SERVERS)
"""Commands that make backups."""
READERS = ("import", "import-labels", *SERVERS)
"""Commands that read points of files."""
RUNNERS = ("track", "example", *SERVERS)
"""Commands that run jobs."""
REMOTE = (
    "import", "import-labels", "track", "fit-boxes", "example", "export", "info", "labels",
    "delete", "undelete", "rename", "check-labels", "compare", "report",
)  # fmt: skip
"""Commands that work on the workspace of a server as well."""
ADDRESS, ACCESS, JOBS, LIMITS = "address and TLS", "access", "work", "limits"
BACKUPS = "backups"
GROUPS = (WORKSPACE, ADDRESS, ACCESS, JOBS, BACKUPS, LIMITS)
"""Headings in the help of commands, in their order."""

UNIT_SECONDS = {"m": 60.0, "h": 3_600.0, "d": 86_400.0}

DOCS = Path(__file__).parents[2] / "docs" / "options.md"
BEGIN, END = "<!-- Written by `python -m pointbrush.settings`. -->\n", "<!-- End. -->\n"


@dataclass(frozen=True)
class Settings:
    """The options of one run; ``Settings.load`` reads them."""

    workspace: Path = option(
        Path("pointbrush-workspace"),
        "folder of recordings and labels; may be read-only",
        where=EVERYWHERE,
    )
    database: str = option(
        "", "database URL; empty is SQLite inside the workspace", where=EVERYWHERE
    )
    database_password_file: str = option(
        "", "file that holds the password of the database's user", where=EVERYWHERE
    )
    new_labels: bool = option(
        False,
        "begin with empty labels where `labels.sqlite` is missing beside recordings",
        where=SERVERS,
    )
    sequences: str = option(
        "",
        "URL of object storage (s3://bucket/folder, gs://…) that holds the recordings; empty is "
        "the folder `sequences` of the workspace",
        where=EVERYWHERE,
    )
    sequence_cache: str = option(
        "",
        "folder of this machine for files from there; empty is `pointbrush` in the user's cache",
        where=EVERYWHERE,
    )
    sequence_cache_bytes: int = option(
        20 * 2**30,
        "room for them; what is in use stays, even beyond that",
        where=EVERYWHERE,
        unit="bytes",
    )
    max_frame_points: int = option(
        500_000_000, "greatest number of points in a frame", where=READERS, group=LIMITS
    )
    workers: int = option(2, "local processes for jobs", where=RUNNERS, group=JOBS)
    scheduler: str = option(
        "",
        "Dask scheduler (tcp://host:port) whose workers run jobs instead",
        where=RUNNERS,
        group=JOBS,
    )
    host: str = option("127.0.0.1", "address to listen on", where=SERVERS, group=ADDRESS)
    port: int = option(
        8080,
        "port to listen on; 0 takes a free one",
        where=SERVERS,
        least=0,
        most=65_535,
        group=ADDRESS,
    )
    server: str = option(
        "", "http(s) address of a server, whose workspace is meant", where=REMOTE, group=ACCESS
    )
    token: str = option(
        "",
        "admin token, empty makes a new one at each start; for a server elsewhere your own",
        where=(*REMOTE, *SERVERS),
        group=ACCESS,
    )
    token_file: str = option(
        "", "file that holds the admin token, in place of `token`", where=SERVERS, group=ACCESS
    )
    oidc_issuer: str = option(
        "",
        "https address of an OpenID Connect provider that people may sign in with",
        where=SERVERS,
        group=ACCESS,
    )
    oidc_client_id: str = option("", "this server's id there", where=SERVERS, group=ACCESS)
    oidc_client_secret_file: str = option(
        "",
        "file that holds its secret; empty for a client without one",
        where=SERVERS,
        group=ACCESS,
    )
    oidc_role: str = option(
        "annotator", "role of who signs in for the first time", where=SERVERS, group=ACCESS
    )
    oidc_roles_claim: str = option(
        "",
        "claim of the ID token with the role at each sign-in (realm_access.roles), in place of "
        "`oidc_role`",
        where=SERVERS,
        group=ACCESS,
    )
    log_format: str = option(
        "text",
        "what the log is: text, or json, a line for each request, edit and job",
        where=SERVERS,
        group=JOBS,
    )
    webhook_private: bool = option(
        False,
        "let webhooks tell addresses of this machine and of private networks too",
        where=SERVERS,
        group=ACCESS,
    )
    selector: str = option(
        "tree",
        "what answers clicks of the object tool: tree (built in), a plug-in's name, or the "
        "http(s) address of a service; RECORDING=NAME for one recording, several with commas",
        where=SERVERS,
        group=JOBS,
    )
    models: str = option(
        "",
        "services that score classes for label by example: NAME=http://host:port, several with "
        "commas; plug-ins are there by their names",
        where=SERVERS,
    )
    backup_to: str = option(
        "",
        "folder of dated backups, which share the files of recordings; a server makes them",
        where=KEEPERS,
        group=BACKUPS,
    )
    backup_every: str = option(
        "24h",
        "time between them, as 90m, 24h or 7d",
        where=SERVERS,
        group=BACKUPS,
    )
    backup_keep: int = option(
        7, "newest of them that are kept; older ones are removed", where=KEEPERS, group=BACKUPS
    )
    tls: bool = option(
        False,
        "serve HTTPS with a certificate of pointbrush's own authority",
        where=SERVERS,
        group=ADDRESS,
    )
    certfile: str = option(
        "", "certificate to serve HTTPS with, in place of our own", where=SERVERS, group=ADDRESS
    )
    keyfile: str = option("", "private key of the certificate", where=SERVERS, group=ADDRESS)
    insecure: bool = option(
        False, "listen off loopback without TLS all the same", where=SERVERS, group=ADDRESS
    )
    import_roots: str = option(
        "",
        f"folders REST may import from, separated by '{os.pathsep}'; empty is the current "
        "folder and the home folder, for the admin token on this machine only",
        where=SERVERS,
        group=ACCESS,
    )
    allowed_hosts: str = option(
        "",
        "further host names the page may be reached by, with commas",
        where=SERVERS,
        group=ADDRESS,
    )
    trusted_proxies: str = option(
        "",
        "addresses or networks of proxies whose X-Forwarded-For and X-Forwarded-Proto are "
        "believed, with commas",
        where=SERVERS,
        group=ADDRESS,
    )
    max_body: int = option(
        64 * 2**20,
        "greatest body of a request (uploads apart)",
        where=SERVERS,
        unit="bytes",
        group=LIMITS,
    )
    max_upload: int = option(
        8 * 2**30, "greatest upload", where=SERVERS, unit="bytes", group=LIMITS
    )
    max_message: int = option(
        4 * 2**20,
        "greatest WebSocket message from a client",
        where=SERVERS,
        unit="bytes",
        group=LIMITS,
    )
    wrong_tokens_per_minute: int = option(
        20,
        "wrong tokens that one address may try in a minute until it has to wait",
        where=SERVERS,
        group=LIMITS,
    )
    requests_per_second: int = option(
        200, "requests a second that one client may sustain", where=SERVERS, group=LIMITS
    )
    body_seconds: int = option(
        600,
        "time in which a body must have come whole (uploads apart)",
        where=SERVERS,
        unit="seconds",
        group=LIMITS,
    )
    upload_seconds: int = option(
        14_400,
        "time in which an upload must have come whole",
        where=SERVERS,
        unit="seconds",
        group=LIMITS,
    )
    stall_seconds: int = option(
        60,
        "time for which a client may read nothing of an answer until it is given up",
        where=SERVERS,
        unit="seconds",
        group=LIMITS,
    )
    waiting_edits: int = option(
        6_000,
        "edits of all viewers that may wait; new strokes are refused then",
        where=SERVERS,
        group=LIMITS,
    )
    exports: int = option(4, "exports under way at once, in all", where=SERVERS, group=LIMITS)
    exports_per_person: int = option(
        2, "exports under way at once, of one person", where=SERVERS, group=LIMITS
    )
    statement_seconds: int = option(
        60,
        "time that one statement of PostgreSQL may take",
        where=SERVERS,
        unit="seconds",
        group=LIMITS,
    )
    keepalive_seconds: int = option(
        30,
        "silence after which a connection to PostgreSQL is probed",
        where=SERVERS,
        unit="seconds",
        group=LIMITS,
    )

    @classmethod
    def load(
        cls, given: Mapping[str, Any] | None = None, environment: Mapping[str, str] | None = None
    ) -> Settings:
        """Return ``given`` (the command line; None = not given) over the environment over defaults.

        Raises BadInputError for a value of the wrong form.
        """
        environment = os.environ if environment is None else environment
        values: dict[str, Any] = {}
        for each in options():
            if each.variable in environment:
                try:
                    values[each.name] = each.parse(environment[each.variable])
                except BadInputError as error:
                    raise BadInputError(f"{each.variable}: {error}") from None
        values |= {name: value for name, value in (given or {}).items() if value is not None}
        return cls(**values)

    @property
    def database_url(self) -> str:
        """The database's URL, with the default and the password filled in.

        Raises BadInputError when the file of the password cannot be read.
        """
        if not self.database:
            return f"sqlite:///{(self.workspace / 'labels.sqlite').absolute()}"
        if not self.database_password_file:
            return self.database
        password = _secret("database_password_file", self.database_password_file)
        scheme, _, place = self.database.partition("://")
        user, at, server = place.rpartition("@")
        name = user.partition(":")[0] or quote(getuser(), safe="")
        return f"{scheme}://{name}:{quote(password, safe='')}@{server if at else place}"

    @property
    def cache_folder(self) -> Path:
        """The folder of files from object storage, absolute."""
        if self.sequence_cache:
            return Path(self.sequence_cache).expanduser().absolute()
        return Path(os.environ.get("XDG_CACHE_HOME") or "~/.cache").expanduser() / "pointbrush"

    @property
    def admin_token(self) -> str:
        """The admin token that was set, or ""; raises BadInputError for a file without one."""
        if not self.token_file:
            return self.token
        token = _secret("token_file", self.token_file)
        if not token:
            raise BadInputError(f"token_file: expected a token, {self.token_file} is empty")
        return token

    @property
    def oidc_client_secret(self) -> str:
        """The secret at the provider, or ""; raises BadInputError for a file that is not there."""
        file = self.oidc_client_secret_file
        return _secret("oidc_client_secret_file", file) if file else ""

    @property
    def roots(self) -> list[Path]:
        """Folders that REST may import from, as named, resolved."""
        return [Path(root).resolve() for root in self.import_roots.split(os.pathsep) if root]

    @property
    def own_roots(self) -> list[Path]:
        """The folders of who started the server: the current one and the home folder, resolved."""
        return [Path.cwd().resolve(), Path.home().resolve()]


def seconds_of(name: str, text: str) -> float:
    """Return the seconds of a time such as 24h; raises BadInputError, which names ``name``."""
    number, unit = text[:-1], text[-1:]
    if unit not in UNIT_SECONDS or not number.isdecimal() or not int(number):
        raise BadInputError(f"{name}: expected a time as 90m, 24h or 7d, got {text[:20]!r}")
    return int(number) * UNIT_SECONDS[unit]


def _secret(name: str, file: str) -> str:
    """Read the file of option ``name``, without its end of line."""
    try:
        return Path(file).read_text(encoding="utf-8").rstrip("\r\n")
    except (OSError, ValueError):
        raise BadInputError(f"{name}: expected a readable file, got {file}") from None


def options() -> tuple[Option, ...]:
    """Return all options, for the command line and the docs."""
    return options_of(Settings)


def variables(settings: Settings, command: str) -> dict[str, str]:
    """Return the environment that gives ``command``, in another process, the same options."""
    taken = [each for each in options() if each.taken_by(command)]
    return {each.variable: str(getattr(settings, each.name)) for each in taken}


def documented(text: str) -> str:
    """Return docs/options.md, now ``text``, with fresh tables between its two marks."""
    before, begin, rest = text.partition(BEGIN)
    _, end, after = rest.partition(END)
    return before + begin + markdown(options()) + end + after


if __name__ == "__main__":
    DOCS.write_text(documented(DOCS.read_text(encoding="utf-8")), encoding="utf-8")
