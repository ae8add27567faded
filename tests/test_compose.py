"""The Compose file and the Dockerfile, checked by the Compose specification's rules."""

from __future__ import annotations

from pathlib import Path

import yaml

ROOT = Path(__file__).parent.parent
SERVICE_KEYS = {
    "build", "image", "command", "ports", "environment", "volumes", "restart", "read_only",
    "tmpfs", "cap_drop", "security_opt", "depends_on", "healthcheck", "user", "profiles",
}  # fmt: skip


def compose() -> dict[str, dict[str, dict[str, object]]]:
    loaded: dict[str, dict[str, dict[str, object]]] = yaml.safe_load(
        (ROOT / "docker-compose.yml").read_text()
    )
    return loaded


def test_the_file_has_only_keys_of_the_specification() -> None:
    assert set(compose()) <= {"name", "services", "volumes", "networks"}
    for service in compose()["services"].values():
        assert set(service) <= SERVICE_KEYS
        assert ("build" in service) or ("image" in service)


def test_every_named_volume_is_declared() -> None:
    for service in compose()["services"].values():
        for volume in service.get("volumes", []):  # type: ignore[attr-defined]
            source = str(volume).split(":")[0]
            assert source.startswith((".", "/")) or source in compose()["volumes"]


def test_the_server_is_published_on_loopback_only() -> None:
    for service in compose()["services"].values():
        for port in service.get("ports", []):  # type: ignore[attr-defined]
            assert str(port).startswith("127.0.0.1:")


def test_the_dockerfile_is_where_compose_looks_and_copies_what_exists() -> None:
    build = compose()["services"]["pointbrush"]["build"]
    assert isinstance(build, dict)
    text = (ROOT / build["dockerfile"]).read_text()
    assert "USER pointbrush" in text
    assert (ROOT / "constraints.txt").is_file()


def test_the_build_context_holds_only_what_the_wheel_is_built_of() -> None:
    lines = (ROOT / ".dockerignore").read_text().splitlines()
    rules = [line for line in lines if line and not line.startswith("#")]
    assert rules[0] == "*"  # what is not named stays out: recordings, workspaces, .env
    let_in = {rule[1:] for rule in rules if rule.startswith("!")}
    assert let_in == {
        "pyproject.toml", "README.md", "LICENSE", "constraints.txt", "server", "webxr_client",
    }  # fmt: skip
    assert all((ROOT / name).exists() for name in let_in)
    assert {"**/node_modules", "**/.env*", "**/*.key", "**/*.sqlite*"} <= set(rules)


def test_the_health_check_works_with_and_without_tls() -> None:
    text = (ROOT / "server" / "Dockerfile").read_text()
    assert '"-m", "pointbrush.web.health"' in text
    assert "http://" not in text
