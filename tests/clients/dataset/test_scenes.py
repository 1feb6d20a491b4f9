"""Scenes that are kept for other items with the same objects."""

import numpy as np
import pytest

import carom
from carom.clients.dataset import scenes
from carom.server.osc.wire import Message
from carom.server.scene.repeated import Repeated
from tests import needs

RECIPE = {
    "object": {"preset": {"choice": ["wood-block", "frame-drum"]}},
    "impact": {"striker": {"choice": ["drumstick", "steel"]}, "velocity": {"uniform": (0.5, 1)}},
    "spin": {"duration": {"uniform": (0.1, 1)}},
    "seconds": 0.03,
}
BY = {
    **RECIPE,
    "object": {"preset": "plain"},
    "by": {"preset": "wood-block"},
    "impact": {"velocity": {"uniform": (0.5, 1)}},
}


@pytest.fixture
def kept(monkeypatch):
    """The scenes that are kept."""
    for name, empty in (("_kept", {}), ("_asked", {}), ("_missed", [])):
        monkeypatch.setattr(scenes, name, empty)
    return scenes._kept


def rows(recipe, folder, count):
    return list(carom.render_many(recipe, range(count), presets=folder))


def same(first, second):
    """Return whether two values are the same, arrays and all."""
    if isinstance(first, dict):
        return first.keys() == second.keys() and all(same(first[key], second[key]) for key in first)
    if isinstance(first, list):
        return len(first) == len(second) and all(map(same, first, second))
    return bool(np.array_equal(first, second))


@pytest.mark.slow
@pytest.mark.parametrize(("recipe", "objects"), [(RECIPE, 2), (BY, 1)])
def test_clips_of_a_scene_that_is_kept_are_those_of_a_new_one(tmp_path, monkeypatch, kept, recipe, objects):
    bell = carom.Presets().path("objects", "church-bell").read_text()
    (tmp_path / "objects").mkdir()
    (tmp_path / "objects" / "plain.toml").write_text(bell.replace('material = "bell-bronze"\n', ""))
    monkeypatch.setattr(scenes, "_MOST", 0)
    new = rows(recipe, tmp_path, 14)
    assert not kept
    monkeypatch.setattr(scenes, "_MOST", 32)
    again = rows(recipe, tmp_path, 14)
    assert all(map(same, new, again))
    assert any("object has no material" in row["warnings"][0] for row in again if row["warnings"]) == (recipe is BY)
    if not kept:
        needs.written_pages()
    assert len(kept) == objects and {row["gesture"] for row in again} == {"impact", "spin"}


def test_a_scene_in_which_something_stands_or_senses_is_not_kept(tmp_path, kept):
    block = carom.Presets().path("objects", "wood-block").read_text()
    (tmp_path / "objects").mkdir()
    (tmp_path / "objects" / "laid.toml").write_text(f'{block}\n[rest]\nsupport = "table"\npositions = [0.2, 0.8]\n')
    recipe = {**RECIPE, "spin": {"duration": 0.1}}
    rows({**recipe, "object": {"preset": "laid"}}, tmp_path, 4)
    rows({**recipe, "object": {"preset": "wood-block"}, "sensor": {"quantity": "acceleration"}}, (), 4)
    assert not kept


@pytest.mark.slow
def test_kept_scenes_are_let_go_once_others_are_asked_for(monkeypatch, kept):
    monkeypatch.setattr(scenes, "_MOST", 1)
    monkeypatch.setattr(scenes, "_MOST_MISSED", 4)
    recipe = {**RECIPE, "spin": {"duration": 0.1}}
    rows({**recipe, "object": {"preset": "wood-block"}}, (), 3)
    if not kept:
        needs.written_pages()
    for count, name in ((4, "wood-block"), (6, "frame-drum")):
        rows({**recipe, "object": {"preset": "frame-drum"}}, (), count)
        assert [key[3][0].args[1] for key in kept] == [name]


@pytest.fixture
def rewound():
    """Return a function that makes a scene of an object, and what brings it back to its beginning."""

    def make(preset):
        made = [Message("/object/new", ("object", preset))]
        scene = scenes.scene_for(48_000, 1, made, carom.Presets())
        scene = scenes.scene_for(48_000, 1, made, carom.Presets())  # the first one of a process is not kept
        mark = scene.performer.mark()
        if mark is None:
            needs.written_pages()
        return scene.performer, lambda: scene.performer.rewind(mark)

    return make


