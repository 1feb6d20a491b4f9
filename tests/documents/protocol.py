"""Tables of the OSC reference: the fields of /status.reply, and what the engine has room for."""

import dataclasses

from carom.dsp.counters import Stats
from carom.dsp.engine.memory import capacity, state
from carom.dsp.engine.memory.capacity import USUAL_MODES, USUAL_OBJECTS
from carom.dsp.swarm.record import SWARMS
from carom.server.osc.score import LONGEST_SCORE
from carom.server.render import HIGHEST_RATE, LOWEST_RATE
from carom.server.scene.limits import LONGEST_BOUNCE, LONGEST_CONTACT
from carom.server.status import FIELDS, FIRST
from tests.documents.markdown import table


def status() -> str:
    """Return the values of /status.reply by position, then by name."""
    numbered = [(place, help) for place, help in enumerate(FIRST, 1)]
    stats = {field.name: field.metadata for field in dataclasses.fields(Stats)}
    named = [(f"`{name}`", help or stats[name]["help"]) for name, help in FIELDS.items()]
    return f"{table(('place', 'value'), numbered)}\n\n{table(('name', 'value that follows'), named)}"


def limits() -> str:
    """Return the room that there is at once."""
    rows = [
        ("objects, by default", USUAL_OBJECTS),
        ("objects, with `--objects`", capacity.OBJECTS),
        ("modes, by default", USUAL_MODES),
        ("modes, with `--modes`", capacity.MODES),
        ("modes of an object", capacity.MODES_PER_OBJECT),
        ("values of mode shapes", capacity.SHAPE_VALUES),
        ("contacts, and gestures in progress", state.CONTACTS),
        ("of these, rolls and slides", state.ROLLS),
        ("of these, rain, pours, shakes, crumples, steps and shattering", SWARMS),
        ("events that wait for their time", state.EVENTS),
        ("length of a contact", f"{LONGEST_CONTACT:g} s"),
        ("length of a bounce", f"{LONGEST_BOUNCE:,.0f} s"),
        ("length of a score", f"{LONGEST_SCORE / 86_400:g} days"),
        ("sampling rate", f"{LOWEST_RATE:,} to {HIGHEST_RATE:,} Hz"),
    ]
    return table(("", "at most"), [(name, f"{value:,}" if isinstance(value, int) else value) for name, value in rows])
