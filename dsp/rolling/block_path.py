"""The path under a body over a sample as a contact that is solved in blocks needs it (contact/block.py): lines of least
squares."""

from ..contact.block_nodes import AT
from ..contact.block_records import Block, forces_of
from ..contact.coupled_records import Coupled
from ..native.jit import kernel


@kernel
def project_path(contact: Coupled, block: Block) -> None:
    """Write the path of a coupled contact over its coming sample, parabolas that meet in kinks, as lines.

    In each part of the sample both its height and its rate become the lines of least squares. For a parabola those pass
    through it at the nodes; what follows a kink is added, on [0, 1] of the part: u from the kink on, f(u) = b u + c u^2
    has the line p + 3 q (2 t - 1) with p = int f, q = int (2 t - 1) f.
    """
    block.rise = contact.rise + contact.bend
    for i in range(forces_of(block)):
        at = AT[block.parts, i]
        block.height[i] = at * (contact.rise + at * contact.bend)
        block.slope[i] = contact.rise + 2.0 * at * contact.bend
    for n in range(contact.kinks):
        _add_kink(block, contact.kink_at[n], contact.kink_rise[n], contact.kink_bend[n])


@kernel
def _add_kink(block: Block, kink: float, rise: float, bend: float) -> None:
    """Add what a kink changes."""
    left, parts = 1.0 - kink, block.parts
    block.rise += left * (rise + left * bend)
    inside = min(int(parts * kink), parts - 1)
    t = parts * kink - inside
    d = 1.0 - t
    b, c = rise / parts, bend / (parts * parts)
    height = d * d * (0.5 * b + d * c / 3.0)
    height_tilt = (2.0 * t - 1.0) * height + 2.0 * d * d * d * (b / 3.0 + 0.25 * d * c)
    slope = parts * d * (b + d * c)
    slope_tilt = (2.0 * t - 1.0) * slope + 2.0 * parts * d * d * (0.5 * b + 2.0 * d * c / 3.0)
    for i in range(forces_of(block)):
        at = AT[parts, i]
        if at * parts >= inside + 1.0:
            after = at - kink
            block.height[i] += after * (rise + after * bend)
            block.slope[i] += rise + 2.0 * after * bend
        elif at * parts >= inside:
            x = 3.0 * (2.0 * (parts * at - inside) - 1.0)
            block.height[i] += height + x * height_tilt
            block.slope[i] += slope + x * slope_tilt