def told(performer):
    """Return the last command's bytes, all strikers', and what is known of gestures and contacts."""
    ring, gestures = performer.engine.ring, performer.scene.gestures.running()
    command = ring.bytes[ring.sent - 1].tobytes(), performer.engine.state[0]["strikers"].tobytes()
    return *command, ring.sent, [(each.number, each.running) for each in gestures], performer.striking(ring.sent - 1)


@pytest.mark.parametrize("preset", ["wood-block", "frame-drum", "glass-ball"])
@pytest.mark.parametrize("striker", ["drumstick", "felt-hammer", "steel", "fingertip"])
def test_a_blow_that_is_repeated_is_the_command_of_its_message(rewound, preset, striker):
    performer, rewind = rewound(preset)
    blows = Repeated(performer.scene, {})

    def blow(velocity, *keys):
        return Message("/object/object/impact", (velocity, "striker", striker, *keys, "id", "impact"))

    for first, again in (
        (blow(0.3, "position", 0.2), blow(0.7, "position", 0.9)),
        (blow(0.3), blow(2)),
        (blow(0.3, "gain", -6.0), blow(0.2, "gain", -6.0)),
    ):
        performer.perform([first], 0.01)
        blows.remember(first)
        rewind()
        performer.perform([again], 0.05)
        expected = told(performer)
        rewind()
        assert performer.repeat(blows, again, 0.05)
        assert told(performer) == expected
        rewind()


@pytest.mark.slow
@pytest.mark.parametrize("preset", ["wood-block", "frame-drum", "glass-ball", "piano-string", "marimba-bar"])
def test_a_blow_is_the_same_command_on_an_object_of_another_size(preset):
    keys = ("striker", "drumstick", "gain", -6.0, "id", "impact")
    first, again = (Message("/object/object/impact", (each, *keys)) for each in (0.3, 0.7))

    def sized(size):
        made = Message("/object/new", ("object", preset, "size", size, "most_modes", 9))
        return scenes._made(48_000, 1, [made], carom.Presets())

    small, known = sized(0.9), {}
    small.perform([first], 0.01)
    Repeated(small.scene, known).remember(first)
    large, other = sized(1.2), sized(1.2)
    large.perform([again], 0.05)
    assert other.repeat(Repeated(other.scene, known), again, 0.05)
    assert told(other) == told(large)


@pytest.mark.slow
def test_blows_are_repeated_on_objects_of_other_sizes_alone(monkeypatch):
    """Clips are those without; what else is drawn of the object may change its blows."""
    recipe = {
        **RECIPE,
        "object": {"preset": "wood-block", "size": {"uniform": (0.8, 1.2)}, "material": {"choice": ["wood", "steel"]}},
        "impact": {"striker": "wood", "velocity": {"uniform": (0.5, 1)}},
    }
    del recipe["spin"]
    scenes._blows.cache_clear()
    again = rows(recipe, (), 12)
    assert scenes._blows.cache_info().currsize == 2
    monkeypatch.setattr(scenes, "_blows", lambda *told: None)
    assert all(map(same, rows(recipe, (), 12), again))


def test_blows_that_are_refused_or_unlike_earlier_ones_are_not_repeated(rewound):
    performer, rewind = rewound("wood-block")
    blows, keys = Repeated(performer.scene, {}), ("striker", "steel", "position", 0.2, "id", "impact")
    first = Message("/object/object/impact", (0.3, *keys))
    performer.perform([first], 0.01)
    blows.remember(first)
    rewind()
    for args in (
        (0.0, *keys), (-1.0, *keys), (2e3, *keys), ("fast", *keys), (float("nan"), *keys),
        (0.3, "striker", "steel", "position", 1.5, "id", "impact"),
        (0.3, "striker", "steel", "position", "end", "id", "impact"),
        (0.3, "striker", "wood", "position", 0.2, "id", "impact"),
        (0.3, *keys, "gain", -3.0), (),
    ):  # fmt: skip
        assert not performer.repeat(blows, Message("/object/object/impact", args), 0.05)
    assert not performer.repeat(blows, Message("/object/other/impact", first.args), 0.05)
    for message in (
        Message("/object/object/spin", (1.0, "id", "spin")),
        Message("/object/object/impact", (0.3, "striker", "steel")),
        Message("/object/object/impact", (0.0, "striker", "wood", "id", "impact")),
    ):
        performer.perform([message], 0.01)
        blows.remember(message)
        rewind()
        assert not performer.repeat(blows, message, 0.01)
