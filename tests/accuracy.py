"""Carom's accuracy: bounds that the tests hold, declared once for them and for the table in tests/README.md."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Promise:
    """A quantity, what it is compared with, the bound (below which the error stays) and its unit, and the test."""

    quantity: str
    reference: str
    bound: float
    unit: str
    test: str

    def __str__(self) -> str:
        mantissa, e, exponent = f"{self.bound:g}".partition("e")
        return f"{mantissa}{e}{int(exponent) if e else ''} {self.unit}"


_LAW, _PULSE = "dsp/contact/test_law.py", "dsp/contact/test_pulse.py"
_CLOSED, _COUPLED = "dsp/contact/test_closed_form.py", "dsp/contact/test_coupled.py"
_BOUNCE, _ROLL = "dsp/engine/contacts/test_bounce.py", "dsp/rolling/test_body.py"
_SOUND = "presets/test_sound.py"
_FREE = "dsp/spectral/test_synthesis.py"

RELEASE = Promise("release velocity, mu v from 1e-12 to 1e6", "mpmath, 50 digits", 1e-15, "relative", _LAW)
COMPRESSION = Promise("compression x(v), where v determines it", "mpmath, 50 digits", 2e-13, "relative", _LAW)
ENERGY = Promise("energy H(v)", "mpmath, 50 digits", 5e-13, "relative", _LAW)
DURATION = Promise("`contact_time`", "mpmath, 50 digits", 1e-13, "relative", _PULSE)
FORCE = Promise("`force_pulse`", "DOP853", 1e-10, "of its peak", _PULSE)
ENGINE_DURATION = Promise(
    "contact time in the engine, a up to 1.5, mu v up to 5", "`contact_time`", 2e-9, "relative", _CLOSED
)
ENGINE_FORCE = Promise("force in the engine, a up to 1.5, mu v up to 5", "`force_pulse`", 2e-6, "of its peak", _CLOSED)
WORST_DURATION = Promise(
    "contact time in the engine, a up to 4, mu v up to 1e6", "`contact_time`", 2.6e-5, "relative", _CLOSED
)
WORST_FORCE = Promise(
    "force in the engine, a up to 4, mu v up to 1e6", "`force_pulse`", 3.65e-4, "of its peak", _CLOSED
)
MOMENTUM = Promise(
    "momentum given to the modes, contacts of 0.01 to 200 samples", "m (v_in - v_out)", 1e-12, "relative", _CLOSED
)
DRIVEN = Promise(
    "a mode driven by a contact of 0.05 to 50 samples, 30 Hz to 22.8 kHz at 48 kHz", "DOP853 of striker and mode", 2e-5,
    "of its peak", "dsp/resonator/test_bank.py",
)  # fmt: skip
COUPLED = Promise(
    "velocity of an object in 200 random coupled contacts at `-60`, nine of ten", "DOP853", -60.0, "dB", _COUPLED
)
COUPLED_EXACT = Promise("the same at `exact`", "DOP853", -130.0, "dB", _COUPLED)
ENGINE_COUPLED = Promise(
    "velocity of an object that rings already, as the engine strikes it", "DOP853", -60.0, "dB",
    "dsp/engine/contacts/test_coupling.py",
)  # fmt: skip
SEVERAL = {
    level: Promise(what, "DOP853", bound, "dB", "dsp/engine/contacts/test_contact_groups.py")
    for level, what, bound in (
        ("-50", "velocity of an object that two to four strikers touch at once, at `-50`", -45.0),
        ("-60", "the same at `-60`", -55.0),
        ("-80", "the same at `-80`", -75.0),
        ("exact", "the same at `exact`", -120.0),
    )
}
GROWTH = Promise(
    "growth of the energy of striker and modes, extreme contacts (k to 1e16 N/m^a, mu to 1e3 s/m)", "no growth", 1e-8,
    "of the contact's energy", _COUPLED,
)  # fmt: skip
LOSSLESS = Promise(
    "energy after lossless hits on 1 to 64 modes, at `exact`", "energy before", 1e-8, "relative", _COUPLED
)
GIVEN = Promise(
    "energy that a striker gives to an object: all built-in pairs, two positions", "its own energy", 1e-6, "above it",
    _SOUND,
)  # fmt: skip
BOUNCE_TIMES = Promise("times of a bounce's first 100 contacts", "mpmath, law and parabola", 1e-9, "s", _BOUNCE)
BOUNCE_SPEEDS = Promise("their speeds", "mpmath, law and parabola", 1e-10, "relative", _BOUNCE)
WEIGHTY = Promise("duration and contacts of a bounce whose weight acts in contact", "DOP853", 1e-3, "relative", _BOUNCE)
ROLL_THIRDS = Promise(
    "third-octaves of a roll's force at `-60`, 50 Hz to 16 kHz", "the same path at 20 times the rate", 1.0, "dB", _ROLL
)
ROLL_DRIVEN = Promise(
    "sound below 20 kHz of modes that a roll drives, at rest or moving", "the same force by its moments", -80.0, "dB",
    "dsp/resonator/test_fed.py",
)  # fmt: skip
RINGING = {
    form: Promise(
        f"modes that ring freely for ten seconds, in {form}", "damped sines", bound, "dB of a block's peak", _FREE
    )
    for form, bound in (("float64", -115.0), ("float32", -95.0))
}
ROLL_START = Promise(
    "a roll's force over its first 10 ms on a rigid object, from `-80` on", "DOP853", 1e-3, "of its peak", _ROLL
)
ROLL_RATES = Promise("impulses of a roll at 44.1, 48 and 96 kHz", "each other", 1e-9, "relative", _ROLL)
ROLL_COUPLED = {
    level: Promise(
        f"a point that a body pushes as it rolls and hops for 16 ms, at `{level}`",
        "DOP853",
        bound,
        "dB",
        "dsp/engine/contacts/test_coupled_rolls.py",
    )
    for level, bound in (("-50", -50.0), ("-60", -60.0), ("exact", -120.0))
}
TIMOSHENKO = Promise(
    "partials of thick bars, L/h of 10 and 40, against thin ones", "published deviations", 0.1, "% of a partial",
    "dsp/bodies/test_bar.py",
)  # fmt: skip
PLATE = Promise(
    "partials of a plate with free edges, 200 of them",
    "Ritz, plain Legendre polynomials",
    2e-5,
    "relative",
    "dsp/bodies/test_plate.py",
)
RATES = {
    names: Promise(
        f"a strike at 48 kHz, below 12 kHz: {', '.join(names)}",
        "each fourth sample at 192 kHz",
        -100.0,
        "dB, of its energy",
        "presets/test_rates.py",
    )
    for names in (("glass-plate", "wine-glass", "wood-board", "marimba-bar", "pot-lid", "tin-lid", "steel-plate"),)
}
PITCH = Promise("pitch of a partial of a large object, as rendered", "the preset", 0.1, "cents", _SOUND)
DECAY = Promise("its decay time", "the preset", 0.01, "relative", _SOUND)
PARTIALS = Promise(
    "sound of any other object once the contact is over", "damped sines of the preset", 1e-4, "of its norm", _SOUND
)

PROMISES = [
    promise
    for each in tuple(globals().values())
    for promise in (each.values() if isinstance(each, dict) else (each,))
    if isinstance(promise, Promise)
]
