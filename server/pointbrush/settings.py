"""Every option, once: its name, default and help; the environment and the command line read it."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from dataclasses import MISSING, Field, dataclass, field, fields
from getpass import getuser
from pathlib import Path
from typing import Any, get_type_hints
from urllib.parse import quote

from pointbrush.errors import BadInputError

PREFIX = "POINTBRUSH_"


UNBOUNDED = sys.maxsize


def _help(text: str, least: int = 1, most: int = UNBOUNDED) -> dict[str, Any]:
    """What an option is for; an integer is from ``least`` to ``most``."""
    return {"help": text, "least": least, "most": most}


@dataclass(frozen=True)
class Settings:
    """The options of one run; ``Settings.load`` reads them."""

    workspace: Path = field(
        default=Path("pointbrush-workspace"),
        metadata=_help("folder of recordings and labels; may be read-only"),
    )
    host: str = field(default="127.0.0.1", metadata=_help("address to listen on"))
    port: int = field(
        default=8080, metadata=_help("port to listen on; 0 takes a free one", 0, 65_535)
    )
    token: str = field(
        default="", metadata=_help("admin token; empty makes a new one at each start")
    )
    database: str = field(
        default="", metadata=_help("database URL; empty is SQLite inside the workspace")
    )
    database_password_file: str = field(
        default="", metadata=_help("file that holds the password of the database's user")
    )
    workers: int = field(default=2, metadata=_help("local processes for jobs"))
    selector: str = field(
        default="tree",
        metadata=_help(
            "what answers clicks of the object tool: tree (built in), a plug-in's name, or the "
            "http(s) address of a service; RECORDING=NAME for one recording, several with commas"
        ),
    )
    scheduler: str = field(
        default="",
        metadata=_help("Dask scheduler (tcp://host:port) whose workers run jobs instead"),
    )
    tls: bool = field(
        default=False,
        metadata=_help("serve HTTPS with a certificate of pointbrush's own authority"),
    )
    certfile: str = field(
        default="", metadata=_help("certificate to serve HTTPS with, in place of our own")
    )
    keyfile: str = field(default="", metadata=_help("private key of the certificate"))
    insecure: bool = field(
        default=False, metadata=_help("listen off loopback without TLS all the same")
    )
    import_roots: str = field(
        default="",
        metadata=_help(
            f"folders REST may import from, separated by '{os.pathsep}'; empty is the current "
            "folder and the home folder, for the admin token on this machine only"
        ),
    )
    allowed_hosts: str = field(
        default="", metadata=_help("further host names the page may be reached by, with commas")
    )
    trusted_proxies: str = field(
        default="",
        metadata=_help(
            "addresses or networks of proxies whose X-Forwarded-For is believed, with commas"
        ),
    )
    max_body: int = field(
        default=64 * 2**20, metadata=_help("greatest body of a request, bytes (uploads apart)")
    )
    max_upload: int = field(default=8 * 2**30, metadata=_help("greatest upload, bytes"))
    max_message: int = field(
        default=4 * 2**20, metadata=_help("greatest WebSocket message from a client, bytes")
    )
    max_frame_points: int = field(
        default=500_000_000, metadata=_help("greatest number of points in a frame")
    )
    wrong_tokens_per_minute: int = field(
        default=20,
        metadata=_help("wrong tokens that one address may try in a minute until it has to wait"),
    )
    requests_per_second: int = field(
        default=200, metadata=_help("requests a second that one client may sustain")
    )
    body_seconds: int = field(
        default=600, metadata=_help("seconds in which a body must have come whole (uploads apart)")
    )
    upload_seconds: int = field(
        default=14_400, metadata=_help("seconds in which an upload must have come whole")
    )
    stall_seconds: int = field(
        default=60,
        metadata=_help("seconds a client may read nothing of an answer until it is given up"),
    )
    exports: int = field(default=4, metadata=_help("exports under way at once, in all"))
    exports_per_person: int = field(
        default=2, metadata=_help("exports under way at once, of one person")
    )
    statement_seconds: int = field(
        default=60, metadata=_help("seconds that one statement of PostgreSQL may take")
    )
    keepalive_seconds: int = field(
        default=30,
        metadata=_help("seconds of silence until a connection to PostgreSQL is probed"),
    )

    @classmethod
    def load(
        cls, given: Mapping[str, Any] | None = None, environment: Mapping[str, str] | None = None
    ) -> Settings:
        """``given`` (the command line; None = not given) over the environment over defaults.

        Raises BadInputError for a value of the wrong form.
        """
        environment = os.environ if environment is None else environment
        values: dict[str, Any] = {}
        for option in fields(cls):
            variable = PREFIX + option.name.upper()
            if variable in environment:
                try:
                    values[option.name] = parse(option, environment[variable])
                except BadInputError as error:
                    raise BadInputError(f"{variable}: {error}") from None
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
        try:
            password = Path(self.database_password_file).read_text(encoding="utf-8").rstrip("\r\n")
        except (OSError, ValueError):
            raise BadInputError(
                f"database_password_file: expected a readable file, got "
                f"{self.database_password_file}"
            ) from None
        scheme, _, place = self.database.partition("://")
        user, at, server = place.rpartition("@")
        name = user.partition(":")[0] or quote(getuser(), safe="")
        return f"{scheme}://{name}:{quote(password, safe='')}@{server if at else place}"

    @property
    def roots(self) -> list[Path]:
        """Folders that REST may import from, as named, resolved."""
        return [Path(root).resolve() for root in self.import_roots.split(os.pathsep) if root]

    @property
    def own_roots(self) -> list[Path]:
        """The folders of who started the server: the current one and the home folder, resolved."""
        return [Path.cwd().resolve(), Path.home().resolve()]


def options() -> list[Field[Any]]:
    """All options, for the command line and the docs."""
    assert all(option.default is not MISSING for option in fields(Settings))  # noqa: S101
    return list(fields(Settings))


def parse(option: Field[Any], text: str) -> Any:
    """The value that ``text`` gives to ``option``; raises BadInputError, which does not name it."""
    kind = get_type_hints(Settings)[option.name]
    if kind is bool:
        return _flag(text)
    if kind is int:
        return _integer(text, option.metadata["least"], option.metadata["most"])
    return kind(text)


def _flag(text: str) -> bool:
    if text.lower() in ("1", "true", "yes", "on"):
        return True
    if text.lower() in ("", "0", "false", "no", "off"):
        return False
    raise BadInputError(f"expected 1 or 0, got {text!r}")


def _integer(text: str, least: int, most: int) -> int:
    wanted = f"an integer from {least}" + (f" to {most}" if most < UNBOUNDED else "")
    try:
        value = int(text)
    except ValueError:
        raise BadInputError(f"expected {wanted}, got {text!r}") from None
    if not least <= value <= most:
        raise BadInputError(f"expected {wanted}, got {value}")
    return value
