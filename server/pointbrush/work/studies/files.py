"""The files of studies: YAML in the workspace, and the studies of the package."""

from __future__ import annotations

from pathlib import Path

from pointbrush.errors import BadInputError, NotFoundError
from pointbrush.formats.tables.parsing import parse_yaml
from pointbrush.names import is_plain
from pointbrush.sequences.storage.files import replace_file
from pointbrush.values.study import LONGEST_YAML, Study
from pointbrush.values.validation import describe

TEMPLATES = Path(__file__).parent / "templates"
ENDING = ".yaml"


class StudyFiles:
    """The files ``ID.yaml`` in a folder."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def ids(self) -> list[str]:
        """Return the ids of the studies."""
        files = (each for each in self._folder.glob(f"*{ENDING}") if each.is_file())
        return sorted(each.stem for each in files if is_plain(each.stem))

    def text(self, study: str) -> str:
        """Return the file of a study; raises NotFoundError."""
        try:
            return self._path(study).read_text("utf-8-sig", "replace")
        except (FileNotFoundError, IsADirectoryError):
            raise NotFoundError(f"study: expected a known id, got {study!r}") from None

    def read(self, study: str) -> Study:
        """Return a study; raises NotFoundError, and BadInputError for an invalid file."""
        return parse(self.text(study), study)

    def write(self, study: str, text: str) -> None:
        """Replace the file of a study, whole or not at all."""
        self._folder.mkdir(parents=True, exist_ok=True)
        replace_file(self._path(study), text.encode())

    def remove(self, study: str) -> None:
        """Remove the file of a study."""
        self._path(study).unlink(missing_ok=True)

    def _path(self, study: str) -> Path:
        if not is_plain(study):
            raise NotFoundError(f"study: expected a known id, got {study!r}")
        return self._folder / f"{study}{ENDING}"


def parse(text: str, name: str = "study") -> Study:
    """Return the study that a YAML text describes; raises BadInputError with the place of a fault.

    ``name``: of the study in errors.
    """
    from pydantic import TypeAdapter, ValidationError  # slow to import

    if len(text) > LONGEST_YAML:
        raise BadInputError(f"{name}: expected at most {LONGEST_YAML:,} characters")
    try:
        return TypeAdapter(Study).validate_python(parse_yaml(text))
    except ValidationError as error:
        found = describe(error.errors(include_url=False))
        raise BadInputError(f"{name}: {found}") from None
    except ValueError as error:
        raise BadInputError(f"{name}: expected YAML, got {error}") from None
