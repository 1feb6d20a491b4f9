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
        """Make bodies grains, or name a striker whose blows a particle engine reports by `pour`.

        Every 20 ms the number, impulse and energy of their blows on each body make one shake there. Grains neither
        slide nor roll nor rest. Call it before they touch anything.

        Parameters
        ----------
        name : str
            Name of the grains.
        bodies : str or list of str, optional
            Names, or a pattern such as "stone*", of bodies that move; they sound as the first of them that rings.
        striker : str, optional
            Preset of a striker, such as rice.

        Raises
        ------
        WorldError
            An argument is refused, such as a name that is taken.
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

        Parameters
        ----------
        name : str
            Name of grains with a striker.
        on : str
            Name of the body.
        count : float
            Number of blows; it need not be whole.
        speed, impulse, energy : float, optional
            Rms speed (m/s), impulse (N s) and energy (J) of all blows; at least one.
        position : float, optional
            0 to 1 on the body's strike path.

        Raises
        ------
        WorldError
            A name that is not there, or a value that cannot be.
        """
        number, told = self.simulation.number(on), {"speed": speed, "impulse": impulse, "energy": energy}
        self.simulation.grains.pour(name, number, count, position, **told)
