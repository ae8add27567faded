"""The Compose file, its Dockerfiles and the proxy: the specification's rules and our own."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml

from pointbrush.cli import parser
from pointbrush.settings.settings import options

ROOT = Path(__file__).parent.parent
DEPLOY = ROOT / "deploy"
SERVICE_KEYS = {
    "build", "image", "command", "ports", "environment", "volumes", "restart", "read_only",
    "tmpfs", "cap_drop", "security_opt", "depends_on", "healthcheck", "user", "profiles",
    "secrets", "networks", "deploy", "logging", "stop_grace_period", "shm_size",
}  # fmt: skip
EXACT = re.compile(r"v?\d+\.\d+(\.\d+)?([-.][a-z0-9]+)*")
COMPOSE: dict[str, Any] = yaml.safe_load((ROOT / "docker-compose.yml").read_text())
SERVICES: dict[str, dict[str, Any]] = COMPOSE["services"]
LASTING = {name: each for name, each in SERVICES.items() if each.get("profiles") != ["by-hand"]}
each_service = pytest.mark.parametrize("name", sorted(SERVICES))


def test_the_topology_is_that_of_a_lab() -> None:
    assert set(LASTING) == {
        "caddy", "pointbrush-1", "pointbrush-2", "scheduler", "worker", "postgres",
        "prometheus",
    }  # fmt: skip
    top = {key for key in COMPOSE if not key.startswith("x-")}
    assert top == {"name", "services", "volumes", "networks", "secrets"}


@each_service
def test_a_service_has_only_keys_of_the_specification_and_names_that_exist(name: str) -> None:
    service = SERVICES[name]
    assert set(service) <= SERVICE_KEYS
    assert set(service.get("secrets", [])) <= set(COMPOSE["secrets"])
    assert set(service["networks"]) <= set(COMPOSE["networks"])
    for other, wait in service.get("depends_on", {}).items():
        assert wait == {"condition": "service_healthy"}
        assert "test" in LASTING[other]["healthcheck"]
    for volume in service.get("volumes", []):
        source = volume.split(":")[0]
        assert source.startswith(".") or source in COMPOSE["volumes"]


@each_service
def test_a_service_runs_without_rights_and_within_limits(name: str) -> None:
    service = SERVICES[name]
    user = service["user"]
    assert re.fullmatch(r"[1-9]\d*:[1-9]\d*", user), "not root, by number"
    assert service["read_only"] is True
    assert service["cap_drop"] == ["ALL"]
    assert service["security_opt"] == ["no-new-privileges:true"]
    assert {"cpus", "memory", "pids"} <= set(service["deploy"]["resources"]["limits"])
    assert EXACT.fullmatch(service["image"].rpartition(":")[2])
    assert ("test" in service["healthcheck"]) == (name in LASTING)
    assert ("restart", "unless-stopped") in service.items() or name not in LASTING


def test_secrets_come_by_file_alone() -> None:
    for service in SERVICES.values():
        for variable, value in service.get("environment", {}).items():
            if re.search("PASSWORD|TOKEN|SECRET", variable):
                assert variable.endswith("_FILE")
                assert value.removeprefix("/run/secrets/") in service["secrets"]
    ignored = (ROOT / ".gitignore").read_text().splitlines()
    for secret in COMPOSE["secrets"].values():
        assert f"{Path(secret['file']).parent}/" in ignored


def test_only_the_proxy_is_published_and_on_loopback_unless_told() -> None:
    published = {name: each["ports"] for name, each in SERVICES.items() if "ports" in each}
    assert published == {
        "caddy": ["${POINTBRUSH_LISTEN:-127.0.0.1}:8443:8443"],
        "prometheus": ["127.0.0.1:9090:9090"],
    }
    assert COMPOSE["networks"]["inside"]["internal"] is True
    assert {name for name, each in SERVICES.items() if "outside" in each["networks"]} == {
        *published
    }


def test_options_and_commands_are_those_of_the_program() -> None:
    known = {each.variable for each in options()}
    for name in ("pointbrush-1", "pointbrush-2", "backup"):
        assert set(SERVICES[name]["environment"]) <= known | {"TMPDIR"}
    assert parser().parse_args(SERVICES["backup"]["command"][1:]).command == "backup"
    for name in ("pointbrush-1", "backup"):
        assert mounts(SERVICES[name])[SERVICES[name]["environment"]["POINTBRUSH_BACKUP_TO"]]
    restore = re.search(r"pointbrush (restore \S+)'", (DEPLOY / "restore.sh").read_text())
    assert restore is not None
    assert parser().parse_args(restore[1].split()).command == "restore"


def in_bytes(size: str) -> int:
    """Bytes of a size such as ``256m``."""
    return int(size[:-1]) << {"k": 10, "m": 20, "g": 30}[size[-1].lower()]


def mounts(service: dict[str, Any]) -> dict[str, str]:
    """Source of each mount, by its place in the container."""
    return {each.split(":")[1]: each.split(":")[0] for each in service.get("volumes", [])}


@each_service
def test_memory_that_files_may_take_is_a_small_part_of_a_services(name: str) -> None:
    service = SERVICES[name]
    most = in_bytes(service["deploy"]["resources"]["limits"]["memory"])
    sizes = [re.search(r":(?:.*,)?size=(\w+)", each) for each in service["tmpfs"]]
    assert all(sizes), "unbounded, it is half of the machine's"
    assert sum(in_bytes(size[1]) for size in sizes if size) <= most / 2


def test_archives_unpack_on_the_volume_that_workers_share_with_the_servers() -> None:
    # A worker of the cluster has the server's folder for temporary files, unless it has a TMPDIR.
    servers = [SERVICES[name] for name in ("pointbrush-1", "pointbrush-2")]
    for service in (*servers, SERVICES["worker"]):
        assert mounts(service)["/workspace"] == "workspace"
        assert "TMPDIR" not in service.get("environment", {})
    assert all(each["environment"]["POINTBRUSH_WORKSPACE"] == "/workspace/lab" for each in servers)
    backup = SERVICES["backup"]
    assert backup["environment"]["TMPDIR"] in mounts(backup)
    assert backup["environment"].keys() - {"TMPDIR"} == servers[0]["environment"].keys()


def test_prometheus_scrapes_both_servers_with_its_secret_and_knows_its_rules() -> None:
    config = yaml.safe_load((DEPLOY / "prometheus.yml").read_text())
    (scraped,) = config["scrape_configs"]
    hosts = SERVICES["pointbrush-1"]["environment"]["POINTBRUSH_ALLOWED_HOSTS"]
    targets = [target for one in scraped["static_configs"] for target in one["targets"]]
    assert targets == ["pointbrush-1:8080", "pointbrush-2:8080"]
    assert all(target.partition(":")[0] in hosts.split(",") for target in targets)
    secret = scraped["authorization"]["credentials_file"]
    assert secret.removeprefix("/run/secrets/") in SERVICES["prometheus"]["secrets"]
    assert {f"/etc/prometheus/{name}" for name in config["rule_files"]} < set(
        mounts(SERVICES["prometheus"])
    )


def test_systemd_accepts_the_unit_whose_options_are_those_of_the_program(tmp_path: Path) -> None:
    text = (DEPLOY / "pointbrush.service").read_text()
    asked = re.findall(r"^Environment=(POINTBRUSH_\w+)=", text, re.MULTILINE)
    assert set(asked) <= {each.variable for each in options()}
    command = re.search(r"^ExecStart=\S+/pointbrush (.+)$", text, re.MULTILINE)
    assert command is not None
    assert parser().parse_args(command[1].split()).command == "serve"
    if shutil.which("systemd-analyze") is None:
        pytest.skip("no systemd here")
    unit = tmp_path / "pointbrush.service"
    unit.write_text(re.sub(r"^ExecStart=\S+", f"ExecStart={sys.executable}", text, flags=re.M))
    checked = subprocess.run(["systemd-analyze", "verify", unit], capture_output=True, text=True)
    ours = [line for line in checked.stderr.splitlines() if "pointbrush" in line]
    assert (checked.returncode, ours) == (0, [])


def test_certificate_files_that_the_proxy_is_told_of_are_mounted() -> None:
    told = (DEPLOY / "Caddyfile").read_text() + (ROOT / "docs" / "deploy.md").read_text()
    files = set(re.findall(r"(/[\w/-]+)/[\w.-]+\.pem\b", told))
    assert files
    mounted = mounts(SERVICES["caddy"])
    assert files <= set(mounted)
    for place in files:
        assert (ROOT / mounted[place]).parent == DEPLOY
        assert f"{mounted[place].removeprefix('./')}/" in (ROOT / ".gitignore").read_text()


def test_the_servers_stop_after_their_drain() -> None:
    for name in ("pointbrush-1", "pointbrush-2"):
        assert int(SERVICES[name]["stop_grace_period"].removesuffix("s")) > 10


def test_the_proxy_sends_to_both_servers_and_asks_whether_they_are_ready() -> None:
    text = (DEPLOY / "Caddyfile").read_text()
    proxied = re.search(r"reverse_proxy (.*) \{", text)
    assert proxied is not None
    assert proxied[1].split() == ["pointbrush-1:8080", "pointbrush-2:8080"]
    assert "health_uri /readyz" in text
    assert text.count("{") == text.count("}")
    used = set(re.findall(r"\{\$(\w+)", text))
    assert used <= set(SERVICES["caddy"]["environment"])


def test_images_are_built_of_exact_versions_and_run_as_nobody_special() -> None:
    for service in SERVICES.values():
        if "build" not in service:
            continue
        build = service["build"]
        text = (ROOT / build["context"] / build["dockerfile"]).read_text()
        for base in re.findall(r"^FROM (\S+)", text, re.MULTILINE):
            assert EXACT.fullmatch(base.rpartition(":")[2]), base
        assert re.search(r"^USER (pointbrush|10001:10001)$", text, re.MULTILINE)
    assert "--uid 10001" in (ROOT / "server" / "Dockerfile").read_text()
    assert (ROOT / "constraints.txt").is_file()


def test_secrets_are_made_once(tmp_path: Path) -> None:
    script = tmp_path / "deploy" / "secrets.sh"
    script.parent.mkdir()
    script.write_bytes((DEPLOY / "secrets.sh").read_bytes())
    made = []
    for _ in range(2):
        subprocess.run(["sh", script], check=True)
        made.append({path.name: path.read_text() for path in script.parent.glob("secrets/*")})
    assert made[0] == made[1]
    assert set(made[0]) == set(COMPOSE["secrets"]) - {"prometheus_token"}
    assert all(len(secret) > 30 for secret in made[0].values())
    assert (script.parent / "secrets").stat().st_mode & 0o077 == 0


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
