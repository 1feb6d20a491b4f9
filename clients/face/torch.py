"""Items of a recipe for PyTorch, rendered as they are requested (`pip install 'carom[torch]'`).

import carom.torch
from torch.utils.data import DataLoader

if __name__ == "__main__":  # as the loader's processes import this file
    for batch in DataLoader(carom.torch.Items("impacts", range(1_000)), batch_size=32, num_workers=2):
        print(batch["sound"].shape, batch["factors"]["impact.velocity"])
"""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import torch
from torch.utils.data import IterableDataset, get_worker_info

from .clients.dataset.stream import Folders, Given, checked, rows, valid

Row = dict[str, Any]


def sound_and_factors(row: Row) -> Row:
    """Return an item's number, its `sound`, float32 (channels, frames) in pascals, and its factors."""
    return {"item": row["item"], "sound": torch.from_numpy(row["sound"].T.copy()), "factors": row["factors"]}


class Items(IterableDataset[Any]):
    """Items of a recipe, one after the other, without files. The processes of a DataLoader share the numbers.

    Parameters
    ----------
    recipe, numbers, presets
        As for `carom.render_many`.
    select : callable, optional
        What a loader gets of a row. Default: number, sound and factors. A loader cannot join lists of different
        lengths.

    Raises
    ------
    PresetError
        The recipe is refused; the text says why.
    """

    def __init__(
        self,
        recipe: Given,
        numbers: Sequence[int] | None = None,
        *,
        select: Callable[[Row], Any] = sound_and_factors,
        presets: Folders = (),
    ) -> None:
        super().__init__()
        self._recipe, self._folders = checked(recipe, presets)
        self._numbers = range(self._recipe.count) if numbers is None else numbers
        self._select = select

    def __iter__(self) -> Iterator[Any]:
        """Yield what is selected of each item; in a process of a loader, of its share of them."""
        info = get_worker_info()
        own = range(info.id, len(self._numbers), info.num_workers) if info else range(len(self._numbers))
        numbers = valid(self._recipe, (self._numbers[n] for n in own))
        return map(self._select, rows(self._recipe, self._folders, numbers))
