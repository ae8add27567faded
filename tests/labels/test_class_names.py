"""Whatever happens to classes and labels: a label stays of its class, a class keeps its numbers."""

from __future__ import annotations

from dataclasses import dataclass, field
from random import Random

import pytest

from pointbrush.errors import ConflictError
from pointbrush.formats.tables.numbering import KITTI_NUMBERS, official_numbers, plain
from pointbrush.labels import Category
from pointbrush.teamwork.store import WorkspaceStore
from tests.stores import SEQUENCE

WORDS = ("car", "fence", "Traffic Sign", "post", "stone", "zebra")
STEPS = 60
OFFICIAL = official_numbers("semantickitti")


@dataclass(eq=False)
class Kind:
    """A class as people think of it; ``numbers`` are those of its first export."""

    name: str
    target: Kind | None = None
    deleted: bool = False
    numbers: tuple[int, int] | None = None

    @property
    def now(self) -> Kind:
        return self if self.target is None else self.target.now


@dataclass
class Model:
    """Labels by id with their classes, and those before each edit that can be undone or redone."""

    store: WorkspaceStore
    random: Random
    kinds: list[Kind] = field(default_factory=list)
    labels: dict[int, Kind] = field(default_factory=dict)
    undo: list[dict[int, Kind]] = field(default_factory=list)
    redo: list[dict[int, Kind]] = field(default_factory=list)

    def called(self, name: str) -> Kind:
        found = [k for k in self.kinds if k.target is None and k.name == name]
        if not found:
            self.kinds.append(Kind(name))
        kind = found[0] if found else self.kinds[-1]
        kind.deleted = False
        return kind

    def shown(self) -> list[Kind]:
        return [k for k in self.kinds if k.target is None and not k.deleted]

    def number(self, kind: Kind) -> int:
        return self.store.taxonomy.numbers([kind.name])[kind.name]

    def edited(self, label: int, name: str) -> None:
        self.undo.append(dict(self.labels))
        self.redo.clear()
        self.labels[label] = self.called(name)

    # ── steps ────────────────────────────────────────────────────────────────────────────

    def add(self) -> None:
        name = self.random.choice(WORDS)
        made = self.store.create_label(SEQUENCE, "ann", name="thing", category=name, distinct=True)
        assert made.category == name
        self.edited(made.id, name)

    def give(self) -> None:
        if self.labels:
            label, name = self.random.choice(sorted(self.labels)), self.random.choice(WORDS)
            before = self.store.label(SEQUENCE, label).category
            self.store.update_label(SEQUENCE, "ann", label, category=name)
            if before != name:
                self.edited(label, name)

    def turn(self) -> None:
        back = self.random.random() < 0.6
        source, other = (self.undo, self.redo) if back else (self.redo, self.undo)
        if source:
            (self.store.undo if back else self.store.redo)(SEQUENCE, "ann")
            other.append(dict(self.labels))
            self.labels = source.pop()
            for kind in self.labels.values():
                kind.now.deleted = False

    def rename(self) -> None:
        if shown := self.shown():
            kind, name = self.random.choice(shown), self.random.choice(WORDS)
            wanted = Category(self.number(kind), name)
            if any(other.name == name for other in shown if other is not kind):
                with pytest.raises(ConflictError):
                    self.store.taxonomy.put([wanted])
                return
            self.store.taxonomy.put([wanted])
            for other in self.kinds:
                if other is not kind and other.target is None and other.name == name:
                    other.target = kind
            kind.name = name

    def swap(self) -> None:
        if len(shown := self.shown()) > 1:
            one, other = self.random.sample(shown, 2)
            pair = [Category(self.number(one), other.name), Category(self.number(other), one.name)]
            self.store.taxonomy.put(pair)
            one.name, other.name = other.name, one.name

    def merge(self) -> None:
        if len(shown := self.shown()) > 1:
            one, other = self.random.sample(shown, 2)
            self.store.taxonomy.merge(self.number(one), [self.number(other)])
            other.target = one

    def delete(self) -> None:
        if shown := self.shown():
            kind = self.random.choice(shown)
            number = self.number(kind)
            if any(used.now is kind for used in self.labels.values()):
                with pytest.raises(ConflictError):
                    self.store.taxonomy.remove(number)
            else:
                self.store.taxonomy.remove(number)
                kind.deleted = True

    def check(self) -> None:
        palette = self.store.palette(SEQUENCE)
        now = {label: kind.now.name for label, kind in self.labels.items()}
        assert {label.id: label.category for label in palette} == now
        own, datasets = self.store.taxonomy.exported(palette, KITTI_NUMBERS)
        for kind in {kind.now for kind in self.labels.values()}:
            numbers = own[kind.name], datasets["semantickitti"][kind.name]
            if kind.numbers is None:
                official = OFFICIAL.get(plain(kind.name))
                assert numbers[1] not in OFFICIAL.values() or numbers[1] == official
            kind.numbers = kind.numbers or numbers
            assert kind.numbers == numbers
        assert len(set(own.values())) == len(own)


@pytest.mark.parametrize("seed", range(6))
def test_labels_stay_of_their_classes_and_numbers_of_theirs(
    store: WorkspaceStore, seed: int
) -> None:
    random = Random(seed)
    model = Model(store, random)
    steps = [model.add, model.give, model.give, model.turn, model.turn, model.rename,
             model.swap, model.merge, model.delete]  # fmt: skip
    for _ in range(STEPS):
        random.choice(steps)()
        model.check()
    assert store.check(SEQUENCE) == []
