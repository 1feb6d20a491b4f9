"""The sound of strikers, from the sections [click], [ringing] and [snap] of their files."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from ..dsp.bodies import acceleration
from ..dsp.bodies.striker import Snap, StrikerSound, ringing
from .schema import CLICK, RINGING, SNAP, PresetError, check


def sound_of(where: str, data: Mapping[str, Any], mass: float, ball: float | None) -> StrikerSound | None:
    """Return the sound of a striker of a mass (kg), None if it has none. `where` begins the text of a PresetError.

    ball: the radius (m) of one that is a solid ball, and clicks as such if no section [click] says otherwise.
    """
    click = check(f"{where}[click] ", data.get("click", {}), CLICK, ("radius",) if "click" in data else ())
    own = check(f"{where}[ringing] ", data.get("ringing", {}), RINGING, _required("ringing", data))
    snap = check(f"{where}[snap] ", data.get("snap", {}), SNAP, _required("snap", data))
    if snap and not own:
        raise PresetError(f"{where}[snap]: expected a section [ringing] too, whose modes it moves")
    sound = StrikerSound(mass)
    if click:
        sound = sound._replace(click=_click(f"{where}[click] ", click, mass), radius=click["radius"])
    elif ball is not None:
        sound = sound._replace(click=acceleration.sphere(mass, ball), radius=ball)
    if own:
        try:
            sound = sound._replace(ringing=ringing(**own), snap=Snap(**snap) if snap else None)
        except ValueError as error:
            raise PresetError(f"{where}[ringing] {error}") from None
    return sound if sound.click or sound.ringing else None


def _required(section: str, data: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the keys that a section must have, if it is there."""
    needed = {"ringing": ("frequency", "t60", "modal_mass"), "snap": tuple(SNAP)}
    return needed[section] if section in data else ()


def _click(where: str, values: Mapping[str, Any], mass: float) -> acceleration.Click:
    if values.get("shape", "sphere") == "sphere":
        for key in ("thickness", "tilt"):
            if key in values:
                raise PresetError(f"{where}{key} = {values[key]:g}: expected it of a disc only")
        return acceleration.sphere(mass, values["radius"])
    click = acceleration.disc(mass, values["radius"], values.get("thickness", 0.0))
    return click._replace(strength=click.strength * math.cos(math.radians(values.get("tilt", 0.0))))
