"""MIDI keyboards on the page, as a browser's fake of them."""

import pytest

from tests.clients.page.conftest import Table

pytestmark = pytest.mark.slow

MIDI = """
navigator.requestMIDIAccess = async () => (window.midi = {
  inputs: new Map([["1", (window.keys = { name: "Keys", state: "connected", onmidimessage: null })]]),
  onstatechange: null });
"""


def connect(table: Table) -> None:
    table.page.get_by_role("button", name="MIDI", exact=True).click()
    table.page.get_by_role("button", name="Connect MIDI").click()
    table.page.get_by_text("Listening to Keys.").wait_for()


def played(table: Table, *messages: list[int], by: str = "keys") -> None:
    for message in messages:
        table.ask(f"{by}.onmidimessage({{ data: {message} }})")


def test_midi_notes_play_tuned_copies_at_the_stated_speeds(play):
    table = play(MIDI)
    connect(table)
    played(table, [0x90, 64, 1], [0x90, 64, 0], [0x80, 64, 64], [0x95, 67, 127])
    speeds = [table.until(f"/church-bell.{note}/impact")[0].message.args[0] for note in (64, 67)]
    assert speeds == pytest.approx([0.05, 5.0])
    table.page.get_by_text("G4 on church bell, velocity 127").wait_for()
    played(table, [0xB0, 1, 127])
    damped = {line.message.address: line.message.args for line in table.until("/damp", 3)}
    assert damped == {f"/object/church-bell{copy}/damp": (1,) for copy in ("", ".64", ".67")}
    assert len(table.lines("/impact")) == 2, "a note that ends strikes nothing"
    played(table, [0xB0, 123, 0])
    table.until("/panic")


def test_midi_plays_the_object_that_was_chosen(play):
    table = play(MIDI)
    connect(table)
    table.page.get_by_label("Notes play").select_option(label="marimba bar")
    played(table, [0x90, 60, 64])
    table.until("/marimba-bar.60/impact")
    table.page.get_by_label("Notes play").select_option(label="by channel: 1 the first object, 2 the second, …")
    played(table, [0x91, 72, 64], [0x9F, 72, 64])
    second = table.ask("[...carom.scene.objects.keys()][1]")
    table.until(f"/{second}.72/impact")
    table.page.get_by_label("Notes play").select_option(label="marimba bar")
    with table.server.client() as client:
        client.send("/object/marimba-bar/free", 1)
    table.settle("!carom.scene.objects.has('marimba-bar')")
    assert table.page.get_by_label("Notes play").input_value() == ""
    played(table, [0x90, 62, 64])
    table.until("/church-bell.62/impact")
    assert len(table.lines("/impact")) == 3, "channel 16 has no object"


def test_a_midi_keyboard_that_comes_later_is_heard(play):
    table = play(MIDI)
    connect(table)
    table.ask("midi.inputs.set('2', (window.pads = { name: 'Pads', state: 'connected' }))")
    table.ask("midi.onstatechange()")
    table.page.get_by_text("Listening to Keys, Pads.").wait_for()
    played(table, [0x90, 60, 100], by="pads")
    table.until("/church-bell.60/impact")


def test_a_browser_that_gives_no_midi_says_so(play):
    table = play("navigator.requestMIDIAccess = async () => { throw new Error('denied'); };")
    table.page.get_by_role("button", name="MIDI", exact=True).click()
    table.page.get_by_role("button", name="Connect MIDI").click()
    table.page.get_by_text("No MIDI in this browser: denied").wait_for()
