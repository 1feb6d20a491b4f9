"""Grains of a world: many small bodies, or the counts of a particle engine, of which swarms are heard."""

from collections.abc import Iterable
from fnmatch import fnmatchcase

from .dsp.arguments import explain_all_arguments
from .scene import Scene
from .server.bridge.checks import WorldError
from .server.bridge.simulation import Simulation


@explain_all_arguments
class Grained:
    """Something that hears grains, of a simulation."""

    simulation: Simulation
    _scene: Scene | None

    def grains(self, name: str, bodies: str | Iterable[str] = (), *, striker: str = "") -> None:
        """Make bodies grains, or name a striker of which a particle engine tells by `pour`.

        Their blows are not heard one by one: their number, impulse and energy on each body make one swarm there, every
        20 ms, and so late. Grains neither slide nor roll, nor do they rest. bodies: names, or a pattern such as
        "stone*", of bodies that move; they sound as the first of them that rings. Call it before they touch anything.
        striker: a preset, such as rice. WorldError for a name that is taken, or for what cannot be.
        """
        if not isinstance(bodies, Iterable):
            raise WorldError(f"bodies = {bodies!r}: expected names, or a pattern")
        names = [body.name for body in self.simulation.bodies]
        if isinstance(bodies, str):
            chosen = [each for each in names if fnmatchcase(each, bodies)] or [bodies]
        else:
            chosen = list(bodies)
        numbers = [self.simulation.number(each) for each in chosen]
        exponent = self.simulation.grains.declare(name, numbers, striker)
        if self._scene:
            self._scene._open.engine.lay_out_pulses(exponent)  # a table that is made now, and not amid the steps

    def pour(
        self,
        name: str,
        on: str,
        count: float,
        *,
        speed: float | None = None,
        impulse: float | None = None,
        energy: float | None = None,
        position: float | None = None,
    ) -> None:
        """Add blows of grains on a body, as a particle engine has counted them since the last step.

        name: of grains with a striker. count: how many; it need not be whole. speed (m/s, rms), impulse (N s, of all of
        them) or energy (J): at least one of the three; what is left out is as of a gas. position: 0 to 1 along the
        body's strike path. WorldError for a name that is not there, or a value that cannot be.
        """
        number, told = self.simulation.number(on), {"speed": speed, "impulse": impulse, "energy": energy}
        self.simulation.grains.pour(name, number, count, position, **told)
