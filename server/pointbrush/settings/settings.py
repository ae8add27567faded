"""All options of pointbrush, from which flags, variables and docs/options.md are derived."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from getpass import getuser
from pathlib import Path
from typing import Any
from urllib.parse import quote

from pointbrush.errors import BadInputError
from pointbrush.settings.command_sets import (
    ACCESS,
    ADDRESS,
    BACKUPS,
    CLIENTS,
    EVERYWHERE,
    JOBS,
    KEEPERS,
    LIMITS,
    READERS,
    RUNNERS,
    SERVERS,
    STORAGE,
    STORES,
)
from pointbrush.settings.definitions import PREFIX, Option, option, options_of

STORED: dict[str, Any] = {"where": EVERYWHERE, "shown": STORES, "group": STORAGE}
"""Definition of the options of storage."""
UNIT_SECONDS = {"m": 60.0, "h": 3_600.0, "d": 86_400.0}


@dataclass(frozen=True)
class Settings:
    """The options of one run; ``Settings.load`` reads them."""

    workspace: Path = option(
        Path("pointbrush-workspace"),
        "folder of recordings and labels; may be read-only",
        where=EVERYWHERE,
    )
    database: str = option(
        "", "URL of the database of labels; empty: SQLite in the workspace", **STORED
    )
    database_password_file: str = option(
        "", "file with the password of the database's user", **STORED
    )
    new_labels: bool = option(
        False,
        "start with empty labels if `labels.sqlite` is missing beside recordings",
        group=STORAGE,
    )
    sequences: str = option(
        "",
        "URL of the object storage of recordings (s3://bucket/folder, gs://…); empty: the folder "
        "`sequences` of the workspace",
        **STORED,
    )
    sequence_cache: str = option(
        "",
        "local folder that caches files of the object storage; empty: `pointbrush` in the user's "
        "cache folder",
        **STORED,
    )
    sequence_cache_bytes: int = option(
        20 * 2**30,
        "maximum size of the cache; files in use are kept beyond it",
        unit="bytes",
        **STORED,
    )
    max_frame_points: int = option(
        500_000_000, "maximum number of points in a frame", where=READERS, group=LIMITS
    )
    workers: int = option(2, "local processes that run jobs", where=RUNNERS, group=JOBS)
    scheduler: str = option(
        "",
        "Dask scheduler (tcp://host:port); its workers run jobs instead of local processes",
        where=RUNNERS,
        group=JOBS,
    )
    host: str = option("127.0.0.1", "address to listen on", group=ADDRESS)
    port: int = option(
        8080, "port to listen on; 0: any free port", least=0, most=65_535, group=ADDRESS
    )
    server: str = option(
        "",
        "http(s) address of a server; the command works on the server's workspace",
        where=CLIENTS,
        group=ACCESS,
    )
    token: str = option(
        "",
        "admin token; empty: a new one at each start",
        client_help="your token for the server",
        where=(*CLIENTS, *SERVERS),
        group=ACCESS,
    )
    token_file: str = option("", "file with the admin token, instead of `token`", group=ACCESS)
    oidc_issuer: str = option(
        "", "https address of an OpenID Connect provider for sign-in", group=ACCESS
    )
    oidc_client_id: str = option("", "id of this server at the provider", group=ACCESS)
    oidc_client_secret_file: str = option(
        "", "file with the client secret at the provider; empty: a public client", group=ACCESS
    )
    oidc_role: str = option("annotator", "role of an account at its first sign-in", group=ACCESS)
    oidc_roles_claim: str = option(
        "",
        "claim of the ID token that sets the role at each sign-in (realm_access.roles), instead of "
        "`oidc_role`",
        group=ACCESS,
    )
    log_format: str = option(
        "text",
        "format of the log: text, or json with one line for each request, edit and job",
        group=JOBS,
    )
    webhook_private: bool = option(
        False, "allow webhooks to addresses of this machine and of private networks", group=ACCESS
    )
    selector: str = option(
        "tree",
        "method that answers clicks of the object tool: tree (built in), the name of a plug-in, or "
        "the http(s) address of a service; RECORDING=NAME for one recording; commas separate "
        "several",
        group=JOBS,
    )
    models: str = option(
        "",
        "services that score classes for label by example: NAME=http://host:port, separated by "
        "commas; installed plug-ins need no entry",
        group=JOBS,
    )
    mask_models: str = option(
        "",
        "services that find masks in pictures: NAME=http://host:port, separated by commas; "
        "installed plug-ins need no entry",
        group=JOBS,
    )
    backup_to: str = option(
        "",
        "folder of dated backups, which share the files of recordings; servers make backups there",
        where=KEEPERS,
        group=BACKUPS,
    )
    backup_every: str = option(
        "24h", "time between two backups of a server: 90m, 24h or 7d", group=BACKUPS
    )
    backup_keep: int = option(
        7, "number of backups to keep; older ones are removed", where=KEEPERS, group=BACKUPS
    )
    tls: bool = option(
        False, "serve HTTPS with a certificate of pointbrush's own authority", group=ADDRESS
    )
    certfile: str = option("", "certificate for HTTPS, instead of pointbrush's own", group=ADDRESS)
    keyfile: str = option("", "private key of the certificate", group=ADDRESS)
    insecure: bool = option(
        False, "allow an address other than loopback without TLS", group=ADDRESS
    )
    import_roots: str = option(
        "",
        f"folders that imports by REST may read, separated by '{os.pathsep}'; empty: the current "
        "folder and the home folder, for the admin token on this machine only",
        group=ACCESS,
    )
    allowed_hosts: str = option(
        "", "additional host names of the page, separated by commas", group=ADDRESS
    )
    trusted_proxies: str = option(
        "",
        "proxies trusted to set X-Forwarded-For and X-Forwarded-Proto: addresses or networks, "
        "separated by commas",
        group=ADDRESS,
    )
    max_body: int = option(
        64 * 2**20,
        "maximum size of a request's body (uploads excepted)",
        unit="bytes",
        group=LIMITS,
    )
    max_upload: int = option(8 * 2**30, "maximum size of an upload", unit="bytes", group=LIMITS)
    max_message: int = option(
        4 * 2**20, "maximum size of a WebSocket message from a client", unit="bytes", group=LIMITS
    )
    wrong_tokens_per_minute: int = option(
        20, "wrong tokens per minute from one address before it has to wait", group=LIMITS
    )
    requests_per_second: int = option(
        200, "sustained requests per second of one client", group=LIMITS
    )
    body_seconds: int = option(
        600,
        "maximum time to receive a request's body (uploads excepted)",
        unit="seconds",
        group=LIMITS,
    )
    upload_seconds: int = option(
        14_400, "maximum time to receive an upload", unit="seconds", group=LIMITS
    )
    stall_seconds: int = option(
        60,
        "maximum time in which a client reads nothing of an answer",
        unit="seconds",
        group=LIMITS,
    )
    waiting_edits: int = option(
        6_000,
        "maximum number of queued edits of all viewers; further strokes are refused",
        group=LIMITS,
    )
    exports: int = option(4, "maximum number of concurrent exports", group=LIMITS)
    exports_per_person: int = option(
        2, "maximum number of concurrent exports of one person", group=LIMITS
    )
    statement_seconds: int = option(
        60, "maximum time of one PostgreSQL statement", unit="seconds", group=LIMITS
    )
    keepalive_seconds: int = option(
        30, "idle time after which a PostgreSQL connection is probed", unit="seconds", group=LIMITS
    )

    @classmethod
    def load(
        cls, given: Mapping[str, Any] | None = None, environment: Mapping[str, str] | None = None
    ) -> Settings:
        """Return the options: ``given`` flags, then variables of the environment, then defaults.

        ``given`` maps names to values of the command line; None: not given.

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
        """The database's URL with the default and the password filled in.

        Raises BadInputError if the file of the password cannot be read.
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
        """The folder that caches files of the object storage, absolute."""
        if self.sequence_cache:
            return Path(self.sequence_cache).expanduser().absolute()
        return Path(os.environ.get("XDG_CACHE_HOME") or "~/.cache").expanduser() / "pointbrush"

    @property
    def admin_token(self) -> str:
        """The configured admin token, or ""; raises BadInputError for a file without a token."""
        if not self.token_file:
            return self.token
        token = _secret("token_file", self.token_file)
        if not token:
            raise BadInputError(f"token_file: expected a token, {self.token_file} is empty")
        return token

    @property
    def oidc_client_secret(self) -> str:
        """The client secret at the provider, or ""; raises BadInputError for an unreadable file."""
        file = self.oidc_client_secret_file
        return _secret("oidc_client_secret_file", file) if file else ""

    @property
    def roots(self) -> list[Path]:
        """The folders of ``import_roots``, resolved."""
        return [Path(root).resolve() for root in self.import_roots.split(os.pathsep) if root]

    @property
    def own_roots(self) -> list[Path]:
        """The current folder and the home folder of the server's process, resolved."""
        return [Path.cwd().resolve(), Path.home().resolve()]


def seconds_of(name: str, text: str) -> float:
    """Return the seconds of a time such as 24h; raises BadInputError with ``name`` in it."""
    number, unit = text[:-1], text[-1:]
    if unit not in UNIT_SECONDS or not number.isdecimal() or not int(number):
        raise BadInputError(f"{name}: expected a time as 90m, 24h or 7d, got {text[:20]!r}")
    return int(number) * UNIT_SECONDS[unit]


def _secret(name: str, file: str) -> str:
    """Read the file of option ``name`` without its end of line."""
    try:
        return Path(file).read_text(encoding="utf-8").rstrip("\r\n")
    except (OSError, ValueError):
        raise BadInputError(f"{name}: expected a readable file, got {file}") from None


def options() -> tuple[Option, ...]:
    """Return all options, for the command line and the docs."""
    return options_of(Settings)


def variables(settings: Settings, command: str) -> dict[str, str]:
    """Return the environment variables that give ``command`` in another process these options.

    The command works on this machine's workspace, also where POINTBRUSH_SERVER is set.
    """
    taken = [each for each in options() if each.taken_by(command)]
    own = {each.variable: str(getattr(settings, each.name)) for each in taken}
    return {f"{PREFIX}SERVER": "", **own}
